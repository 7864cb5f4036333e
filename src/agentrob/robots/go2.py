"""The Unitree Go2 quadruped, through the official SDK's clients: the same for a real one and for the simulated one.

Unverified on hardware: the order and origin of `range_obstacle`, the modes below, how soon it walks after standing up.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from agentrob.config import RobotConfig
from agentrob.errors import RobotError
from agentrob.model import ActionResult, Capabilities, Op, Outcome, Pose, Primitive, RobotState, StopResult
from agentrob.robots import unitree
from agentrob.robots.gesture import Gesture
from agentrob.robots.motion import RATE_HZ, STOPPED_WINDOW_S, Gait, Rest, Velocity, known
from agentrob.robots.robot import Watch, limits_of
from agentrob.robots.walk import REST_LIMIT_S, not_begun, walk

GAIT = Gait(speed_mps=1.0, side_mps=0.3, turn_rps=math.radians(90))

#: The longest gesture takes about 8 s; a shorter timeout would report a failure that is none.
GESTURE_TIMEOUT_S = 15.0
#: Commands of velocity and stops are written, not asked: they must never wait long for a robot that is not there.
WRITE_TIMEOUT_S = 0.15
IMAGE_TIMEOUT_S = 3.0
IMAGE_MAX_BYTES = 8 * 1024 * 1024
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
#: Cosine of the tilt below which it lies rather than stands (60 degrees).
UPRIGHT = 0.5

#: A standing Go2 sways a little; faster than this it moves.
MOVING_MPS = 0.12
MOVING_RPS = 0.25

STOP_MOVE = 1003
CAPABILITIES = Capabilities(
    "go2",
    frozenset({Op.MOVE, Op.TURN, Op.HELLO, Op.HEART, Op.BACKFLIP, Op.SIT, Op.STAND, Op.STRETCH, Op.GET_FRONT_IMAGE}),
)


class Go2:
    """See `agentrob.robots.robot.Robot`. Construction takes about a second and needs no robot to be there yet.

    Raises `RobotUnreachable` when DDS cannot be opened on the interface of the settings.
    """

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """What it can do, without connecting. The simulated one cannot flip yet."""
        ops = CAPABILITIES.ops - {Op.BACKFLIP} if settings.simulated else CAPABILITIES.ops
        return replace(CAPABILITIES, ops=ops, limits=limits_of(settings), simulated=settings.simulated)

    def __init__(self, settings: RobotConfig) -> None:
        if settings.options:
            raise RobotError(f"a go2 has no options (found: {', '.join(sorted(settings.options))})")
        self.capabilities = self.describe(settings)
        limits = self.capabilities.limits
        self._gait = GAIT.at_most(limits.speed_mps, math.radians(limits.turn_dps))
        unitree.connect(settings.domain, settings.interface)

        from unitree_sdk2py.go2.sport.sport_client import SportClient
        from unitree_sdk2py.go2.video.video_client import VideoClient
        from unitree_sdk2py.idl.unitree_go.msg.dds_ import LowState_, SportModeState_

        self._state = unitree.Topic("rt/sportmodestate", SportModeState_)
        self._low = unitree.Polled("rt/lowstate", LowState_, every_s=2.0)
        makers: tuple[tuple[Callable[[], Any], float], ...] = (
            (SportClient, GESTURE_TIMEOUT_S),
            (SportClient, WRITE_TIMEOUT_S),
            (SportClient, WRITE_TIMEOUT_S),
            (VideoClient, IMAGE_TIMEOUT_S),
        )
        self._actions, self._moves, self._stopper, self._video = unitree.clients(*makers)
        self._stops = 0
        self._looking = threading.Lock()
        self._gesture: Gesture | None = None
        self._gestures: dict[Op, tuple[Callable[[], int], ...]] = {
            Op.HELLO: (self._actions.Hello,),
            Op.HEART: (self._actions.Heart,),
            Op.BACKFLIP: (self._actions.BackFlip,),
            Op.SIT: (self._actions.Sit,),
            Op.STAND: (self._actions.RecoveryStand, self._actions.BalanceStand),
            Op.STRETCH: (self._actions.Stretch,),
        }

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        newest = self._state.newest()
        if newest is None:
            return RobotState(age_s=math.inf)
        came_s, message = newest
        battery = self._low.newest
        percent = float(battery.bms_state.soc) if battery is not None else None
        return replace(read(message), age_s=time.monotonic() - came_s, battery_percent=percent)

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        before = self._stops
        attentive: Watch = lambda state: "stop" if self._stops != before else watch(state)  # noqa: E731
        if primitive.op is Op.GET_FRONT_IMAGE:
            return self._image(primitive)
        if self._gesturing:
            return _refused(primitive, "busy", "The robot has not finished its last gesture yet.")
        if primitive.op in (Op.MOVE, Op.TURN):
            return self._walk(primitive, attentive)
        return self._do_gesture(primitive, attentive)

    def stop(self) -> StopResult:
        """Zero velocity on two ways, on a client of its own that waits for no answer, then watch for rest."""
        asked_s = time.monotonic()
        self._stops += 1
        before = self.state()
        sent = self._send_stop()
        latency_ms = round(1000 * (time.monotonic() - asked_s), 3)
        rest, gesturing = Rest(STOPPED_WINDOW_S), self._gesturing
        while (now_s := time.monotonic()) < asked_s + REST_LIMIT_S:
            state = self.state()
            if state.pose is not None and state.age_s < 0.5 and rest.see(now_s, state.pose) and not self._gesturing:
                break
            time.sleep(1 / RATE_HZ)
            if now_s < asked_s + 0.5:
                self._send_stop()  # a Move that was on its way meanwhile, or a lost sample
        moved_m = rest.distance_m(before.pose)
        was_moving = gesturing or _moves(before) or (moved_m or 0.0) > 0.05
        doubt = self._doubt(rest)
        if doubt and not sent:
            doubt += " The stop could not be written to the robot's network."
        return StopResult(latency_ms, not doubt, was_moving, moved_m, doubt)

    def _doubt(self, rest: Rest) -> str:
        """Why the robot cannot be said to have come to rest; empty when it can."""
        if (age_s := self.state().age_s) >= 0.5:
            age = "no state ever came" if math.isinf(age_s) else f"its state is {age_s:.1f} s old"
            return f"The robot did not confirm: {age}."
        if not rest.reached:
            return f"The robot did not confirm: it still moved after {REST_LIMIT_S:g} s."
        return "The robot keeps its place, but has not ended its gesture yet." if self._gesturing else ""

    def close(self) -> None:
        self._send_stop()
        self._low.close()

    # ------------------------------------------------------------ the body (agentrob.robots.walk.Body)
    def now_s(self) -> float:
        return time.monotonic()

    def command(self, velocity: Velocity) -> None:
        self._moves.Move(*(float(v) for v in velocity))  # answers 0 even when the robot is frozen: odometry decides

    def rest(self) -> None:
        self._moves.Move(0.0, 0.0, 0.0)
        self._moves._CallNoReply(STOP_MOVE, "{}")

    def wait_until(self, time_s: float) -> None:
        time.sleep(max(0.0, time_s - time.monotonic()))

    # ------------------------------------------------------------ steps
    @property
    def _gesturing(self) -> bool:
        """Whether the robot has not answered its last gesture yet."""
        return self._gesture is not None and self._gesture.running

    def _send_stop(self) -> bool:
        codes = [self._stopper._CallNoReply(STOP_MOVE, "{}"), self._stopper.Move(0.0, 0.0, 0.0)]
        return 0 in codes

    def _walk(self, primitive: Primitive, watch: Watch) -> ActionResult:
        gait, state, started_s = self._gait, self.state(), time.monotonic()
        if state.mode in ("sitting", "lying", "damping"):
            return _refused(primitive, "posture", f"The robot is {state.mode}; it must stand up first.")
        if reason := watch(state):  # before the robot is told anything
            return not_begun(primitive, reason, started_s)
        if state.mode in ("locked", "unknown"):
            if code := self._actions.BalanceStand():
                return _failed(primitive, *_why(code, "It could not stand ready to walk"), time.monotonic())
            gait = replace(gait, start_s=START_AFTER_STANDING_S)
        return walk(self, primitive, gait, watch)

    def _do_gesture(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """The robot's own motion: it runs to its end; a reason of the watch stops what follows, and is told."""
        started_s = time.monotonic()
        if reason := watch(self.state()):
            return not_begun(primitive, reason, started_s)
        gesture = self._gesture = Gesture(self._gestures[primitive.op], lambda: watch(self.state()))
        gesture.follow()
        if reason := gesture.reason:
            self._send_stop()
            message = f"Stopped ({reason.replace('_', ' ')}); the robot may end the gesture by itself."
            return ActionResult(primitive, Outcome.STOPPED, {}, reason, message, started_s, time.monotonic())
        name = str(primitive.op).capitalize()
        if gesture.code:
            return _failed(primitive, *_why(gesture.code, f"{name} was not done"), started_s)
        animated = primitive.op is Op.BACKFLIP and self.capabilities.simulated
        return ActionResult(
            primitive, Outcome.DONE, {}, "", f"{name}: done.", started_s, time.monotonic(), animated=animated
        )

    def look(self) -> bytes:
        """See `agentrob.robots.robot.Sighted`; on the camera's own client, so no step waits for it."""
        result = self._image(Primitive(Op.GET_FRONT_IMAGE))
        if result.image is None:
            raise RobotError(result.message or "the camera gave no picture")
        return result.image

    def _image(self, primitive: Primitive) -> ActionResult:
        started_s = time.monotonic()
        with self._looking:
            code, data = self._video.GetImageSample()
        if code:
            return _failed(primitive, *_why(code, "No picture"), started_s)
        image = bytes(data or ())
        if not (image.startswith(b"\xff\xd8") and len(image) <= IMAGE_MAX_BYTES):
            message = f"The camera sent {len(image)} bytes that are not a JPEG of at most 8 MiB."
            return _failed(primitive, "bad_image", message, started_s)
        return ActionResult(primitive, Outcome.DONE, {}, "", "", started_s, time.monotonic(), image=image)


