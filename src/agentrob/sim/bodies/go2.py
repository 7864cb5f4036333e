"""The Unitree Go2's body in the world: walking by its policy, standing still, poses, the flip, and damping."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from agentrob.sim.bodies import go2_policy
from agentrob.sim.bodies.go2_policy import COMMAND_SLEW, STAND_RAD
from agentrob.sim.world import assets
from agentrob.sim.world.legged import PERIOD_S, Array, Build, Drive, Legged
from agentrob.sim.world.scene import Start

#: Velocities that the policy follows well: forward, sideways (m/s), turning (rad/s). The real robot's: 3.8, 1 and 4.
VELOCITY_BOUND: Array = np.array([1.0, 0.5, 1.5])

ARMATURE, DAMPING, FRICTION = 0.00712, 0.285, 0.365  # of a joint, as measured on the real motors
TORQUE_NM: Array = np.array([23.7, 23.7, 45.43] * 4)
CAMERA_AT_M, CAMERA_FOVY_DEG = [0.32715, 0.0, 0.04297], 60

# The policy drifts and turns when commanded to stand, so the joints are locked once the body has come to rest.
CALM_MPS, CALM_RPS = 0.12, 0.35  # slower than this is calm
CALM_S, LEAST_STILL_S = 0.10, 0.25  # calm for so long, and at least so long after the command ended
# Locked in mid-stride it may lean and topple: then the policy takes over again until the body stands upright.
LEAN_UPRIGHT, LEAN_MPS = 0.985, 0.20
LOCK_BLEND_S, LOCK_STIFFNESS = 0.40, 2.5
SETTLED_S = LOCK_BLEND_S + 0.2  # locked for so long
BRAKE_KEEP = 0.8  # of the trim, each period while braking
LIMP_DAMPING = 4.0  # factor on KD: what the real robot's damping mode feels like
BUILD = Build(
    root="base",
    joints=go2_policy.JOINTS,
    kp=np.full(12, go2_policy.KP),
    kd=np.full(12, go2_policy.KD),
    torque_nm=TORQUE_NM,
    rest_rad=STAND_RAD,
    height_m=0.33,
)

#: A pose player: seconds since its start in, joint targets (12, rad) and stiffness factor out, None when it has ended.
Player = Callable[[float], tuple[Array, float] | None]


class Animation(Protocol):
    """Moves the whole body without physics; see `agentrob.sim.bodies.flip.Flight`."""

    def __call__(self, t: float) -> tuple[float, float, Array] | None: ...

    def airborne(self, t: float) -> bool: ...


class Go2(Legged):
    """Follows `walk(vx, vy, yaw_rate)`, plays poses and holds the last one, or is limp."""

    build = BUILD

    def __init__(self, name: str = "go2", start: Start | None = None) -> None:
        super().__init__(name, start)
        self._policy = go2_policy.WalkingPolicy(assets.policy("go2"))
        self._trim = go2_policy.VelocityTrim()

    def add_to(self, spec: Any, collision_group: int) -> None:
        import mujoco

        path = assets.model("go2")
        robot = mujoco.MjSpec.from_file(str(path))
        robot.meshdir = str(path.parent / "assets")
        ahead = [0, -1, 0, 0, 0, 1]
        robot.body("base").add_camera(name="front", pos=CAMERA_AT_M, xyaxes=ahead, fovy=CAMERA_FOVY_DEG)
        for name in self.build.joints:
            joint = robot.joint(name)
            joint.armature, joint.frictionloss, joint.damping = ARMATURE, FRICTION, [DAMPING, 0, 0]
        for geom in robot.geoms:
            if geom.classname.name in ("collision", "foot"):
                geom.group = collision_group
        for part in (*robot.keys, *robot.actuators, *robot.lights):
            robot.delete(part)
        robot.option.cone, robot.option.impratio = spec.option.cone, spec.option.impratio
        robot.option.timestep = spec.option.timestep
        spec.attach(robot, prefix=f"{self.name}/", frame=spec.worldbody.add_frame())

    # ------------------------------------------------------------------ commands (by the world's thread)
    def begin(self) -> None:
        self._wanted = np.zeros(3)
        self._player: Player | None = None
        self._animation: Animation | None = None
        self._playing_s = 0.0
        self._last = Drive(STAND_RAD.copy())
        self._held: Drive | None = None
        self._limp = False
        self._start_walking()

    def walk(self, velocity: Array) -> None:
        """Walk at (vx, vy, yaw rate), clipped to `VELOCITY_BOUND`; zeros mean stand. Ends poses and `go_limp`."""
        if self._player or self._animation or self._held or self._limp:
            self._leave()
            self._start_walking()
        self._wanted = np.clip(velocity, -VELOCITY_BOUND, VELOCITY_BOUND)

    def play(self, player: Player) -> None:
        """Follow a pose player instead of the policy; afterwards its last pose is held until the next command."""
        self._leave()
        self._player, self._playing_s = player, 0.0

    def animate(self, animation: Animation) -> None:
        """Follow an animation instead of physics; afterwards its last pose is held until the next command."""
        self._leave()
        root = np.array(self.data.qpos[self.root_q : self.root_q + 7])
        self._animation, self._playing_s, self._led_from = animation, 0.0, (root, self.yaw_rad)

    def go_limp(self) -> None:
        """Only damp the joints."""
        self._leave()
        self._limp = True

    def _leave(self) -> None:
        """End the previous command."""
        self._wanted = np.zeros(3)
        self._player, self._animation, self._held, self._limp, self.led = None, None, None, False, None

    @property
    def playing(self) -> bool:
        return self._player is not None or self._animation is not None

    @property
    def airborne(self) -> bool:
        """Whether an animation has it in the air and cannot be interrupted."""
        return self._animation is not None and self._animation.airborne(self._playing_s)

    @property
    def standing(self) -> bool:
        """Whether it was commanded to stand and is at rest."""
        return self._lock_s is not None and not self._wanted.any()

    @property
    def settled(self) -> bool:
        """Whether it stands on locked joints in the standing pose, from which a pose player cannot tip it over."""
        return self.standing and self._lock_s is not None and self._lock_s >= SETTLED_S

    @property
    def target_rad(self) -> Array:
        """The joint targets of the last period."""
        return self._last.target_rad

    # ------------------------------------------------------------------ one period
    def drive(self) -> Drive:
        if self._limp:
            self._last = Drive(self.joints_rad, 0.0, LIMP_DAMPING)
        elif self._animation is not None:
            self._last = self._follow_leader()
        elif self._player is not None:
            self._last = self._pose()
        elif self._held is not None:
            self._last = self._held
        else:
            self._last = self._walk()
        return self._last

    def _pose(self) -> Drive:
        assert self._player is not None
        pose = self._player(self._playing_s)
        self._playing_s += PERIOD_S
        if pose is None:
            self._player, self._held = None, self._last
            return self._last
        target, stiffness = pose
        return Drive(target, stiffness, float(np.sqrt(stiffness)))

    def _follow_leader(self) -> Drive:
        assert self._animation is not None
        pose = self._animation(self._playing_s)
        self._playing_s += PERIOD_S
        if pose is None:
            self._animation, self.led, self._held = None, None, self._last
            return self._last
        rise_m, pitch_rad, joints = pose
        (x, y, z, *_), yaw_rad = self._led_from
        cy, sy, cp, sp = math.cos(yaw_rad / 2), math.sin(yaw_rad / 2), math.cos(pitch_rad / 2), math.sin(pitch_rad / 2)
        self.led = np.array([x, y, z + rise_m, cy * cp, -sy * sp, cy * sp, sy * cp]), joints
        return Drive(joints)

    def _start_walking(self) -> None:
        self._policy.reset()
        self._trim.reset()
        self._slewed = np.zeros(3)
        self._still_s = self._calm_s = 0.0
        self._braked = False
        self._lock_s: float | None = None
        self._lock_from = STAND_RAD

    def _walk(self) -> Drive:
        self._slewed += np.clip(self._wanted - self._slewed, -COMMAND_SLEW, COMMAND_SLEW)
        if self._wanted.any():
            self._still_s, self._lock_s, self._braked = 0.0, None, False
        elif self._lock_s is not None and self._leaning():
            self._policy.reset()
            self._lock_s, self._calm_s = None, 0.0
        elif self._lock_s is None:
            self._come_to_rest()
        if self._lock_s is not None:
            return self._locked()
        asked = self._trim.follow(self._slewed, self.heading_velocity())
        gravity = -self.rotation[2]
        target = self._policy.targets(self.gyro_rps, gravity, self.joints_rad, self.joint_speeds_rps, asked)
        return Drive(target)

    def _leaning(self) -> bool:
        vx, vy, _ = self.heading_velocity()
        return self.upright < LEAN_UPRIGHT or float(np.hypot(vx, vy)) > LEAN_MPS

    def _come_to_rest(self) -> None:
        vx, vy, turning = self.heading_velocity()
        slow = float(np.hypot(vx, vy)) < CALM_MPS
        self._still_s += PERIOD_S
        if not self._braked:
            self._trim.brake(BRAKE_KEEP)
        self._braked = self._braked or (self._still_s > LEAST_STILL_S and slow)
        self._calm_s = self._calm_s + PERIOD_S if slow and abs(turning) < CALM_RPS else 0.0
        if self._still_s > LEAST_STILL_S and self._calm_s > CALM_S and self.upright > LEAN_UPRIGHT:
            self._lock_s, self._lock_from = 0.0, self._last.target_rad.copy()

    def _locked(self) -> Drive:
        assert self._lock_s is not None
        self._lock_s += PERIOD_S
        done = min(1.0, self._lock_s / LOCK_BLEND_S)
        done = done * done * (3 - 2 * done)
        if done >= 1.0:
            self._policy.reset()
            self._trim.rest()
            self._slewed[:] = 0.0
        stiffness = 1 + (LOCK_STIFFNESS - 1) * done
        return Drive(self._lock_from + done * (STAND_RAD - self._lock_from), stiffness, float(np.sqrt(stiffness)))
