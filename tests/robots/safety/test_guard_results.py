"""The guard checks the result of a step: one that was not observed to its end, and jumps of the odometry."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Op, Outcome, Pose, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.control.step_runner import JUMPED, LOST
from agentrob.robots.fake import FakeRobot
from agentrob.robots.protocol import Watch
from agentrob.robots.safety.guard import Guard, SimulatedTime
from agentrob.robots.safety.lock import Halt
from agentrob.robots.safety.takeover import OURS_S
from tests.robots.guard_scene import Make, age_states, fake_of, move
from tests.waiting import wait_for

HELLO = Primitive(Op.HELLO)


def after_its_step(guard: Guard, monkeypatch: pytest.MonkeyPatch, happens: Callable[[], None]) -> None:
    """Let something happen when the robot's own step has ended, which the guard has not seen yet."""
    step = fake_of(guard).step

    def stepped(primitive: Primitive, watch: Watch) -> ActionResult:
        result = step(primitive, watch)
        happens()
        return result

    monkeypatch.setattr(fake_of(guard), "step", stepped)


@pytest.mark.parametrize(("age_s", "measured"), [(0.49, True), (0.5, False)])
def test_law_18_a_step_whose_state_is_lost_at_its_end_is_not_measured(
    make: Make, monkeypatch: pytest.MonkeyPatch, age_s: float, measured: bool
) -> None:
    guard = make()
    after_its_step(guard, monkeypatch, lambda: age_states(guard, monkeypatch, age_s))
    result = guard.step(move(0.3), go_on)
    assert bool(result.measured) is measured
    if not measured:
        assert (result.outcome, result.unmeasured) == (Outcome.UNKNOWN, LOST)


def test_law_18_a_gesture_has_nothing_that_could_be_lost(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    guard = make()
    after_its_step(guard, monkeypatch, lambda: age_states(guard, monkeypatch, 1.0))
    result = guard.step(HELLO, go_on)
    assert (result.outcome, result.unmeasured) == (Outcome.DONE, "")


def test_law_18_a_jump_is_the_reason_also_if_the_state_is_lost_after_it(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)

    def jump(state: RobotState) -> None:
        if state.pose is not None and 0.1 < state.pose.x_m < 1.0:
            fake_of(guard).carry(Pose(5.0, 0.0, 0.0))

    after_its_step(guard, monkeypatch, lambda: age_states(guard, monkeypatch, 1.0))
    result = guard.step(move(0.5), jump)
    assert (result.outcome, result.reason, result.unmeasured) == (Outcome.STOPPED, "odometry_jump", JUMPED)


def test_law_18_a_jump_stays_the_reason_if_the_state_is_lost_before_the_next_look(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)

    def stepped(primitive: Primitive, watch: Watch) -> ActionResult:
        fake_of(guard).carry(Pose(5.0, 0.0, 0.0))
        guard.observe()
        age_states(guard, monkeypatch, 1.0)
        reason = watch(fake_of(guard).state())
        return ActionResult(primitive, Outcome.STOPPED, {"distance_m": 0.2}, reason or "")

    monkeypatch.setattr(fake_of(guard), "step", stepped)
    result = guard.step(move(0.5), go_on)
    assert (result.reason, result.unmeasured, result.measured) == ("stale_state", JUMPED, {})


def test_law_8_a_step_during_which_the_robot_tells_no_position_is_ended_and_says_so(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)
    seen = fake_of(guard)._seen
    result = guard.step(
        HELLO, lambda _: monkeypatch.setattr(fake_of(guard), "_seen", lambda: replace(seen(), pose=None))
    )
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    assert "The robot tells no position: its odometry is missing or not a number." in result.message


def test_law_18_a_gesture_during_which_the_odometry_jumps_has_not_left_its_place(make: Make) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)
    result = guard.step(HELLO, lambda _: fake_of(guard).carry(Pose(5.0, 0.0, 0.0)))
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "odometry_jump")
    assert "from its place" not in result.message


@pytest.mark.parametrize(("later_s", "halted"), [(OURS_S - 0.1, False), (OURS_S, True)])
def test_law_12_what_a_step_leads_to_is_ours_for_three_seconds_after_its_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, later_s: float, halted: bool
) -> None:
    """Also if the robot took so long that nobody looked at it meanwhile."""
    settings = RobotConfig(model="fake", simulated=True, options={"time_scale": math.inf})
    robot = FakeRobot(settings)
    time = SimulatedTime(robot.now_s, lambda seconds: robot.wait_until(robot.now_s() + seconds))
    guard = Guard(robot, settings, Halt(tmp_path / "halt"), simulated_time=time, home=Pose(0.0, 0.0, 0.0))

    def sit(primitive: Primitive, watch: Watch) -> ActionResult:
        watch(robot.state())
        time.wait(20.0)
        return ActionResult(primitive, Outcome.DONE)

    monkeypatch.setattr(robot, "step", sit)
    assert guard.step(Primitive(Op.SIT), go_on).ok
    time.wait(later_s)
    robot.faults.mode = "sitting"
    guard.observe()
    assert guard.state().halted is halted
