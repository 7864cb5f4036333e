"""The arm's world: a table, the arm on it, a red cube, and a camera above its far edge. Physics by MuJoCo.

Faults can be injected, as tests do; the true state tells what really happened.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from agentrob_so101.kinematics import HAND, JAW, MODEL, Array, so101
from agentrob_so101.operations import HOME_POSE
from agentrob_so101.picking import CAMERA_M, CUBE_M, FOV_DEG, camera_axes
from agentrob_so101.pose import JOINTS, NAMES, ArmPose, action_of, pose_of

STEP_S, SETTLED_S = 0.002, 1.0
#: The table top, around the point before the arm: x, y, height above the floor. The arm's foot is at the origin.
TABLE_M, TABLE_AT_M, TABLE_HIGH_M = (0.80, 1.00), (0.20, 0.0), 0.74
#: The red cube: its mass, and where it lies at the start.
CUBE_KG, CUBE_AT_M = 0.030, (0.24, -0.10)
#: Positions are reported in the steps of the servos' encoders.
TICK_DEG = 360.0 / 4096
#: The units that the fault `units` tells positions in, by how many of them a degree is.
UNITS = {"": 1.0, "radians": np.pi / 180, "ticks": 4096 / 360}
ROOM_GROUP, ARM_GROUP = 0, 2


@dataclass(slots=True)
class Faults:
    """Injected faults. `silent`: it answers nothing. `frozen`: it repeats its last positions. `limp`: its servos have
    no torque. `units`: see `UNITS`. `push`: a torque on the pan joint, in N·m. `deaf`: it refuses goals."""

    silent: bool = False
    frozen: bool = False
    limp: bool = False
    deaf: bool = False
    units: str = ""
    push: float = 0.0


@dataclass(slots=True)
class World:
    """Call `advance` with the seconds that passed. Not thread-safe."""

    faults: Faults = field(default_factory=Faults)
    model: Any = field(init=False)
    data: Any = field(init=False)
    acted: int = 0
    #: The goals that came: when (monotonic), and the pose.
    goals: deque[tuple[float, list[float]]] = field(default_factory=lambda: deque(maxlen=20_000))
    _last: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.model = build().compile()
        self.data = mujoco.MjData(self.model)
        self.put(HOME_POSE)

    def place(self, pose: ArmPose) -> None:
        """Place the arm at a pose, without letting time pass."""
        for name, angle in so101().radians(pose).items():
            self.data.joint(name).qpos[0], self.data.joint(name).qvel[0] = angle, 0.0
            self.data.actuator(name).ctrl[0] = angle
        mujoco.mj_forward(self.model, self.data)

    def put(self, pose: ArmPose) -> None:
        """Place the arm at a pose, and let it come to rest there."""
        self.place(pose)
        self.advance(SETTLED_S)

    def put_cube(self, x_m: float, y_m: float, turned_rad: float = 0.0) -> None:
        """Put the cube on the table."""
        cube = self.data.joint("cube")
        cube.qpos[:] = (x_m, y_m, CUBE_M / 2, np.cos(turned_rad / 2), 0.0, 0.0, np.sin(turned_rad / 2))
        cube.qvel[:] = 0.0
        mujoco.mj_forward(self.model, self.data)

    def advance(self, seconds: float) -> None:
        self.data.joint("shoulder_pan").qfrc_applied[0] = self.faults.push
        for actuator in range(self.model.nu):
            self.model.actuator_forcelimited[actuator] = 1
            most = 0.0 if self.faults.limp else 3.35
            self.model.actuator_forcerange[actuator] = (-most, most)
        for _ in range(round(seconds / STEP_S)):
            mujoco.mj_step(self.model, self.data)

    def observe(self) -> dict[str, float]:
        """The positions of LeRobot's observation. Raises `TimeoutError` while it is silent."""
        if self.faults.silent:
            raise TimeoutError("silent")
        if not (self.faults.frozen and self._last):
            pose = self.pose()
            ticks = ArmPose._make((*(round(v / TICK_DEG) * TICK_DEG for v in pose.joints), round(pose.gripper, 2)))
            scale = UNITS[self.faults.units]
            self._last = action_of(ticks._replace(**{name: getattr(ticks, name) * scale for name in JOINTS}))
        return self._last

    def act(self, action: dict[str, Any]) -> dict[str, float]:
        """Take goals. Raises `TimeoutError` while it is silent, `ValueError` for what is not an action."""
        if self.faults.silent:
            raise TimeoutError("silent")
        if self.faults.deaf:
            raise ValueError("the servos refuse goals")
        goal = pose_of(action)
        low, high = so101().lowest, so101().highest
        goal = ArmPose(*(max(a, min(b, v)) for a, v, b in zip(low, goal, high, strict=True)))
        for name, angle in so101().radians(goal).items():
            self.data.actuator(name).ctrl[0] = angle
        self.acted += 1
        self.goals.append((time.monotonic(), list(goal)))
        return action_of(goal)

    def apply(self, what: dict[str, Any]) -> dict[str, Any]:
        """Change faults or the cube; return what is true: the pose, the goal, the cube, how many actions came."""
        answer: dict[str, Any] = {}
        for name, value in what.items():
            if name == "cube":  # [x, y, turned_rad]
                self.put_cube(*value)
            elif name == "goals":  # since the last time that they were asked for
                answer["goals"] = list(self.goals)
                self.goals.clear()
            elif name == "put":  # a pose, by name
                self.put(pose_of(value))
            else:
                setattr(self.faults, name, value)
        goal = so101().pose({name: float(self.data.actuator(name).ctrl[0]) for name in NAMES})
        cube = [float(v) for v in self.data.body("cube").xpos]
        return {**answer, "pose": list(self.pose()), "goal": list(goal), "cube": cube, "acted": self.acted}

    def pose(self) -> ArmPose:
        """The true pose of the arm."""
        return so101().pose({name: float(self.data.joint(name).qpos[0]) for name in NAMES})

    def drawn(self) -> Array:
        """A copy of all that a picture needs (nq,)."""
        copied: Array = self.data.qpos.copy()
        return copied


