"""Faults of the arm with its guard: lost link, frozen state, refused commands, wrong units,
keep-out boxes, limits, somebody else who moves it. Its simulated world tells what really happened."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from agentrob_so101.arm import So101
from agentrob_so101.pose import farthest_deg
from so101_world import LIMIT_S, WorldProcess, until

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Op, Outcome, Primitive
from agentrob.robots.contract import go_on
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt

pytestmark = pytest.mark.sim
#: A goal is at most so far ahead of the arm when it stops, and it swings.
COAST_DEG = 12.0
#: Where the arm comes to while a step does not end: its fastest joint for the age of a state and for the loop.
STOPPED_DEG = 45.0 * 0.75 + COAST_DEG
#: A box to the left of the arm, which it may pass in front of.
KEEP_OUT = {"name": "the monitor", "from_m": [0.05, 0.056, 0.05], "to_m": [0.50, 0.40, 0.60]}


def primitive(robot: So101, op: str, **said: Any) -> Primitive:
    operation = robot.capabilities.operation(op)
    assert operation is not None
    return Primitive(op, arguments=operation.complete(said), declared=operation)


def left(robot: So101) -> Primitive:
    return primitive(robot, "point", way="left", angle=80.0)


def disturbed(guard: Guard, robot: So101, world: WorldProcess, **fault: Any) -> ActionResult:
    """Point to the left; the fault begins when the arm has turned by 20°.

    On a busy machine nothing may come for half a second, which ends a step as it should: then it begins again.
    """
    until(lambda: guard.state().homed, "home")
    results: list[ActionResult] = []
    while True:
        results.clear()
        running = threading.Thread(target=lambda: results.append(guard.step(left(robot), go_on)))
        running.start()
        until(lambda: results or world.pose().shoulder_pan < -20.0, "motion")
        if not results or results[0].reason != "stale_state":
            break
        until(lambda: guard.step(primitive(robot, "rest_pose"), go_on).ok, "it is at home again")
    world.apply(**fault)
    running.join(LIMIT_S)
    return results[0]


# ------------------------------------------------------------------ lost link, frozen state
def test_law_8_a_lost_link_stops_it_within_the_age_of_a_state(guard: Guard, robot: So101, world: WorldProcess) -> None:
    result = disturbed(guard, robot, world, silent=True)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    assert result.measured == {}
    assert world.pose().shoulder_pan > -20.0 - STOPPED_DEG
    until(lambda: "The arm does not answer" in robot.silence(), "it is noticed")
    again = guard.step(left(robot), go_on)
    assert (again.outcome, again.reason) == (Outcome.REFUSED, "stale_state")
    assert "The arm does not answer" in again.message
    stopped = guard.stop()
    assert not stopped.confirmed
    assert "s old" in stopped.message


def test_law_8_positions_that_are_frozen_stop_it(guard: Guard, robot: So101, world: WorldProcess) -> None:
    result = disturbed(guard, robot, world, frozen=True)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "stalled")
    assert "positions do not change" in result.message
    assert world.pose().shoulder_pan > -20.0 - STOPPED_DEG


# ------------------------------------------------------------------ refused commands
def test_an_arm_that_refuses_goals_has_failed(guard: Guard, robot: So101, world: WorldProcess) -> None:
    result = disturbed(guard, robot, world, deaf=True)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "no_answer")
    assert "the servos refuse goals" in result.message
    assert world.pose().shoulder_pan > -20.0 - STOPPED_DEG


def test_an_arm_whose_servos_lose_their_torque_has_failed(guard: Guard, robot: So101, world: WorldProcess) -> None:
    result = disturbed(guard, robot, world, limp=True)
    assert not result.ok
    assert result.reason in ("stalled", "keep_out", "limit_turn_dps")  # it sinks to the table


# ------------------------------------------------------------------ wrong units
@pytest.mark.parametrize("units", ["ticks"])
def test_positions_in_other_units_are_not_used_and_told(robot: So101, world: WorldProcess, units: str) -> None:
    until(lambda: robot.state().age_s < 0.5, "a state")
    world.apply(units=units)
    until(lambda: "not in degrees" in robot.silence(), "it is noticed")
    until(lambda: robot.state().age_s > 0.5, "its state is old")
    refused = robot.step(left(robot), go_on)
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "stale_state")
    assert "not in degrees: is it calibrated" in refused.message


def test_positions_in_radians_end_the_step_that_they_begin_in(guard: Guard, robot: So101, world: WorldProcess) -> None:
    result = disturbed(guard, robot, world, units="radians")
    assert not result.ok
    assert result.reason in ("stalled", "limit_turn_dps")
    assert world.pose().shoulder_pan > -20.0 - STOPPED_DEG


# ------------------------------------------------------------------ keep-out boxes and limits
@pytest.fixture
def fenced(world: WorldProcess, tmp_path: Path) -> Iterator[tuple[Guard, So101]]:
    """An arm with a monitor to its left."""
    settings = world.settings(keep_out=[KEEP_OUT], joints={"shoulder_pan": [-90, 45]})
    arm = So101(settings)
    guard = Guard(arm, settings, Halt(tmp_path / "halt"))
    until(lambda: guard.state().homed, "home")
    yield guard, arm
    guard.close()


def test_a_way_into_a_keep_out_box_is_refused_before_it_begins(
    fenced: tuple[Guard, So101], world: WorldProcess
) -> None:
    guard, arm = fenced
    before = world.apply()["acted"]
    result = guard.step(primitive(arm, "point", way="left"), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "keep_out")
    assert "too near to the monitor on its way" in result.message
    assert world.apply()["acted"] == before
    assert guard.step(primitive(arm, "point", way="up"), go_on).outcome is Outcome.DONE


def test_an_arm_that_is_pushed_into_a_keep_out_box_is_stopped(fenced: tuple[Guard, So101], world: WorldProcess) -> None:
    guard, arm = fenced
    results: list[ActionResult] = []
    running = threading.Thread(target=lambda: results.append(guard.step(primitive(arm, Op.HELLO), go_on)))
    running.start()
    until(lambda: results or world.pose().shoulder_lift > -50.0, "motion")
    for torque in range(1, 13):
        world.apply(push=-torque / 4)
        until(lambda torque=torque: results or world.pose().shoulder_pan < -0.6 * torque, "it gives way")
    running.join(LIMIT_S)
    assert (results[0].outcome, results[0].reason) == (Outcome.STOPPED, "keep_out")
    assert "The arm is too near to the monitor." in results[0].message
    held = world.goal()
    assert guard.step(primitive(arm, "rest_pose"), go_on).reason in ("keep_out", "halted")
    assert farthest_deg(held, world.goal())[1] < 0.5


def test_a_pose_beyond_the_limits_of_its_owner_is_refused(fenced: tuple[Guard, So101], world: WorldProcess) -> None:
    guard, arm = fenced
    result = guard.step(primitive(arm, "point", way="right"), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "joint_limits")
    assert "The joint shoulder_pan would be at 60°; it may be from -90 to 45°." in result.message


def test_law_10_no_goal_leads_a_joint_faster_than_its_limit(robot: So101, world: WorldProcess) -> None:
    until(lambda: robot.state().age_s < 0.5, "a state")
    began_s, done = time.monotonic(), threading.Event()
    goals = [(began_s, began_s, world.goal().shoulder_pan)]

    def record() -> None:
        while not done.wait(0.01):
            asked_s, pan = time.monotonic(), world.goal().shoulder_pan
            goals.append((asked_s, time.monotonic(), pan))

    recorder = threading.Thread(target=record)
    recorder.start()
    assert robot.step(left(robot), go_on).outcome in (Outcome.DONE, Outcome.STOPPED)
    done.set()
    recorder.join(LIMIT_S)
    for asked_s, _, pan in goals:  # over each half second, the fastest that two times of asking allow
        later = [one for one in goals if one[1] - asked_s > 0.5]
        if later:
            assert abs(later[0][2] - pan) <= 45.0 * (later[0][1] - asked_s) + 2.0
    assert goals[-1][2] < -70.0


# ------------------------------------------------------------------ somebody else
def test_law_12_an_arm_that_somebody_else_moves_is_a_halt(guard: Guard, robot: So101, world: WorldProcess) -> None:
    until(lambda: guard.state().homed and guard.state().mode == "idle", "home")
    world.apply(push=3.3)
    until(lambda: guard.state().halted, "the guard halts")
    refused = guard.step(left(robot), go_on)
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "halted")


def test_a_stop_holds_the_arm_where_it_is_and_nothing_follows(robot: So101, world: WorldProcess) -> None:
    until(lambda: robot.state().age_s < 0.5, "a state")
    results: list[ActionResult] = []
    running = threading.Thread(target=lambda: results.append(robot.step(left(robot), go_on)))
    running.start()
    until(lambda: results or world.pose().shoulder_pan < -20.0, "motion")
    stopped = robot.stop()
    running.join(LIMIT_S)
    assert (results[0].outcome, results[0].reason) == (Outcome.STOPPED, "stop")
    assert stopped.confirmed, stopped.message
    assert stopped.was_moving
    held = world.goal()
    assert farthest_deg(held, world.pose())[1] < COAST_DEG
    for _ in range(3):  # stopping again does not lower it
        assert robot.stop().confirmed
    assert farthest_deg(held, world.goal())[1] < 0.5


def test_an_arm_whose_world_is_not_there_says_so() -> None:
    robot = So101(RobotConfig(model="so101", domain=229, simulated=True))
    try:
        refused = robot.step(left(robot), go_on)
        assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "stale_state")
        assert "The arm does not answer" in robot.silence()
    finally:
        robot.close()
