"""Base of the legged robots in the world: their joints in the model, true state and PD targets."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agentrob.sim.world.scene import Start

Array = NDArray[np.float64]

#: One control period: every robot computes its targets once, then the physics advances.
PERIOD_S = 0.02


@dataclass(frozen=True, slots=True)
class Drive:
    """The joint command of one control period: targets in rad and factors on the PD gains."""

    target_rad: Array
    kp_factor: float = 1.0
    kd_factor: float = 1.0


@dataclass(frozen=True, slots=True)
class Build:
    """Constants of a kind of robot. `kp`, `kd`, `torque_nm` are per joint (n,)."""

    root: str
    joints: tuple[str, ...]
    kp: Array
    kd: Array
    torque_nm: Array
    rest_rad: Array
    height_m: float


class Legged:
    """One robot's body in the model. Subclasses compute the joint targets of each period in `drive()`."""

    build: Build
    #: Where the body is led without physics, now: root pose (7,: x, y, z, quaternion) and joints (n,). None: physics.
    led: tuple[Array, Array] | None = None

    def __init__(self, name: str, start: Start | None) -> None:
        """Without `start` it starts at the world's place for this name."""
        self.name = name
        self.start = start

    # ------------------------------------------------------------------ in the model
    def add_to(self, spec: Any, collision_group: int) -> None:
        """Put the robot's model into the world's `mujoco.MjSpec`, names prefixed by `<name>/`."""
        raise NotImplementedError

    def bind(self, model: Any, data: Any) -> None:
        """Look up this robot's joints in the compiled model."""
        self.model, self.data = model, data
        joints = [model.joint(f"{self.name}/{joint}").id for joint in self.build.joints]
        self.q, self.v = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
        self.body = int(model.body(f"{self.name}/{self.build.root}").id)
        free = model.body_jntadr[self.body]
        self.root_q, self.root_v = int(model.jnt_qposadr[free]), int(model.jnt_dofadr[free])
        self.geoms = model.body_rootid[model.geom_bodyid] == self.body

    def place(self) -> None:
        """Put the robot at its start, at rest."""
        start, data = self.start, self.data
        assert start is not None
        half = start.yaw_rad / 2
        root = [start.x_m, start.y_m, self.build.height_m, math.cos(half), 0.0, 0.0, math.sin(half)]
        data.qpos[self.root_q : self.root_q + 7] = root
        data.qpos[self.q] = self.build.rest_rad
        data.qvel[self.root_v : self.root_v + 6] = 0.0
        data.qvel[self.v] = 0.0
        self.begin()

    def begin(self) -> None:
        """Forget all commands."""
        raise NotImplementedError

    def drive(self) -> Drive:
        """Compute the joint command. Called once per control period, before the physics."""
        raise NotImplementedError

    def follow(self) -> None:
        """Apply the pose of an animation, at rest."""
        if self.led is None:
            return
        root, joints = self.led
        data = self.data
        data.qpos[self.root_q : self.root_q + 7], data.qpos[self.q] = root, joints
        data.qvel[self.root_v : self.root_v + 6] = 0.0
        data.qvel[self.v] = 0.0

    # ------------------------------------------------------------------ true state
    @property
    def xy_m(self) -> Array:
        return np.array(self.data.qpos[self.root_q : self.root_q + 2])

    @property
    def z_m(self) -> float:
        return float(self.data.qpos[self.root_q + 2])

    @property
    def rotation(self) -> Array:
        """(3, 3): the body's axes in the world."""
        return np.asarray(self.data.xmat[self.body].reshape(3, 3))

    @property
    def yaw_rad(self) -> float:
        r = self.rotation
        if self.led is not None:  # perhaps over its back: its left side keeps its direction
            return math.atan2(-r[0, 1], r[1, 1])
        return math.atan2(r[1, 0], r[0, 0])

    @property
    def upright(self) -> float:
        """Cosine of the tilt: 1 upright, 0 on its side, -1 upside down."""
        return float(self.rotation[2, 2])

    @property
    def gyro_rps(self) -> Array:
        """(3,) angular velocity in the body's frame."""
        return np.array(self.data.qvel[self.root_v + 3 : self.root_v + 6])

    @property
    def joints_rad(self) -> Array:
        return np.array(self.data.qpos[self.q])

    @property
    def joint_speeds_rps(self) -> Array:
        return np.array(self.data.qvel[self.v])

    def heading_velocity(self) -> Array:
        """(vx, vy, yaw rate) in the level frame that turns with the robot."""
        vx, vy = self.data.qvel[self.root_v : self.root_v + 2]
        yaw = self.yaw_rad
        c, s = math.cos(yaw), math.sin(yaw)
        return np.array([c * vx + s * vy, -s * vx + c * vy, (self.rotation @ self.gyro_rps)[2]])

    def touching(self) -> list[str]:
        """Names of the things (not the floor) or robots that this robot touches now."""
        names = set()
        for pair in self.data.contact.geom:
            mine = self.geoms[pair]
            if mine[0] == mine[1]:
                continue
            other = int(pair[1] if mine[0] else pair[0])
            body = self.model.body(self.model.geom_bodyid[other]).name
            names.add(body.split("/")[0] if "/" in body else self.model.geom(other).name)
        return sorted(names - {"floor"})
