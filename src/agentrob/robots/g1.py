"""The Unitree G1 humanoid, through the official SDK's clients: the same for a real one and for the simulated one.

A G1 offers no range readings on DDS, so free space around it is always unknown: the guard moves it at most at 0.2 m/s,
and only with the owner's consent (`allow_unknown_ranges`). Its limits say so from the beginning. Nor does its state
carry a battery: the topic of a real one is not verified.

Unverified on hardware: which fields of `rt/odommodestate` a G1 fills and in which frame its velocity is, the state ids
beside 500, how soon it walks after being unlocked, how long gestures take, and whether a release (99) ends one early.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from agentrob.config import RobotConfig
from agentrob.errors import RobotError
from agentrob.model import ActionResult, Capabilities, Limits, Op, Outcome, Pose, Primitive, RobotState, StopResult
from agentrob.robots import g1_fsm, unitree
from agentrob.robots.gesture import Gesture
from agentrob.robots.guard import BLIND_MPS
from agentrob.robots.motion import RATE_HZ, STOPPED_WINDOW_S, Gait, Rest, Velocity, known
from agentrob.robots.robot import BODY_RADIUS_M, Watch, limits_of
from agentrob.robots.walk import REST_LIMIT_S, not_begun, walk

#: A cautious envelope, well inside what the robot can do. What it coasts and sways was found in simulation.
GAIT = Gait(
    speed_mps=0.5,
    side_mps=0.2,
    turn_rps=0.6,
    coast_s=0.15,
    settle_s=1.8,  # it sways and makes another step: sooner, its place says nothing
    settle_limit_s=3.5,
    stride_s=1.0,
    stride_shift=(0.013, -0.048, 0.010),
)

#: A gesture takes up to 9 s; a shorter timeout would report a failure that is none.
GESTURE_TIMEOUT_S = 20.0
#: Commands of velocity and stops are written, not asked: they must never wait long for a robot that is not there.
WRITE_TIMEOUT_S = 0.15
ASK_TIMEOUT_S = 0.5
IMAGE_TIMEOUT_S = 3.0
IMAGE_MAX_BYTES = 8 * 1024 * 1024
#: The robot holds a velocity for so long: a driver that dies leaves it walking no longer than this.
HELD_S = 0.5
#: After being unlocked it may take so long until it walks.
START_AFTER_LOCKED_S = 10.0
#: Cosine of the tilt below which it lies rather than stands (60 degrees).
UPRIGHT = 0.5
#: A standing G1 sways; faster than this it moves.
MOVING_MPS, MOVING_RPS = 0.12, 0.25

SET_VELOCITY, EXECUTE_ACTION = 7105, 7106
RELEASE = 99
#: Ids of the arm service; the last two hold their pose until released, so they are shown for a moment first.
ACTIONS = {Op.HELLO: 26, Op.CLAP: 17, Op.HEART: 20, Op.SHAKE: 27}
HOLDING = frozenset({Op.HEART, Op.SHAKE})
SHOWN_S = 2.0
OPTIONS = {"videohub"}
CAPABILITIES = Capabilities("g1", frozenset({Op.MOVE, Op.TURN, *ACTIONS, Op.GET_FRONT_IMAGE}))


class G1:
    """See `agentrob.robots.robot.Robot`. Construction takes about a second and needs no robot to be there yet.

    Raises `RobotUnreachable` when DDS cannot be opened on the interface of the settings.
    """

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """What it can do, without connecting.

        A real G1 serves no pictures on DDS; the option `videohub = true` says that something beside it does so, by the
        Go2's service of that name.
        """
        pictures = settings.simulated or settings.options.get("videohub") is True
        ops = CAPABILITIES.ops if pictures else CAPABILITIES.ops - {Op.GET_FRONT_IMAGE}
        return replace(CAPABILITIES, ops=ops, limits=_blind(limits_of(settings)), simulated=settings.simulated)

    def __init__(self, settings: RobotConfig) -> None:
        if unknown := set(settings.options) - OPTIONS:
            raise RobotError(f"a g1 has no option {', '.join(sorted(unknown))}; it has: {', '.join(sorted(OPTIONS))}")
        self.capabilities = self.describe(settings)
        limits = self.capabilities.limits
        self._gait = GAIT.at_most(limits.speed_mps, math.radians(limits.turn_dps))
        unitree.connect(settings.domain, settings.interface)

        from unitree_sdk2py.g1.arm.g1_arm_action_client import G1ArmActionClient
        from unitree_sdk2py.g1.loco.g1_loco_client import LocoClient
        from unitree_sdk2py.go2.video.video_client import VideoClient
        from unitree_sdk2py.idl.unitree_go.msg.dds_ import SportModeState_

        self._odometry = unitree.Topic("rt/odommodestate", SportModeState_)
        makers: tuple[tuple[Callable[[], Any], float], ...] = (
            (LocoClient, ASK_TIMEOUT_S),
            (LocoClient, ASK_TIMEOUT_S),
            (LocoClient, WRITE_TIMEOUT_S),
            (LocoClient, WRITE_TIMEOUT_S),
            (G1ArmActionClient, GESTURE_TIMEOUT_S),
            (G1ArmActionClient, WRITE_TIMEOUT_S),
            (VideoClient, IMAGE_TIMEOUT_S),
        )
        made = unitree.clients(*makers)
        asker, self._sport, self._moves, self._stopper, self._arm, self._releaser, self._video = made
        self._fsm = g1_fsm.FsmWatch(asker, lambda: self._age_s() < g1_fsm.OLD_S)
        self._stops = 0
        self._looking = threading.Lock()
        self._let_go = threading.Event()
        self._gesture: Gesture | None = None

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        newest = self._odometry.newest()
        if newest is None:
            return RobotState(age_s=math.inf)
        state = replace(read(newest[1]), age_s=time.monotonic() - newest[0])
        return replace(state, mode=mode_of(state, self._fsm.id, gesturing=self._gesturing))

    def _age_s(self) -> float:
        newest = self._odometry.newest()
        return math.inf if newest is None else time.monotonic() - newest[0]

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        before = self._stops
        attentive: Watch = lambda state: "stop" if self._stops != before else watch(state)  # noqa: E731
        if primitive.op is Op.GET_FRONT_IMAGE:
            return self._image(primitive)
        if self._gesturing:
            return _refused(primitive, "busy", "The robot has not finished its last gesture yet.")
        started_s = time.monotonic()
        if reason := attentive(self.state()):  # before the robot is told anything
            return not_begun(primitive, reason, started_s)
        if unfit := self._stand_ready(primitive):
            return unfit
        if primitive.op in (Op.MOVE, Op.TURN):
            return walk(self, primitive, self._ready_gait, attentive)
        return self._do_gesture(primitive, attentive)

    def stop(self) -> StopResult:
        """Zero velocity, and the arms released, on clients that wait for no answer; then watch for rest."""
        asked_s = time.monotonic()
        self._stops += 1
        self._let_go.set()
        before = self.state()
        sent = self._send_stop()
        latency_ms = round(1000 * (time.monotonic() - asked_s), 3)
        rest, gesturing = Rest(STOPPED_WINDOW_S), self._gesturing
        if gesturing:
            self._send_release()
        while (now_s := time.monotonic()) < asked_s + REST_LIMIT_S:
            state = self.state()
            if state.pose is not None and state.age_s < 0.5 and rest.see(now_s, state.pose) and not self._gesturing:
                break
            time.sleep(1 / RATE_HZ)
            if now_s < asked_s + 0.5:
                self._send_stop()  # a velocity that was on its way meanwhile, or a lost sample
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
        return "The robot keeps its place, but its arms are not down yet." if self._gesturing else ""

    def close(self) -> None:
        self._let_go.set()
        self._send_stop()
        if self._gesturing:
            self._send_release()
        self._fsm.close()

    # ------------------------------------------------------------ the body (agentrob.robots.walk.Body)
    def now_s(self) -> float:
        return time.monotonic()

    def command(self, velocity: Velocity) -> None:
        self._send(self._moves, velocity)  # a robot that is frozen takes it without a word: odometry decides

    def rest(self) -> None:
        self._send(self._moves, Velocity())

    def wait_until(self, time_s: float) -> None:
        time.sleep(max(0.0, time_s - time.monotonic()))

    # ------------------------------------------------------------ what is sent
    @staticmethod
    def _send(client: Any, velocity: Velocity) -> int:
        parameter = {"velocity": [float(v) for v in velocity], "duration": HELD_S}
        return int(client._CallNoReply(SET_VELOCITY, json.dumps(parameter)))

    def _send_stop(self) -> bool:
        return self._send(self._stopper, Velocity()) == 0

    def _send_release(self) -> None:
        self._releaser._CallNoReply(EXECUTE_ACTION, json.dumps({"data": RELEASE}))

    # ------------------------------------------------------------ steps
    @property
    def _gesturing(self) -> bool:
        """Whether the robot has not answered its last gesture, or its release, yet."""
        return self._gesture is not None and self._gesture.running

    def _stand_ready(self, primitive: Primitive) -> ActionResult | None:
        """Why it cannot walk or gesture now; a locked one is unlocked."""
        self._ready_gait, fsm = self._gait, self._fsm.wait(g1_fsm.OLD_S)
        if fsm in g1_fsm.WALKING:
            return None
        if fsm is None:
            return _refused(primitive, "posture", "The robot does not tell the state of its motion service.")
        if fsm != g1_fsm.LOCKED:
            mode = g1_fsm.MODES.get(fsm, "in an unknown state")
            return _refused(primitive, "posture", f"The robot is {mode} (state {fsm}); somebody must make it stand.")
        if code := self._sport._Call(g1_fsm.SET_FSM_ID, json.dumps({"data": g1_fsm.WALK}))[0]:
            return _failed(primitive, *_why(code, "It could not stand ready to walk"), time.monotonic())
        self._ready_gait = replace(self._gait, start_s=START_AFTER_LOCKED_S)
        return None

    def _do_gesture(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """The arm's own motion; a reason of the watch lets it go: the arms come down early."""
        started_s = time.monotonic()
        self._let_go.clear()
        gesture = Gesture((lambda: self._perform(primitive.op),), lambda: watch(self.state()))
        self._gesture = gesture
        gesture.follow()
        if reason := gesture.reason:
            self._let_go.set()
            self._send_stop()
            self._send_release()
            message = f"Stopped ({reason.replace('_', ' ')}); its arms are being let down."
            return ActionResult(primitive, Outcome.STOPPED, {}, reason, message, started_s, time.monotonic())
        name = str(primitive.op).capitalize()
        if gesture.code:
            return _failed(primitive, *_why(gesture.code, f"{name} was not done"), started_s)
        return ActionResult(primitive, Outcome.DONE, {}, "", f"{name}: done.", started_s, time.monotonic())

    def _perform(self, op: Op) -> int:
        """The gesture, and the release of those that hold their pose, or that were broken off; the code of both."""
        code = int(self._arm.ExecuteAction(ACTIONS[op]))
        if code in unitree.NO_ANSWER or not (op in HOLDING or code or self._let_go.is_set()):
            return code
        if code == 0:
            self._let_go.wait(SHOWN_S)
        released = int(self._arm.ExecuteAction(RELEASE))
        return code or released

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