def build() -> Any:
    """The specification of the world (`mujoco.MjSpec`)."""
    spec = mujoco.MjSpec.from_file(str(MODEL))
    spec.option.timestep = STEP_S
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.noslip_iterations = 5
    for geom in spec.geoms:
        _grips(geom)
    _room(spec)
    cube = spec.worldbody.add_body(name="cube", pos=(*CUBE_AT_M, CUBE_M / 2))
    cube.add_freejoint(name="cube")
    cube.add_geom(
        name="cube", type=mujoco.mjtGeom.mjGEOM_BOX, size=[CUBE_M / 2] * 3, mass=CUBE_KG, rgba=(0.83, 0.10, 0.10, 1.0),
        friction=(1.0, 0.01, 0.001), condim=4, group=ROOM_GROUP,
    )  # fmt: skip
    return spec


def _grips(geom: Any) -> None:
    """Let the pads of the jaws touch things instead of the hulls of the jaws' meshes, which fill the gripper."""
    pad = geom.name.endswith("_jaw_pad")
    if pad:
        geom.contype = geom.conaffinity = 1
        geom.friction, geom.condim = (1.5, 0.02, 0.001), 4
    elif geom.parent.name in (HAND, JAW):
        geom.contype, geom.conaffinity = 2, 0  # it meets nothing, and rays still find it


def _room(spec: Any) -> None:
    box, plane = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_PLANE
    spec.add_texture(
        name="floor", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        width=64, height=64, rgb1=(0.62, 0.58, 0.52), rgb2=(0.58, 0.54, 0.48),
    )  # fmt: skip
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        width=64, height=384, rgb1=(0.80, 0.85, 0.90), rgb2=(0.55, 0.62, 0.70),
    )  # fmt: skip
    floor = spec.add_material(name="floor", texrepeat=(2, 2), texuniform=True)
    floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    world = spec.worldbody
    world.add_geom(name="floor", type=plane, size=(3, 3, 0.1), pos=(0, 0, -TABLE_HIGH_M), material="floor")
    size, (x, y) = (TABLE_M[0] / 2, TABLE_M[1] / 2, 0.015), TABLE_AT_M
    world.add_geom(name="table", type=box, size=size, pos=(x, y, -0.015), rgba=(0.72, 0.53, 0.34, 1.0))
    for n, (side_x, side_y) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1))):
        at = x + side_x * (size[0] - 0.04), y + side_y * (size[1] - 0.04), -TABLE_HIGH_M / 2 - 0.015
        world.add_geom(
            name=f"leg{n}", type=box, size=(0.02, 0.02, TABLE_HIGH_M / 2 - 0.015), pos=at, rgba=(0.5, 0.36, 0.24, 1.0)
        )
    world.add_light(pos=(0.4, -0.5, 1.6), dir=(-0.2, 0.3, -1.0), diffuse=(0.7, 0.7, 0.7))
    spec.visual.headlight.ambient = (0.35, 0.35, 0.35)
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1280, 720
    world.add_camera(name="table", pos=CAMERA_M, quat=_looking(), fovy=FOV_DEG)


def _looking() -> Array:
    """The attitude (w, x, y, z) of the camera."""
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, camera_axes().ravel())
    return quaternion
