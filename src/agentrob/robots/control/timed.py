"""Do something for a while: the control loop of an operation that is switched on, lasts, and is switched off."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from agentrob.model import ActionResult, Outcome, Primitive, RobotState
from agentrob.robots.control.controller import RATE_HZ
from agentrob.robots.protocol import Watch


class Clock(Protocol):
    """The part of a `step_runner.Body` that this needs."""

    def now_s(self) -> float: ...

    def wait_until(self, time_s: float) -> None: ...

    def state(self) -> RobotState: ...


def run_for(
    body: Clock, primitive: Primitive, watch: Watch, seconds: float, begin: Callable[[], None], end: Callable[[], None]
) -> ActionResult:
    """Call `begin`, wait so many seconds, call `end`, and measure `seconds`.

    The watch is asked before anything is begun and 20 times a second; `end` is called however it ends.
    """
    started_s, reason = time.monotonic(), watch(body.state())
    if reason:
        message = f"Stopped ({reason.replace('_', ' ')}) before it began."
        return ActionResult(primitive, Outcome.STOPPED, {"seconds": 0.0}, reason, message, started_s, time.monotonic())
    begun_s = body.now_s()
    try:
        begin()
        while not reason and (left_s := begun_s + seconds - body.now_s()) > 0:
            body.wait_until(body.now_s() + min(left_s, 1 / RATE_HZ))
            reason = watch(body.state())
    finally:
        end()
    measured = {"seconds": round(body.now_s() - begun_s, 3)}
    outcome = Outcome.STOPPED if reason else Outcome.DONE
    message = f"Asked {seconds:g} s, measured {measured['seconds']:.1f} s"
    message += f": stopped ({reason.replace('_', ' ')})." if reason else "."
    return ActionResult(primitive, outcome, measured, reason or "", message, started_s, time.monotonic())
