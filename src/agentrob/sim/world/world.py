"""One MuJoCo world with any number of robots: `tick()` advances everything by one control period of 20 ms.

It has no clock and no network: its owner decides how fast it runs. Only one thread may tick it; `pose` is a copy
that other threads may read at any time: the joints (nq,), then where the box is (3,).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from agentrob.errors import SimError
from agentrob.sim.world import room, scene
from agentrob.sim.world.legged import PERIOD_S, Array, Legged

TIME_STEP_S = 0.0025
SUB_STEPS = round(PERIOD_S / TIME_STEP_S)
SETTLE_S = 1.2  # from being placed to standing still
ROBOT_GROUP = 2  # what robots look like
FIRST_ROBOT_GROUP = 3  # collision shapes of robot k are in group 3 + k, so that its own rays can leave them out
BOX_FREE_M = 0.65  # between the middles of a robot and of the box: half a robot and half a box at their longest
MOST_ROBOTS = 3  # MuJoCo has six groups


class World:
    """A scene (without one: the shipped `room`) with robots standing at their starts.

    `time_s` is simulated time and never goes back, not even on `reset`.
    """

    def __init__(self, robots: Sequence[Legged], place: scene.Scene | None = None) -> None:
        if not 1 <= len(robots) <= MOST_ROBOTS:
            raise SimError(f"a world has 1 to {MOST_ROBOTS} robots, not {len(robots)}")
        self.scene = scene.load() if place is None else place
        self.robots = tuple(robots)
        for robot in self.robots:
            robot.start = robot.start or self.scene.place(robot.name).start
        self.model = specification(self.robots, self.scene).compile()
        self.data = mujoco.MjData(self.model)
        for robot in self.robots:
            robot.bind(self.model, self.data)
        self._q = np.concatenate([r.q for r in self.robots])
        self._v = np.concatenate([r.v for r in self.robots])
        self._kp = np.concatenate([r.build.kp for r in self.robots])
        self._kd = np.concatenate([r.build.kd for r in self.robots])
        self._bound = np.concatenate([r.build.torque_nm for r in self.robots])
        self.ticks = 0
        self.reset()

    @property
    def time_s(self) -> float:
        return self.ticks * PERIOD_S

    def reset(self) -> None:
        """Everything back to its start, the robots standing still."""
        mujoco.mj_resetData(self.model, self.data)
        for robot in self.robots:
            robot.place()
        mujoco.mj_forward(self.model, self.data)
        self.run(SETTLE_S)

    def put_box(self, at_m: tuple[float, float] | None) -> bool:
        """Stand the box on a place of the room, or take it away; False when a robot stands there."""
        if at_m is not None and any(np.hypot(*(r.xy_m - at_m)) < BOX_FREE_M for r in self.robots):
            return False
        self.data.mocap_pos[0] = room.BOX_AWAY_M if at_m is None else (*at_m, room.BOX_SIZE_M[2])
        mujoco.mj_kinematics(self.model, self.data)  # so that it is seen at once
        return True

    def _copy_pose(self) -> None:
        self.pose: Array = np.concatenate([self.data.qpos, self.data.mocap_pos.ravel()])

    def tick(self) -> None:
        """One control period: every robot decides, then the physics."""
        drives = [robot.drive() for robot in self.robots]
        target = np.concatenate([d.target_rad for d in drives])
        counts = [len(d.target_rad) for d in drives]
        kp = self._kp * np.repeat([d.kp_factor for d in drives], counts)
        kd = self._kd * np.repeat([d.kd_factor for d in drives], counts)
        data, q, v = self.data, self._q, self._v
        at, speed, force = (
            data.qpos,
            data.qvel,
            data.qfrc_applied,
        )  # views: looking them up costs more than reading them
        for _ in range(SUB_STEPS):
            torque = kp * (target - at[q]) - kd * speed[v]
            force[v] = np.minimum(np.maximum(torque, -self._bound), self._bound)
            mujoco.mj_step(self.model, data)
            for robot in self.robots:
                robot.follow()
        self.ticks += 1
        self._copy_pose()

    def run(self, seconds: float) -> None:
        """Tick for some simulated time, as fast as it goes."""
        for _ in range(round(seconds / PERIOD_S)):
            self.tick()


def specification(robots: Sequence[Legged], place: scene.Scene) -> Any:
    """The room with its robots as a `mujoco.MjSpec`."""
    spec = mujoco.MjSpec()
    spec.option.timestep = TIME_STEP_S
    # The walking policies were tuned with these contacts; the defaults let the feet slip.
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 100
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1280, 720
    spec.visual.map.znear, spec.stat.extent = 0.01, 4
    room.furnish(spec, place)
    for k, robot in enumerate(robots):
        robot.add_to(spec, FIRST_ROBOT_GROUP + k)
    return spec