def _blind(limits: Limits) -> Limits:
    """The limits of a robot that does not see what is around it (law 8)."""
    turn_dps = min(limits.turn_dps, math.degrees(GAIT.turn_rps), math.degrees(BLIND_MPS / BODY_RADIUS_M))
    return replace(limits, speed_mps=min(limits.speed_mps, BLIND_MPS), turn_dps=round(turn_dps, 1))


def read(message: Any) -> RobotState:
    """A `SportModeState_` of the odometry service as a state of age 0, without its mode."""
    w, x, y, z = (float(v) for v in message.imu_state.quaternion)
    attitude = w * w + x * x + y * y + z * z > 0.5
    pose = Pose(float(message.position[0]), float(message.position[1]), float(message.imu_state.rpy[2]))
    vx, vy, turning = float(message.velocity[0]), float(message.velocity[1]), float(message.yaw_speed)
    return RobotState(
        age_s=0.0,
        pose=known(pose),
        velocity_mps=(vx, vy) if math.isfinite(vx) and math.isfinite(vy) else None,
        yaw_rate_rps=turning if math.isfinite(turning) else None,
        upright=1.0 - 2.0 * (x * x + y * y) > UPRIGHT if attitude else None,
    )


def mode_of(state: RobotState, fsm: int | None, *, gesturing: bool) -> str:
    """The mode, from its tilt, the state of its motion service and how it moves."""
    if state.upright is False:
        return "fallen"
    if fsm is None or fsm not in g1_fsm.WALKING:
        return "unknown" if fsm is None else g1_fsm.MODES.get(fsm, "unknown")
    if gesturing:
        return "gesture"
    return "walking" if _moves(state) else "idle"


def _moves(state: RobotState) -> bool:
    """Whether its own state shows it walking or turning (it is never quite still)."""
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
