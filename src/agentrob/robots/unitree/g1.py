"""The Unitree G1 humanoid, through the official SDK's clients: the same for a real one and for the simulated one.

A G1 publishes no range readings on DDS, so free space around it is always unknown: the guard moves it at most at
0.2 m/s, and only with the owner's consent (`allow_unknown_ranges`); its limits reflect that. Its state has no battery
charge either: the topic of a real G1 is not verified.

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

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError
from agentrob.model import (
    ActionResult,
    Capabilities,
    Limits,
    Op,
    Outcome,
    Pose,
    Posture,
    Primitive,
    RobotState,
    StopResult,
)
from agentrob.robots.control.controller import Gait, Velocity
from agentrob.robots.control.step_runner import not_begun, run_step
from agentrob.robots.protocol import BODY_RADIUS_M, Watch, limits_of
from agentrob.robots.safety.guard import BLIND_MPS
from agentrob.robots.unitree import g1_fsm, sdk
from agentrob.robots.unitree.robot import (
    IMAGE_TIMEOUT_S,
    WRITE_TIMEOUT_S,
    JointAngles,
    UnitreeRobot,
    failed,
    gesture_timeout_s,
    is_moving,
    poses,
    posture_of,
    read,
    refused,
)

#: Cautious values, well below what the robot can do. Coasting and sway were measured in simulation.
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

#: A gesture takes up to 9 s; with a shorter timeout, one that succeeds would be reported as failed.
GESTURE_TIMEOUT_S = 20.0
ASK_TIMEOUT_S = 0.5
#: How long the robot holds a velocity, and so the longest that it walks on after its driver died.
HELD_S = 0.5
#: It may take this long until it walks after being unlocked.
START_AFTER_LOCKED_S = 10.0
SET_VELOCITY, EXECUTE_ACTION = 7105, 7106
RELEASE = 99
#: Ids of the arm service; the last two hold their pose until released, so they are shown for a moment first.
ACTIONS: dict[str, int] = {Op.HELLO: 26, Op.CLAP: 17, Op.HEART: 20, Op.SHAKE: 27}
HOLDING = frozenset({Op.HEART, Op.SHAKE})
SHOWN_S = 2.0
OPTIONS = {"videohub"}
CAPABILITIES = Capabilities("g1", frozenset({Op.MOVE, Op.TURN, *ACTIONS, Op.GET_FRONT_IMAGE}))


class G1(UnitreeRobot):
    """See `agentrob.robots.protocol.Robot`. Construction takes about a second and needs no robot to be there yet.

    Raises `RobotUnreachable` when DDS cannot be opened on the interface of the settings.
    """

    _unfinished = "its arms are not down yet"

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """Return its capabilities without connecting.

        A real G1 serves no pictures on DDS; the option `videohub = true` declares that another program provides them
        through a service like the Go2's `videohub`.
        """
        pictures = settings.simulated or settings.options.get("videohub") is True
        ops = CAPABILITIES.ops if pictures else CAPABILITIES.ops - {Op.GET_FRONT_IMAGE}
        return replace(CAPABILITIES, ops=ops, limits=_blind(limits_of(settings)), simulated=settings.simulated)

    def __init__(self, settings: RobotConfig) -> None:
        super().__init__(simulated=settings.simulated)
        if unknown := set(settings.options) - OPTIONS:
            raise RobotError(f"a g1 has no option {', '.join(sorted(unknown))}; it has: {', '.join(sorted(OPTIONS))}")
        self.capabilities = self.describe(settings)
        limits = self.capabilities.limits
        self._gait = GAIT.at_most(limits.speed_mps, math.radians(limits.turn_dps))
        sdk.connect(settings.domain, settings.interface)

        from unitree_sdk2py.g1.arm.g1_arm_action_client import G1ArmActionClient
        from unitree_sdk2py.g1.loco.g1_loco_client import LocoClient
        from unitree_sdk2py.go2.video.video_client import VideoClient
        from unitree_sdk2py.idl.unitree_go.msg.dds_ import SportModeState_
        from unitree_sdk2py.idl.unitree_hg.msg.dds_ import LowState_

        self._odometry = sdk.Topic("rt/odommodestate", SportModeState_, self._heard)
        self._low = sdk.PolledTopic("rt/lowstate", LowState_, every_s=10.0)
        self._joints = JointAngles(self._low, 29)
        makers: tuple[tuple[Callable[[], Any], float], ...] = (
            (LocoClient, ASK_TIMEOUT_S),
            (LocoClient, ASK_TIMEOUT_S),
            (LocoClient, WRITE_TIMEOUT_S),
            (LocoClient, WRITE_TIMEOUT_S),
            (G1ArmActionClient, gesture_timeout_s(GESTURE_TIMEOUT_S, simulated=settings.simulated)),
            (G1ArmActionClient, WRITE_TIMEOUT_S),
            (VideoClient, IMAGE_TIMEOUT_S),
        )
        made = sdk.clients(*makers)
        asker, self._sport, self._moves, self._stopper, self._arm, self._releaser, self._video = made
        self._fsm = g1_fsm.FsmMonitor(asker, lambda: self._age_s() < g1_fsm.OLD_S)
        self._let_go = threading.Event()

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        newest = self._odometry.newest()
        if newest is None:
            return RobotState(age_s=math.inf)
        state = replace(read(newest[1]), age_s=time.monotonic() - newest[0])
        return replace(state, mode=mode_of(state, self._fsm.id, gesturing=self._gesturing))

    def posture(self, *, joints: bool) -> Posture:
        return posture_of(self._odometry.newest(), self._joints.now() if joints else ())

    def _recent(self) -> tuple[tuple[float, Pose], ...]:
        return poses(self._odometry)

    def _age_s(self) -> float:
        newest = self._odometry.newest()
        return math.inf if newest is None else time.monotonic() - newest[0]

    def stop(self) -> StopResult:
        self._let_go.set()
        return super().stop()

    def close(self) -> None:
        self._let_go.set()
        self._send_stop()
        if self._gesturing:
            self._send_release()
        self._fsm.close()
        self._low.close()

    # ------------------------------------------------------------ the body (agentrob.robots.control.step_runner.Body)
    def command(self, velocity: Velocity) -> None:
        self._send(self._moves, velocity)  # a robot that is frozen takes it without a word: odometry decides

    def rest(self) -> None:
        self._send(self._moves, Velocity())

    # ------------------------------------------------------------ what is sent
    @staticmethod
    def _send(client: Any, velocity: Velocity) -> int:
        parameter = {"velocity": [float(v) for v in velocity], "duration": HELD_S}
        return int(client._CallNoReply(SET_VELOCITY, json.dumps(parameter)))

    def _send_stop(self) -> bool:
        return self._send(self._stopper, Velocity()) == 0

    def _end_gesture(self) -> None:
        self._send_release()

    def _send_release(self) -> None:
        self._releaser._CallNoReply(EXECUTE_ACTION, json.dumps({"data": RELEASE}))

    # ------------------------------------------------------------ steps
    def _do(self, primitive: Primitive, watch: Watch) -> ActionResult:
        started_s = time.monotonic()
        if reason := watch(self.state()):  # before the robot is commanded
            return not_begun(primitive, reason, started_s)
        if unfit := self._stand_ready(primitive):
            return unfit
        if primitive.op in (Op.MOVE, Op.TURN):
            return run_step(self, primitive, self._ready_gait, watch)
        return self._do_gesture(primitive, watch)

    def _stand_ready(self, primitive: Primitive) -> ActionResult | None:
        """Unlock a locked robot; return why it cannot walk or gesture, or None."""
        self._ready_gait, fsm = self._gait, self._fsm.wait(g1_fsm.OLD_S)
        if fsm in g1_fsm.WALKING:
            return None
        if fsm is None:
            return refused(primitive, "posture", "The robot does not tell the state of its motion service.")
        if fsm != g1_fsm.LOCKED:
            mode = g1_fsm.MODES.get(fsm, "in an unknown state")
            return refused(primitive, "posture", f"The robot is {mode} (state {fsm}); somebody must make it stand.")
        if code := self._sport._Call(g1_fsm.SET_FSM_ID, json.dumps({"data": g1_fsm.WALK}))[0]:
            return failed(primitive, code, "It could not stand ready to walk", time.monotonic())
        self._ready_gait = replace(self._gait, start_s=START_AFTER_LOCKED_S)
        return None

    def _do_gesture(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """Run the arm's built-in motion; if the watch gives a reason, release the arms early."""
        started_s = time.monotonic()
        self._let_go.clear()
        calls = 2 if primitive.op in HOLDING else 1
        gesture = self._begin_gesture((lambda: self._perform(primitive.op),), watch, calls * GESTURE_TIMEOUT_S)
        gesture.follow()
        if reason := gesture.reason:
            self._let_go.set()
            self._send_stop()
            self._send_release()
            message = f"Stopped ({reason.replace('_', ' ')}); its arms are being let down."
            return ActionResult(primitive, Outcome.STOPPED, {}, reason, message, started_s, time.monotonic())
        name = str(primitive.op).capitalize()
        if gesture.unanswered:
            return failed(primitive, sdk.LATE, f"{name} was not done", started_s)
        if gesture.code:
            return failed(primitive, gesture.code, f"{name} was not done", started_s)
        return ActionResult(primitive, Outcome.DONE, {}, "", f"{name}: done.", started_s, time.monotonic())

    def _perform(self, op: str) -> int:
        """Run the gesture, and release arms that hold their pose or were interrupted; return the code of both."""
        code = int(self._arm.ExecuteAction(ACTIONS[op]))
        if code in sdk.NO_ANSWER or not (op in HOLDING or code or self._let_go.is_set()):
            return code
        if code == 0:
            self._let_go.wait(SHOWN_S)
        released = int(self._arm.ExecuteAction(RELEASE))
        return code or released


def _blind(limits: Limits) -> Limits:
    """The limits of a robot without range readings (law 8)."""
    turn_dps = min(limits.turn_dps, math.degrees(GAIT.turn_rps), math.degrees(BLIND_MPS / BODY_RADIUS_M))
    return replace(limits, speed_mps=min(limits.speed_mps, BLIND_MPS), turn_dps=round(turn_dps, 1))


def mode_of(state: RobotState, fsm: int | None, *, gesturing: bool) -> str:
    """The mode, from the tilt, the state of the motion service and the motion."""
    if state.upright is False:
        return "fallen"
    if fsm is None or fsm not in g1_fsm.WALKING:
        return "unknown" if fsm is None else g1_fsm.MODES.get(fsm, "unknown")
    if gesturing:
        return "gesture"
    return "walking" if is_moving(state) else "idle"
