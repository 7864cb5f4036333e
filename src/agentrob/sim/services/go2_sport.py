"""The Go2's sport service without the network: the effect of each call on the body, and its answer.

Everything here runs in the world's thread. Answers are the real robot's codes; 0 only if the call was carried out.

Postures: *balance* (ready to walk), *locked* (stands on stiff legs), *lying*, *sitting*, *limp*. A call that the
posture does not allow answers 4206; a call while an action runs answers 4205; an interrupted action answers 4201. Move
is held for one second. StopMove is always accepted: it ends a move at once, and ends an action by putting all feet down
and standing up; a flip that is in the air lands first. A flip is an animation (`flip.py`), refused with 4206 if
there is not enough room.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from agentrob.sim.bodies import flip, go2_gestures
from agentrob.sim.bodies.flip import Flight
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.bodies.go2_gestures import Motion
from agentrob.sim.event_log import EventLog
from agentrob.sim.world.legged import Array

OK, NOT_IMPLEMENTED, BAD_PARAMETER = 0, 3203, 3204
BROKEN_OFF, BUSY, UNSUITABLE = 4201, 4205, 4206

DAMP, BALANCE_STAND, STOP_MOVE, STAND_UP, STAND_DOWN, RECOVERY_STAND = 1001, 1002, 1003, 1004, 1005, 1006
MOVE, SIT, RISE_SIT, HELLO, STRETCH, HEART, BACK_FLIP = 1008, 1009, 1010, 1016, 1017, 1036, 2043

MOVE_HELD_S = 1.0
SETTLE_LIMIT_S = 6.0  # for coming to rest before an action
FALLEN_BELOW = 0.3  # cosine of the tilt

Answer = Callable[[int], None]
Make = Callable[[Array], Motion | Flight]  # from the joints at its begin


class Posture(StrEnum):
    BALANCE = "balance"
    LOCKED = "locked"
    LYING = "lying"
    SITTING = "sitting"
    LIMP = "limp"


#: `error_code` and `mode` of sportmodestate at rest in each posture.
CODES: Mapping[Posture, tuple[int, int]] = {
    Posture.BALANCE: (1013, 1),
    Posture.LOCKED: (1002, 6),
    Posture.LYING: (1004, 5),
    Posture.SITTING: (1007, 10),
    Posture.LIMP: (1001, 7),
}
WALKING, GESTURING = (1015, 3), (1006, 9)


@dataclass
class Action:
    """A running action, answered when it has ended.

    `settling`: the body still comes to rest on its feet before the motion is played.
    """

    name: str
    make: Make
    then: Posture
    began_s: float
    answer: Answer
    codes: tuple[int, int]
    settling: bool = False
    seconds: float = 1.0
    broken_off: bool = False


@dataclass(frozen=True, slots=True)
class Offer:
    """One action of the service: its initial postures, its motion and its final posture."""

    name: str
    from_: frozenset[Posture]
    make: Make
    then: Posture
    codes: tuple[int, int] = GESTURING


_STANDING = frozenset({Posture.BALANCE, Posture.LOCKED})
_UP = _STANDING | {Posture.SITTING}
_DOWN = frozenset({Posture.LYING, Posture.LIMP})
OFFERS: Mapping[int, Offer] = {
    HELLO: Offer("hello", _STANDING, go2_gestures.hello, Posture.BALANCE),
    HEART: Offer("heart", _STANDING, go2_gestures.heart, Posture.BALANCE),
    STRETCH: Offer("stretch", _STANDING, go2_gestures.stretch, Posture.BALANCE),
    SIT: Offer("sit", _STANDING, go2_gestures.sit, Posture.SITTING, CODES[Posture.SITTING]),
    RISE_SIT: Offer("rise from sitting", frozenset({Posture.SITTING}), go2_gestures.rise_from_sitting, Posture.BALANCE),
    BACK_FLIP: Offer("backflip", _STANDING, Flight, Posture.BALANCE),
    STAND_DOWN: Offer("lie down", _UP | _DOWN, go2_gestures.lie_down, Posture.LYING, CODES[Posture.LYING]),
}


class Sport:
    """The state of the service. `now_s` is the world's time; actual events go to `event_log`."""

    def __init__(self, body: Go2, now_s: Callable[[], float], event_log: EventLog) -> None:
        self._body = body
        self._now_s = now_s
        self._event_log = event_log
        self.posture = Posture.BALANCE
        self.action: Action | None = None
        self._held_until_s: float | None = None
        self._moving = False

    @property
    def commanded_s(self) -> float | None:
        """See `agentrob.sim.services.unitree.MotionService`."""
        return None if self._held_until_s is None else self._held_until_s - MOVE_HELD_S

    # ------------------------------------------------------------------ calls
    def call(self, api_id: int, parameter: Mapping[str, Any], answer: Answer) -> None:
        """Handle one call. `answer` is called once, now or when the action has ended."""
        if api_id == MOVE:
            answer(self._move(parameter))
        elif api_id == STOP_MOVE:
            answer(self._stop())
        elif api_id == DAMP:
            answer(self._damp())
        elif self.action is not None and (api_id in OFFERS or api_id in (BALANCE_STAND, STAND_UP, RECOVERY_STAND)):
            answer(BUSY)
        elif api_id == BALANCE_STAND:
            answer(self._balance())
        elif api_id in (STAND_UP, RECOVERY_STAND):
            self._stand_up(Posture.LOCKED if api_id == STAND_UP else Posture.BALANCE, answer)
        elif api_id in OFFERS:
            offer = OFFERS[api_id]
            if self.posture not in offer.from_ or not self._has_room(offer.make):
                answer(UNSUITABLE)
            else:
                self._begin(offer, answer)
        else:
            answer(NOT_IMPLEMENTED)

    def _move(self, parameter: Mapping[str, Any]) -> int:
        try:
            velocity = np.array([float(parameter[k]) for k in ("x", "y", "z")])
        except (KeyError, TypeError, ValueError):
            return BAD_PARAMETER
        if not np.isfinite(velocity).all():
            return BAD_PARAMETER
        if self.action is not None:
            return BUSY
        if self.posture is not Posture.BALANCE:
            return UNSUITABLE
        if velocity.any() and not self._moving:
            self._moving = True
            self._note("move_begin", velocity=[round(float(v), 3) for v in velocity])
        self._body.walk(velocity)
        self._held_until_s = self._now_s() + MOVE_HELD_S
        return OK

    def _stop(self) -> int:
        self._note("stop_move", moving=self._moving, action=self.action.name if self.action else None)
        self._held_until_s = None
        if self.action is not None:
            self._break_off(self.action)
        elif self.posture is Posture.BALANCE:
            self._body.walk(np.zeros(3))
        return OK

    def _has_room(self, make: Make) -> bool:
        return make is not Flight or flip.clear(self._body)

    def _break_off(self, action: Action) -> None:
        if action.broken_off or action.then is Posture.LYING:
            return  # going down is the safe end already; half way up again would be more motion, not less
        action.broken_off = True
        action.then = Posture.BALANCE
        if action.settling:
            self._end_action(BROKEN_OFF)
        elif not self._body.airborne:  # else it lands first
            self._play(action, go2_gestures.stand)

    def _play(self, action: Action, make: Make) -> None:
        start = self._body.joints_rad if self.posture is Posture.LIMP else self._body.target_rad
        motion = make(start)
        action.settling = False
        action.seconds = self._now_s() - action.began_s + motion.seconds
        if isinstance(motion, Flight):
            self._body.animate(motion)
        else:
            self._body.play(motion)

    def _damp(self) -> int:
        self._note("damp")
        self._end_action(BROKEN_OFF)
        self._held_until_s = None
        self.posture = Posture.LIMP
        self._body.go_limp()
        return OK

    def _balance(self) -> int:
        if self.posture not in _STANDING:
            return UNSUITABLE
        if self.posture is Posture.LOCKED:
            self.posture = Posture.BALANCE
            self._body.walk(np.zeros(3))
        return OK

    def _stand_up(self, then: Posture, answer: Answer) -> None:
        if self._body.upright < FALLEN_BELOW:
            answer(UNSUITABLE)  # on its side or back: turning over is not simulated
        elif self.posture in _DOWN:
            self._begin(Offer("stand up", _DOWN, go2_gestures.rise, then, CODES[then]), answer)
        elif self.posture is Posture.SITTING or then is Posture.LOCKED:
            self._begin(Offer("stand up", _UP, go2_gestures.stand, then, CODES[then]), answer)
        else:
            answer(self._balance())

    def _begin(self, offer: Offer, answer: Answer) -> None:
        self._held_until_s = None
        action = Action(offer.name, offer.make, offer.then, self._now_s(), answer, offer.codes)
        self.action = action
        self._note("action_begin", action=offer.name)
        if self.posture is Posture.BALANCE and not self._body.settled:
            action.settling = True
            self._body.walk(np.zeros(3))
        else:
            self._play(action, offer.make)

    # ------------------------------------------------------------------ time
    def tick(self) -> None:
        """Once per period, before the world's tick."""
        if self._held_until_s is not None and self._now_s() >= self._held_until_s:
            self._held_until_s = None
            if self.posture is Posture.BALANCE and self.action is None:
                self._body.walk(np.zeros(3))
        if self.action is not None and self.action.settling:
            self._settle(self.action)
        elif self.action is not None and not self._body.playing:
            self.posture = self.action.then
            if self.posture is Posture.BALANCE:
                self._body.walk(np.zeros(3))
            self._end_action(BROKEN_OFF if self.action.broken_off else OK)
        if self._moving and (self._body.standing or self.action or self.posture is not Posture.BALANCE):
            self._moving = False
            self._note("move_end")
        if self._body.upright < FALLEN_BELOW and self.posture is not Posture.LIMP and self._body.led is None:
            self._note("fell")
            self._damp()

    def _settle(self, action: Action) -> None:
        if self._body.settled and not self._has_room(action.make):
            self._end_action(UNSUITABLE)  # somebody came near meanwhile
        elif self._body.settled:
            self._play(action, action.make)
        elif self._now_s() - action.began_s > SETTLE_LIMIT_S:
            self._end_action(BROKEN_OFF)  # pushed, or leaning on something: no gesture from there

    def reset(self) -> None:
        """Reset after the world was reset: no action runs, the robot stands in balance."""
        self._end_action(BROKEN_OFF)
        self._held_until_s = None
        self._moving = False
        self.posture = Posture.BALANCE
        self._note("reset")

    def _end_action(self, code: int) -> None:
        if self.action is None:
            return
        action, self.action = self.action, None
        self._note("action_end", action=action.name, code=code)
        action.answer(code)

    # ------------------------------------------------------------------ state
    @property
    def codes(self) -> tuple[int, int]:
        """`error_code` and `mode` for sportmodestate."""
        if self.action is not None:
            return self.action.codes
        if self.posture is Posture.BALANCE and not self._body.standing:
            return WALKING
        return CODES[self.posture]

    @property
    def progress(self) -> float:
        """Progress of the running action, 0 to 1."""
        if self.action is None:
            return 0.0
        return min(1.0, (self._now_s() - self.action.began_s) / self.action.seconds)

    def _note(self, event: str, **facts: Any) -> None:
        body = self._body
        x, y = body.xy_m
        pose = {"x_m": round(float(x), 4), "y_m": round(float(y), 4), "yaw_deg": round(math.degrees(body.yaw_rad), 2)}
        self._event_log.write(self._now_s(), body.name, event, pose, facts)
