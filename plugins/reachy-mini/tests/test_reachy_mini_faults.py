"""The fault list of the README, one test each: what the guarded robot does, and what it says."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import pytest
from agentrob_reachy_mini.daemon import Daemon
from agentrob_reachy_mini.pose import BodyPose
from agentrob_reachy_mini.robot import ReachyMiniSim
from agentrob_reachy_mini.simulated_daemon import SimulatedDaemon
from reachy_scene import act, disturbed, ready, turn, until

from agentrob.config.robots import RobotConfig
from agentrob.model import Outcome
from agentrob.robots.contract import go_on
from agentrob.robots.safety.guard import Guard

FAR = turn(120)


# ------------------------------------------------------------------ lost link, frozen state
@pytest.mark.parametrize(
    ("disturb", "words"),
    [
        (lambda daemon: daemon.answering.clear(), "does not answer"),
        (lambda daemon: setattr(daemon.faults, "old_stamp", True), "repeats an old state"),
        (lambda daemon: setattr(daemon.faults, "frozen", True), "The motors have not answered"),
    ],
    ids=["silent daemon", "old state", "frozen motors"],
)
def test_law_8_a_state_older_than_half_a_second_stops_it_and_fails(
    guard: Guard, daemon: SimulatedDaemon, disturb: Callable[[SimulatedDaemon], object], words: str
) -> None:
    result = disturbed(guard, FAR, lambda: disturb(daemon))
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    assert result.measured == {}, "nothing is reported as measured that was not seen to its end"
    again = guard.step(FAR, go_on)
    assert (again.outcome, again.reason) == (Outcome.REFUSED, "stale_state")
    assert words in again.message
    daemon.answering.set()


def test_a_stop_of_a_daemon_that_does_not_answer_is_not_confirmed(guard: Guard, daemon: SimulatedDaemon) -> None:
    ready(guard)
    daemon.answering.clear()
    until(lambda: guard.state().age_s > 0.5, "its state is old")
    stopped = guard.stop()
    daemon.answering.set()
    assert not stopped.confirmed
    assert "did not confirm: its state is" in stopped.message


def test_a_daemon_that_is_not_there_is_named_in_the_refusal(url: str, listening: object) -> None:
    robot = ReachyMiniSim(RobotConfig(model="reachy-mini-sim", options={"url": "http://127.0.0.1:9"}))
    try:
        until(robot.silence, "it is noticed")
        refused = robot.step(act("nod"), go_on)
        assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "no_answer")
        assert "http://127.0.0.1:9 does not answer" in refused.message
        assert not robot.stop().confirmed
    finally:
        robot.close()


def test_a_daemon_that_is_killed_during_a_step_ends_it(guard: Guard, daemon: SimulatedDaemon) -> None:
    result = disturbed(guard, FAR, daemon.close)
    assert result.reason in ("stale_state", "no_answer")
    assert not result.ok


# ------------------------------------------------------------------ refused command, stuck
def test_a_refused_command_has_failed_and_says_what_the_daemon_answered(guard: Guard, daemon: SimulatedDaemon) -> None:
    ready(guard)
    daemon.faults.refusing = True
    result = guard.step(act("nod"), go_on)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "rejected")
    assert "answered 503: Backend not running" in result.message


@pytest.mark.parametrize("step", [turn(30), act("nod"), act("look_up", angle_deg=20.0), act("sway", seconds=3.0)])
def test_law_18_a_robot_that_accepts_a_move_and_does_not_move_has_failed(
    guard: Guard, daemon: SimulatedDaemon, step: object
) -> None:
    ready(guard)
    daemon.faults.stuck = True
    result = guard.step(step, go_on)  # type: ignore[arg-type]
    assert result.outcome is Outcome.FAILED
    assert "measured 0.0°" in result.message or "measured -0.0°" in result.message


def test_law_17_a_stop_that_is_acknowledged_and_not_obeyed_is_not_confirmed(
    robot: ReachyMiniSim, daemon: SimulatedDaemon
) -> None:
    ready(robot)
    daemon.faults.deaf = True
    moved = Daemon(robot.options.url)
    moved.goto(BodyPose(head_yaw=2.4, body_yaw=2.4), 8.0)
    stopped = robot.stop()
    moved.close()
    assert not stopped.confirmed
    assert stopped.was_moving
    assert "its daemon still runs a move" in stopped.message


# ------------------------------------------------------------------ wrong units
def test_a_state_in_degrees_is_not_believed_and_stops_it(guard: Guard, daemon: SimulatedDaemon) -> None:
    result = disturbed(guard, FAR, lambda: setattr(daemon.faults, "degrees", True))
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    assert "are these degrees? They must be radians." in guard.step(FAR, go_on).message


# ------------------------------------------------------------------ others move it, its motors are off
def test_law_12_a_move_of_another_program_is_a_halt_until_its_owner_releases_it(
    guard: Guard, daemon: SimulatedDaemon, robot: ReachyMiniSim
) -> None:
    ready(guard)
    other = Daemon(robot.options.url)
    other.goto(BodyPose(head_yaw=1.0, body_yaw=1.0), 5.0)
    until(lambda: guard.state().halted, "it is noticed")
    until(lambda: not other.running(), "the guard stops it")
    other.close()
    refused = guard.step(act("nod"), go_on)
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "halted")
    assert "which we did not command" in refused.message
    guard.release("alice")
    assert guard.step(act("nod"), go_on).outcome is Outcome.DONE


def test_law_12_motors_that_somebody_switches_off_are_a_halt(guard: Guard, daemon: SimulatedDaemon) -> None:
    result = disturbed(guard, FAR, lambda: setattr(daemon.faults, "limp", True))
    assert result.reason in ("halted", "stop")
    assert guard.state().halted


def test_law_12_a_body_that_somebody_turns_is_a_halt(guard: Guard, daemon: SimulatedDaemon) -> None:
    ready(guard)
    daemon.faults.pushed_s = time.monotonic()
    until(lambda: guard.state().halted, "it is noticed")


def test_it_refuses_while_another_program_moves_it(robot: ReachyMiniSim, daemon: SimulatedDaemon) -> None:
    ready(robot)
    other = Daemon(robot.options.url)
    other.goto(BodyPose(head_yaw=0.5, body_yaw=0.5), 2.0)
    refused = robot.step(act("nod"), go_on)
    other.close()
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "busy")


# ------------------------------------------------------------------ limits
def test_a_turn_beyond_its_reach_is_refused_with_the_limit(guard: Guard, daemon: SimulatedDaemon) -> None:
    ready(guard)
    assert guard.step(turn(90), go_on).outcome is Outcome.DONE
    sent = len(daemon.commands)
    refused = guard.step(turn(90), go_on)
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "limit_reach")
    assert "turn of its body would be 180°; it may be from -155° to 155°" in refused.message
    assert len(daemon.commands) == sent
    beyond = guard.step(turn(180), go_on)
    assert (beyond.outcome, beyond.reason) == (Outcome.REFUSED, "limit_step_deg")
    assert abs(math.degrees(daemon.present().body_yaw) - 90) < 1
