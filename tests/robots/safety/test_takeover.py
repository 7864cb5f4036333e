"""Law 12: which modes and motions count as a takeover, and when they are our own."""

from __future__ import annotations

import math

import pytest

from agentrob.model import Op, RobotState
from agentrob.robots.safety.takeover import TakeoverDetector

Velocity = tuple[float, float] | None


class Watched:
    """A detector that has seen the robot idle at 0 s."""

    def __init__(self) -> None:
        self.detector = TakeoverDetector()
        assert self.see(0.0) is None

    def see(
        self, now_s: float, mode: str = "idle", velocity_mps: Velocity = (0.0, 0.0), age_s: float = 0.0, step: str = ""
    ) -> str | None:
        state = RobotState(age_s=age_s, mode=mode, velocity_mps=velocity_mps)
        return self.detector.update(now_s, state, walking=step == "walk", gesturing=step == "gesture")


@pytest.mark.parametrize("mode", ["damping", "locked", "lying", "sitting", "gesture"])
def test_law_12_a_mode_that_no_robot_takes_by_itself_is_a_takeover(mode: str) -> None:
    watched = Watched()
    assert watched.see(1.0, mode) == f"the robot went from idle to {mode}, which we did not command"
    assert watched.see(1.1, mode) is None, "it is told once"


@pytest.mark.parametrize("mode", ["walking", "idle", ""])
def test_another_mode_is_none(mode: str) -> None:
    assert Watched().see(1.0, mode) is None


def test_law_12_a_mode_is_ours_until_three_seconds_after_our_step() -> None:
    for step in ("walk", "gesture"):
        for after_s, ours in ((2.9, True), (3.0, False)):
            watched = Watched()
            assert watched.see(10.0, step=step) is None
            assert (watched.see(10.0 + after_s, "locked") is None) is ours
    watched = Watched()
    watched.detector.own_motion(10.0)
    assert watched.see(12.9, "locked") is None


def test_law_12_a_gesture_changes_the_mode_and_a_walk_does_not() -> None:
    assert Watched().see(1.0, "sitting", step="gesture") is None
    assert Watched().see(1.0, "sitting", step="walk") is not None


@pytest.mark.parametrize("step", ["", "walk", "gesture"])
def test_law_12_damping_is_never_ours(step: str) -> None:
    watched = Watched()
    watched.see(1.0, step=step)
    assert watched.see(1.1, "damping", step=step) is not None
    assert watched.see(1.2, "damping", step=step) is None, "it was told"


def moves(watched: Watched, *times_s: float, velocity_mps: Velocity = (0.2, 0.0), age_s: float = 0.0) -> list[bool]:
    """At which of these times motion is a takeover."""
    return [watched.see(now_s, "walking", velocity_mps, age_s) is not None for now_s in times_s]


def test_law_12_half_a_second_of_motion_is_a_takeover() -> None:
    assert moves(Watched(), 0.25, 0.5, 0.75) == [False, False, True]
    assert moves(Watched(), 0.25, 0.5, 0.75, 1.0, 1.25, 1.5) == [False, False, True, False, False, True]
    assert moves(Watched(), 0.25, 0.5, 0.75, velocity_mps=(0.0, -0.2)) == [False, False, True]
    assert moves(Watched(), 0.25, 0.5, 0.75, age_s=0.5) == [False, False, True]


def test_law_12_a_robot_that_moves_when_its_first_state_comes_is_not_ours() -> None:
    state = RobotState(age_s=0.0, mode="walking", velocity_mps=(0.5, 0.0))
    assert TakeoverDetector().update(1.0, state, walking=False, gesturing=False) is not None


@pytest.mark.parametrize(
    ("velocity_mps", "age_s"), [((0.19, 0.0), 0.0), (None, 0.0), ((0.5, 0.0), 0.51)], ids=["slow", "unknown", "old"]
)
def test_slow_unknown_and_old_motion_is_none(velocity_mps: Velocity, age_s: float) -> None:
    assert moves(Watched(), 0.25, 0.5, 0.75, 5.0, velocity_mps=velocity_mps, age_s=age_s) == [False] * 4


def test_motion_that_paused_counts_from_anew() -> None:
    watched = Watched()
    assert moves(watched, 0.25, 0.5) == [False, False]
    watched.see(0.55)
    assert moves(watched, 0.75, 1.0, 1.1) == [False, False, True]


def test_law_12_motion_is_ours_until_three_seconds_after_our_step() -> None:
    watched = Watched()
    watched.see(10.0, step="walk")
    assert moves(watched, 11.0, 12.9, 13.25, 13.5) == [False, False, False, True]


def test_law_12_a_walk_of_a_driver_that_died_may_fade_for_two_seconds() -> None:
    watched = Watched()
    watched.detector.inherit(10.0, Op.MOVE, "walking")
    assert moves(watched, 10.1, 11.0, 11.9, 12.3, 12.5) == [False, False, False, False, True]
    watched = Watched()
    watched.detector.inherit(10.0, Op.MOVE, "walking")
    assert moves(watched, 11.4, 12.0) == [False, True], "from two seconds on"
    watched = Watched()
    watched.detector.inherit(10.0, Op.MOVE, "walking")
    assert watched.see(10.1, "gesture") == "the robot went from walking to gesture, which we did not command"


@pytest.mark.parametrize(
    ("op", "modes"),
    [(Op.SIT, {"gesture", "sitting"}), (Op.STAND, {"gesture", "locked"}), (Op.HELLO, {"gesture"}), (Op.TURN, set())],
)
def test_law_12_a_gesture_of_a_driver_that_died_may_go_on_for_ten_seconds(op: Op, modes: set[str]) -> None:
    for mode in ("gesture", "sitting", "locked", "lying", "damping"):
        for after_s in (9.9, 10.0):
            watched = Watched()
            watched.detector.inherit(10.0, op, "idle")
            assert (watched.see(10.0 + after_s, mode) is None) is (mode in modes and after_s < 10.0), (mode, after_s)


def test_before_the_first_state_there_is_no_takeover() -> None:
    detector = TakeoverDetector()
    for now_s in (0.0, 5.0):
        none_yet = RobotState(age_s=math.inf, mode="damping", velocity_mps=(1.0, 0.0))
        assert detector.update(now_s, none_yet, walking=False, gesturing=False) is None
