"""Shared by the tests of a Reachy Mini: steps, and how they wait."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from agentrob_reachy_mini.robot import ReachyMini

from agentrob.model import ActionResult, Direction, Op, Outcome, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.safety.guard import Guard

LIMIT_S = 60.0


def until(condition: Callable[[], Any], what: str) -> None:
    end_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < end_s, f"not within {LIMIT_S:.0f} s: {what}"
        time.sleep(0.01)


def turn(degrees: float, direction: Direction = Direction.LEFT) -> Primitive:
    return Primitive(Op.TURN, direction, degrees=degrees)


def act(name: str, **values: float | str) -> Primitive:
    return Primitive(name, arguments=tuple(values.items()))


def ready(robot: ReachyMini | Guard) -> RobotState:
    until(lambda: robot.state().age_s < 0.3, "a state")
    if isinstance(robot, Guard):
        until(lambda: robot.state().homed, "home")
    return robot.state()


def disturbed(robot: ReachyMini | Guard, step: Primitive, disturb: Callable[[], object]) -> ActionResult:
    """Begin a step, disturb it once its body has turned by a few degrees, and return how it ended."""
    start, turning, results = ready(robot), threading.Event(), list[ActionResult]()

    def notice(state: RobotState) -> str | None:
        if start.pose and state.pose and abs(state.pose.yaw_rad - start.pose.yaw_rad) > 0.1:
            turning.set()
        return go_on(state)

    thread = threading.Thread(target=lambda: results.append(robot.step(step, notice)))
    thread.start()
    until(lambda: turning.is_set() or results, "it turns")
    disturb()
    thread.join(LIMIT_S)
    (result,) = results
    assert result.outcome is not Outcome.DONE, result.message
    return result
