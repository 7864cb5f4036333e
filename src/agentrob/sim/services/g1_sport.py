"""The G1's sport and arm services without the network: the effect of each call on the body, and its answer.

Everything here runs in the world's thread. Answers are the real robot's codes; 0 only if the call was carried out.

The state machine (FSM) has four states: zero torque and damping (limp: the robot falls, and only a reset of the room
makes it stand again), locked standing, and walking. A velocity is held for its duration, one second by default.
Arm actions answer when their motion has ended; those that hold stay up until they are released (99). 99 during a motion
interrupts it, which then answers 4201, our convention. While an arm moves, only zero velocity is accepted (else 4205),
because the walking policy ignores the arms; the real robot may differ.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np

from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.g1_gestures import GESTURES, RELEASE, ArmGesture
from agentrob.sim.event_log import EventLog
from agentrob.sim.services.go2_sport import (
    BAD_PARAMETER,
    BROKEN_OFF,
    BUSY,
    FALLEN_BELOW,
    NOT_IMPLEMENTED,
    OK,
    UNSUITABLE,
)

ARM_BUSY, ARM_HOLDING, ARM_BAD_ID, ARM_WRONG_FSM = 7400, 7401, 7402, 7404

GET_FSM_ID, GET_FSM_MODE, GET_BALANCE_MODE, GET_STAND_HEIGHT, GET_PHASE = 7001, 7002, 7003, 7005, 7006
SET_FSM_ID, SET_BALANCE_MODE, SET_VELOCITY, SET_ARM_TASK = 7101, 7102, 7105, 7106
EXECUTE_ACTION, GET_ACTION_LIST = 7106, 7107

HELD_S = 1.0  # a velocity that came without a duration
SETTLE_LIMIT_S = 6.0  # for coming to rest before a gesture
WAVE, WAVE_TURNING, SHAKE_BEGIN, SHAKE_END = range(4)  # arm tasks of the sport service

Answer = Callable[..., None]  # (code, data)


class Fsm(IntEnum):
    ZERO_TORQUE = 0
    DAMP = 1
    LOCKED = 4
    WALK = 500


@dataclass
class _Action:
    """A running gesture. `releases` are answered when the arms are down; `holding`: the arms are up and it answered."""

    gesture: ArmGesture
    answer: Answer
    began_s: float
    settling: bool = True
    holding: bool = False
    lowering: bool = False
    releases: list[Answer] = field(default_factory=list)


class G1Sport:
    """The state of both services. `now_s` is the world's time; actual events go to `event_log`."""

    def __init__(self, body: G1, now_s: Callable[[], float], event_log: EventLog) -> None:
        self._body, self._now_s, self._event_log = body, now_s, event_log
        self.fsm = Fsm.WALK
        self.action: _Action | None = None
        self._held_until_s: float | None = None
        self._commanded_s = 0.0
        self._moving = False

    @property
    def commanded_s(self) -> float | None:
        """See `agentrob.sim.services.unitree.MotionService`."""
        return None if self._held_until_s is None else self._commanded_s

    # ------------------------------------------------------------------ the sport service
    def call(self, api_id: int, parameter: Mapping[str, Any], answer: Answer) -> None:
        """One call of `sport`; `answer(code, data)` is called once, now or when the action has ended."""
        if api_id in self._facts:
            answer(OK, json.dumps({"data": self._facts[api_id]()}))
        elif api_id == SET_FSM_ID:
            answer(self._set_fsm(_number(parameter)))
        elif api_id == SET_BALANCE_MODE:
            answer(OK if _number(parameter) == 0 else NOT_IMPLEMENTED)  # 1: stepping on the spot
        elif api_id == SET_VELOCITY:
            answer(self._velocity(parameter))
        elif api_id == SET_ARM_TASK:
            self._arm_task(_number(parameter), answer)
        else:
            answer(NOT_IMPLEMENTED)

    @property
    def _facts(self) -> Mapping[int, Callable[[], Any]]:
        return {
            GET_FSM_ID: lambda: int(self.fsm),
            GET_FSM_MODE: lambda: int(self._moving),
            GET_BALANCE_MODE: lambda: 0,
            GET_STAND_HEIGHT: lambda: round(self._body.z_m, 3),
            GET_PHASE: lambda: [0.0, 0.0],
        }

    def _set_fsm(self, wanted: int) -> int:
        try:
            fsm = Fsm(wanted)
        except ValueError:
            return BAD_PARAMETER
        if fsm in (Fsm.ZERO_TORQUE, Fsm.DAMP):
            self._go_limp(fsm)
        elif self.fsm in (Fsm.ZERO_TORQUE, Fsm.DAMP):
            return UNSUITABLE  # it lies: getting up is not simulated
        elif self.action is not None:
            return BUSY
        else:
            self.fsm = fsm
            self._stand()
        self._note("fsm", id=int(fsm))
        return OK

    def _go_limp(self, fsm: Fsm) -> None:
        self._break_off()
        self._held_until_s = None
        self.fsm = fsm
        self._body.go_limp()

    def _velocity(self, parameter: Mapping[str, Any]) -> int:
        try:
            velocity = np.array([float(v) for v in parameter["velocity"]])
            held_s = float(parameter.get("duration", HELD_S))
        except (KeyError, TypeError, ValueError):
            return BAD_PARAMETER
        if velocity.shape != (3,) or not np.isfinite(velocity).all() or not held_s > 0:
            return BAD_PARAMETER
        if self.fsm is not Fsm.WALK:
            return UNSUITABLE
        if not velocity.any():
            if self._held_until_s is not None:
                self._note("stop_move", moving=self._moving, action=None)
            self._stand()
            return OK
        if self.action is not None:
            return BUSY
        if not self._moving:
            self._moving = True
            self._note("move_begin", velocity=[round(float(v), 3) for v in velocity])
        self._body.walk(velocity)
        self._commanded_s = self._now_s()
        self._held_until_s = self._commanded_s + held_s
        return OK

    def _stand(self) -> None:
        self._held_until_s = None
        self._body.walk(np.zeros(3))

    def _arm_task(self, task: int, answer: Answer) -> None:
        ids = {WAVE: 26, SHAKE_BEGIN: 27, SHAKE_END: RELEASE}
        if task == WAVE_TURNING:
            answer(NOT_IMPLEMENTED)
        elif task in ids:
            self.call_arm(EXECUTE_ACTION, {"data": ids[task]}, answer)
        else:
            answer(BAD_PARAMETER)

    # ------------------------------------------------------------------ the arm service
    def call_arm(self, api_id: int, parameter: Mapping[str, Any], answer: Answer) -> None:
        """One call of `arm`, as `call`."""
        if api_id == GET_ACTION_LIST:
            names = {RELEASE: "release arm", **{i: g.name for i, g in GESTURES.items()}}
            answer(OK, json.dumps([{"id": i, "name": name} for i, name in sorted(names.items())]))
        elif api_id != EXECUTE_ACTION:
            answer(NOT_IMPLEMENTED)
        elif (action := _number(parameter)) == RELEASE:
            self._release(answer)
        elif (gesture := GESTURES.get(action)) is None:
            answer(ARM_BAD_ID)
        elif self.fsm is not Fsm.WALK:
            answer(ARM_WRONG_FSM)
        elif self.action is not None:
            answer(ARM_HOLDING if self.action.holding else ARM_BUSY)
        else:
            self._stand()
            self.action = _Action(gesture, answer, self._now_s())
            self._note("action_begin", action=gesture.name)

    def _release(self, answer: Answer) -> None:
        action = self.action
        if action is None:
            answer(OK)
            return
        action.releases.append(answer)
        if action.lowering:
            return
        if not action.holding:
            self._end_motion(action, BROKEN_OFF)
        if action.settling:
            self._arms_down(action)
            return
        action.lowering, action.holding = True, False
        joints = action.gesture.joints
        self._body.move_arms(joints, action.gesture.lower(self._body.target_rad[joints]))

    def _end_motion(self, action: _Action, code: int) -> None:
        self._note("action_end", action=action.gesture.name, code=code)
        action.answer(code)

    def _arms_down(self, action: _Action) -> None:
        self.action = None
        self._body.free_arms()
        for answer in action.releases:
            answer(OK)

    def _break_off(self) -> None:
        action, self.action = self.action, None
        if action is not None:
            if not (action.holding or action.lowering):
                self._end_motion(action, BROKEN_OFF)
            for answer in action.releases:
                answer(BROKEN_OFF)

    # ------------------------------------------------------------------ time
    def tick(self) -> None:
        """Once per period, before the world's tick."""
        if self._held_until_s is not None and self._now_s() >= self._held_until_s:
            self._stand()
        if self.action is not None:
            self._go_on(self.action)
        if self._moving and (self._body.standing or self.fsm is not Fsm.WALK):
            self._moving = False
            self._note("move_end")
        if self._body.upright < FALLEN_BELOW and self.fsm not in (Fsm.ZERO_TORQUE, Fsm.DAMP):
            self._note("fell")
            self._go_limp(Fsm.DAMP)

    def _go_on(self, action: _Action) -> None:
        if action.settling:
            if self._body.standing:
                action.settling = False
                joints = action.gesture.joints
                self._body.move_arms(joints, action.gesture.play(self._body.target_rad[joints]))
            elif self._now_s() - action.began_s > SETTLE_LIMIT_S:
                self._end_motion(action, BROKEN_OFF)  # pushed, or leaning on something
                self._arms_down(action)
        elif self._body.arms_moving:
            return
        elif action.lowering:
            self._arms_down(action)
        elif not action.holding:
            action.holding = action.gesture.holds
            self._end_motion(action, OK)
            if not action.holding:
                self._arms_down(action)

    def reset(self) -> None:
        """Reset after the world was reset: no action runs, the robot stands."""
        self._break_off()
        self._held_until_s, self._moving, self.fsm = None, False, Fsm.WALK
        self._note("reset")

    def _note(self, event: str, **facts: Any) -> None:
        body = self._body
        x, y = body.xy_m
        pose = {"x_m": round(float(x), 4), "y_m": round(float(y), 4), "yaw_deg": round(math.degrees(body.yaw_rad), 2)}
        self._event_log.write(self._now_s(), body.name, event, pose, facts)


def _number(parameter: Mapping[str, Any]) -> int:
    """The integer in a call's `data`, or -1, which is never valid."""
    data = parameter.get("data")
    return data if isinstance(data, int) else -1
