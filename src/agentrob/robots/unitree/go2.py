"""The Unitree Go2 quadruped, through the official SDK's clients: the same for a real one and for the simulated one.

Unverified on hardware: the order and origin of `range_obstacle`, the modes below, how soon it walks after standing up.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError
from agentrob.model import ActionResult, Capabilities, Op, Outcome, Pose, Posture, Primitive, RobotState
from agentrob.robots.control.controller import Gait, Velocity
from agentrob.robots.control.step_runner import not_begun, run_step
from agentrob.robots.protocol import Watch, limits_of
from agentrob.robots.unitree import robot as unitree_robot
from agentrob.robots.unitree import sdk
from agentrob.robots.unitree.robot import (
    IMAGE_TIMEOUT_S,
    WRITE_TIMEOUT_S,
    JointAngles,
    UnitreeRobot,
    failed,
    gesture_timeout_s,
    poses,
    posture_of,
    refused,
)

GAIT = Gait(speed_mps=1.0, side_mps=0.3, turn_rps=math.radians(90))

#: The longest gesture takes about 8 s; with a shorter timeout, one that succeeds would be reported as failed.
GESTURE_TIMEOUT_S = 15.0
#: After standing up a Go2 may ignore Move for 4 to 10 s although it answers 0.
START_AFTER_STANDING_S = 10.0

#: `sportmodestate.error_code` carries the mode in newer firmware, `mode` in older.
MODES_BY_CODE = {
    100: "idle", 1001: "damping", 1002: "locked", 1004: "lying", 1006: "gesture", 1007: "sitting", 1013: "idle",
    1015: "walking", 2013: "gesture",
}  # fmt: skip
MODES_BY_MODE = {
    0: "idle", 1: "idle", 2: "gesture", 3: "walking", 5: "lying", 6: "locked", 7: "damping", 8: "gesture", 9: "gesture",
    10: "sitting", 11: "gesture", 12: "gesture", 13: "gesture",
}  # fmt: skip
STOP_MOVE = 1003
UNSUITABLE = 4206
#: Upper bound of a flip, including coming to rest before it; a robot that lies on its back after this has fallen.
FLIP_S = 8.0
CAPABILITIES = Capabilities(
    "go2",
    frozenset({Op.MOVE, Op.TURN, Op.HELLO, Op.HEART, Op.BACKFLIP, Op.SIT, Op.STAND, Op.STRETCH, Op.GET_FRONT_IMAGE}),
)


class Go2(UnitreeRobot):
    """See `agentrob.robots.protocol.Robot`. Construction takes about a second and needs no robot to be there yet.

    Raises `RobotUnreachable` when DDS cannot be opened on the interface of the settings.
    """

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """Return its capabilities without connecting. The simulated flip is an animation; its result says so."""
        return replace(CAPABILITIES, limits=limits_of(settings), simulated=settings.simulated)

    def __init__(self, settings: RobotConfig) -> None:
        super().__init__(simulated=settings.simulated)
        if settings.options:
            raise RobotError(f"a go2 has no options (found: {', '.join(sorted(settings.options))})")
        self.capabilities = self.describe(settings)
        limits = self.capabilities.limits
        self._gait = GAIT.at_most(limits.speed_mps, math.radians(limits.turn_dps))
        sdk.connect(settings.domain, settings.interface)

        from unitree_sdk2py.go2.sport.sport_client import SportClient
        from unitree_sdk2py.go2.video.video_client import VideoClient
        from unitree_sdk2py.idl.unitree_go.msg.dds_ import LowState_, SportModeState_

        self._state = sdk.Topic("rt/sportmodestate", SportModeState_, self._heard)
        self._low = sdk.PolledTopic("rt/lowstate", LowState_, every_s=2.0)
        self._joints = JointAngles(self._low, 12)
        makers: tuple[tuple[Callable[[], Any], float], ...] = (
            (SportClient, gesture_timeout_s(GESTURE_TIMEOUT_S, simulated=settings.simulated)),
            (SportClient, WRITE_TIMEOUT_S),
            (SportClient, WRITE_TIMEOUT_S),
            (VideoClient, IMAGE_TIMEOUT_S),
        )
        self._actions, self._moves, self._stopper, self._video = sdk.clients(*makers)
        self._flip_began_s = -math.inf
        self._gestures: dict[str, tuple[Callable[[], int], ...]] = {
            Op.HELLO: (self._actions.Hello,),
            Op.HEART: (self._actions.Heart,),
            Op.BACKFLIP: (self._actions.BackFlip,),
            Op.SIT: (self._actions.Sit,),
            Op.STAND: (self._actions.RecoveryStand, self._actions.BalanceStand),
            Op.STRETCH: (self._actions.Stretch,),
        }

    # ------------------------------------------------------------ the robot
    def _recent(self) -> tuple[tuple[float, Pose], ...]:
        return poses(self._state)

    def state(self) -> RobotState:
        newest = self._state.newest()
        if newest is None:
            return RobotState(age_s=math.inf)
        came_s, message = newest
        battery = self._low.newest
        percent = float(battery.bms_state.soc) if battery is not None else None
        state = replace(read(message), age_s=time.monotonic() - came_s, battery_percent=percent)
        return replace(state, upright=True, mode="gesture") if self._flipping and state.mode == "fallen" else state

    def posture(self, *, joints: bool) -> Posture:
        return posture_of(self._state.newest(), self._joints.now() if joints else ())

    @property
    def _flipping(self) -> bool:
        """Whether it may be upside down because of a commanded flip, which is not a fall."""
        return self._gesturing and self.now_s() < self._flip_began_s + FLIP_S

    def close(self) -> None:
        self._send_stop()
        self._low.close()

    # ------------------------------------------------------------ the body (agentrob.robots.control.step_runner.Body)
    def command(self, velocity: Velocity) -> None:
        self._moves.Move(*(float(v) for v in velocity))  # answers 0 even when the robot is frozen: odometry decides

    def rest(self) -> None:
        self._moves.Move(0.0, 0.0, 0.0)
        self._moves._CallNoReply(STOP_MOVE, "{}")

    # ------------------------------------------------------------ steps
    def _send_stop(self) -> bool:
        codes = [self._stopper._CallNoReply(STOP_MOVE, "{}"), self._stopper.Move(0.0, 0.0, 0.0)]
        return 0 in codes

    def _do(self, primitive: Primitive, watch: Watch) -> ActionResult:
        if primitive.op in (Op.MOVE, Op.TURN):
            return self._walk(primitive, watch)
        return self._do_gesture(primitive, watch)

    def _walk(self, primitive: Primitive, watch: Watch) -> ActionResult:
        gait, state, started_s = self._gait, self.state(), time.monotonic()
        if state.mode in ("sitting", "lying", "damping"):
            return refused(primitive, "posture", f"The robot is {state.mode}; it must stand up first.")
        if reason := watch(state):  # before anything is sent to the robot
            return not_begun(primitive, reason, started_s)
        if state.mode in ("locked", "unknown"):
            if code := self._actions.BalanceStand():
                return failed(primitive, code, "It could not stand ready to walk", started_s)
            gait = replace(gait, start_s=START_AFTER_STANDING_S)
        return run_step(self, primitive, gait, watch)

    def _do_gesture(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """Run the robot's built-in motion to its end; a reason of the watch prevents further calls and is reported."""
        started_s = time.monotonic()
        if reason := watch(self.state()):
            return not_begun(primitive, reason, started_s)
        if primitive.op is Op.BACKFLIP:
            self._flip_began_s = self.now_s()
        gesture = self._begin_gesture(self._gestures[primitive.op], watch, GESTURE_TIMEOUT_S)
        gesture.follow()
        if reason := gesture.reason:
            self._send_stop()
            message = f"Stopped ({reason.replace('_', ' ')}); the robot may end the gesture by itself."
            return ActionResult(primitive, Outcome.STOPPED, {}, reason, message, started_s, time.monotonic())
        name = str(primitive.op).capitalize()
        if gesture.unanswered:
            return failed(primitive, sdk.LATE, f"{name} was not done", started_s)
        if gesture.code == UNSUITABLE and primitive.op is Op.BACKFLIP:
            return refused(primitive, "obstacle", f"The robot refused to flip: {sdk.explain(UNSUITABLE)}.")
        if gesture.code:
            return failed(primitive, gesture.code, f"{name} was not done", started_s)
        animated = primitive.op is Op.BACKFLIP and self.capabilities.simulated
        return ActionResult(
            primitive, Outcome.DONE, {}, "", f"{name}: done.", started_s, time.monotonic(), animated=animated
        )


def read(message: Any) -> RobotState:
    """A `SportModeState_` as a state of age 0."""
    state = unitree_robot.read(message)
    code = int(message.error_code)
    mode = MODES_BY_CODE.get(code) or (MODES_BY_MODE.get(int(message.mode), "unknown") if code == 0 else "unknown")
    front, left, back, right = (float(r) if math.isfinite(r) else None for r in message.range_obstacle)
    mode = "fallen" if state.upright is False else mode
    return replace(state, mode=mode, ranges_m=(front, left, back, right), error_code=code)
