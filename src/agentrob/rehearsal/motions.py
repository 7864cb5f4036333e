"""Command the simulated bodies to walk and to gesture, through the same services that answer a driver on DDS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from agentrob.model import Op
from agentrob.robots.control.controller import Gait, Velocity
from agentrob.robots.unitree import g1 as g1_driver
from agentrob.robots.unitree import go2 as go2_driver
from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.bodies.sensors import Ranges
from agentrob.sim.event_log import EventLog
from agentrob.sim.services import g1_sport, go2_sport
from agentrob.sim.world.legged import Legged

Answer = Callable[..., None]
#: One call of a gesture, which is answered when it has ended; or seconds to wait.
Call = Callable[[Answer], None] | float
RangesM = tuple[float | None, float | None, float | None, float | None]

_GO2_GESTURES = {
    Op.HELLO: (go2_sport.HELLO,),
    Op.HEART: (go2_sport.HEART,),
    Op.BACKFLIP: (go2_sport.BACK_FLIP,),
    Op.SIT: (go2_sport.SIT,),
    Op.STAND: (go2_sport.RECOVERY_STAND, go2_sport.BALANCE_STAND),
    Op.STRETCH: (go2_sport.STRETCH,),
}


def ignore(*_: object) -> None:
    """An answer that nobody waits for."""


class Motions(Protocol):
    """One body and its motion service. `gait` is that of the robot's driver."""

    @property
    def body(self) -> Legged: ...

    @property
    def gait(self) -> Gait: ...

    @property
    def mode(self) -> str: ...

    @property
    def flipping(self) -> bool:
        """Whether it was commanded to be upside down."""
        ...

    def walk(self, velocity: Velocity) -> None: ...

    def rest(self) -> None: ...

    def calls(self, op: Op) -> Sequence[Call]:
        """The calls of a gesture, one after the other."""
        ...

    def ranges_m(self) -> RangesM: ...

    def tick(self) -> None: ...

    def reset(self, rng: np.random.Generator) -> None:
        """Begin again after the world was reset."""
        ...


class Go2Motions:
    """A Go2 and its sport service."""

    gait = go2_driver.GAIT

    def __init__(self, body: Go2, now_s: Callable[[], float]) -> None:
        self.body = body
        self._sport = go2_sport.Sport(body, now_s, EventLog())
        self._ranges: Ranges | None = None

    @property
    def mode(self) -> str:
        return go2_driver.MODES_BY_CODE.get(self._sport.codes[0], "unknown")

    @property
    def flipping(self) -> bool:
        return self._sport.action is not None and self._sport.action.name == "backflip"

    def walk(self, velocity: Velocity) -> None:
        forward, left, turn = (float(v) for v in velocity)
        self._sport.call(go2_sport.MOVE, {"x": forward, "y": left, "z": turn}, ignore)

    def rest(self) -> None:
        self._sport.call(go2_sport.STOP_MOVE, {}, ignore)

    def calls(self, op: Op) -> Sequence[Call]:
        return [self._call(api_id) for api_id in _GO2_GESTURES[op]]

    def _call(self, api_id: int) -> Call:
        return lambda answer: self._sport.call(api_id, {}, answer)

    def ranges_m(self) -> RangesM:
        assert self._ranges is not None
        front, left, back, right = (float(v) for v in self._ranges.read())
        return front, left, back, right

    def tick(self) -> None:
        self._sport.tick()

    def reset(self, rng: np.random.Generator) -> None:
        self._sport.reset()
        self._ranges = Ranges(self.body, rng, noisy=True)


class G1Motions:
    """A G1 with its sport and arm services. It senses nothing around it."""

    gait = g1_driver.GAIT
    flipping = False

    def __init__(self, body: G1, now_s: Callable[[], float]) -> None:
        self.body = body
        self._sport = g1_sport.G1Sport(body, now_s, EventLog())

    @property
    def mode(self) -> str:
        if self._sport.fsm is not g1_sport.Fsm.WALK:
            return "damping"
        if self._sport.action is not None:
            return "gesture"
        return "idle" if self.body.standing else "walking"

    def walk(self, velocity: Velocity) -> None:
        given = {"velocity": [float(v) for v in velocity], "duration": g1_driver.HELD_S}
        self._sport.call(g1_sport.SET_VELOCITY, given, ignore)

    def rest(self) -> None:
        self.walk(Velocity())
        if self._sport.action is not None:
            self._arm(g1_driver.RELEASE)(ignore)

    def calls(self, op: Op) -> Sequence[Call]:
        gesture: Call = self._arm(g1_driver.ACTIONS[op])
        return [gesture, g1_driver.SHOWN_S, self._arm(g1_driver.RELEASE)] if op in g1_driver.HOLDING else [gesture]

    def _arm(self, action: int) -> Callable[[Answer], None]:
        return lambda answer: self._sport.call_arm(g1_sport.EXECUTE_ACTION, {"data": action}, answer)

    def ranges_m(self) -> RangesM:
        return None, None, None, None

    def tick(self) -> None:
        self._sport.tick()

    def reset(self, rng: np.random.Generator) -> None:
        self._sport.reset()


def motions_of(body: Legged, now_s: Callable[[], float]) -> Motions:
    """The motion service of a body."""
    if isinstance(body, G1):
        return G1Motions(body, now_s)
    assert isinstance(body, Go2)
    return Go2Motions(body, now_s)