def read(message: Any) -> RobotState:
    """A `SportModeState_` as a state of age 0."""
    w, x, y, z = (float(v) for v in message.imu_state.quaternion)
    attitude = w * w + x * x + y * y + z * z > 0.5
    upright = 1.0 - 2.0 * (x * x + y * y) > UPRIGHT if attitude else None
    code = int(message.error_code)
    mode = MODES_BY_CODE.get(code) or (MODES_BY_MODE.get(int(message.mode), "unknown") if code == 0 else "unknown")
    pose = Pose(float(message.position[0]), float(message.position[1]), float(message.imu_state.rpy[2]))
    vx, vy, turning = float(message.velocity[0]), float(message.velocity[1]), float(message.yaw_speed)
    front, left, back, right = (float(r) if math.isfinite(r) else None for r in message.range_obstacle)
    return RobotState(
        age_s=0.0,
        pose=known(pose),
        velocity_mps=(vx, vy) if math.isfinite(vx) and math.isfinite(vy) else None,
        yaw_rate_rps=turning if math.isfinite(turning) else None,
        mode="fallen" if upright is False else mode,
        ranges_m=(front, left, back, right),
        upright=upright,
        error_code=code,
    )


def _moves(state: RobotState) -> bool:
    """Whether its own state shows it walking or turning (its sensors are never quite still)."""
    speed_mps = math.hypot(*state.velocity_mps) if state.velocity_mps else 0.0
    return speed_mps > MOVING_MPS or abs(state.yaw_rate_rps or 0.0) > MOVING_RPS


def _why(code: int, what: str) -> tuple[str, str]:
    word = "unsupported" if code in unitree.UNSUPPORTED else "no_answer" if code in unitree.NO_ANSWER else "robot_error"
    return word, f"{what}: {unitree.explain(code)}."


def _refused(primitive: Primitive, word: str, message: str) -> ActionResult:
    now_s = time.monotonic()
    return ActionResult(primitive, Outcome.REFUSED, {}, word, message, now_s, now_s)


def _failed(primitive: Primitive, word: str, message: str, started_s: float) -> ActionResult:
    outcome = Outcome.UNKNOWN if word == "no_answer" and primitive.moves else Outcome.FAILED
    return ActionResult(primitive, outcome, {}, word, message, started_s, time.monotonic())
