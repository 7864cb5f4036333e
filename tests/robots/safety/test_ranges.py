"""Law 8: when a range reading is known, and how much free space a step needs on which side."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from agentrob.model import BUILT_IN, Direction, Op, Primitive, RobotState
from agentrob.robots.safety.ranges import RangeMonitor, clearances, obstacle_in
from tests.robots.guard_scene import B, F, L, R, move, turn

FREE = (2.0, 2.1, 2.2, 2.3)


def monitor_of(*readings: tuple[float | None, ...], every_s: float = 0.05, age_s: float = 0.0) -> RangeMonitor:
    """A monitor that has received these readings one after the other."""
    monitor = RangeMonitor()
    for n, ranges in enumerate(readings):
        monitor.update(100.0 + n * every_s, RobotState(age_s=age_s, ranges_m=ranges))  # type: ignore[arg-type]
    return monitor


def noisy(ranges: tuple[float, ...], count: int = 5) -> list[tuple[float, ...]]:
    """Readings of a working sensor; the last ones are `ranges`."""
    return [tuple(r + (count - 1 - n) / 1000 for r in ranges) for n in range(count)]


def test_law_8_readings_are_known_from_the_fifth_on() -> None:
    assert monitor_of(*noisy(FREE, 4)).known() == (None,) * 4
    assert not monitor_of(*noisy(FREE, 4)).enough
    assert monitor_of(*noisy(FREE, 5)).known() == FREE
    assert monitor_of(*noisy(FREE, 5)).enough


def test_law_8_a_state_of_a_fifth_of_a_second_brings_no_reading() -> None:
    assert monitor_of(*noisy(FREE), age_s=0.19).enough
    assert not monitor_of(*noisy(FREE), age_s=0.2).enough


@pytest.mark.parametrize("side", range(4))
@pytest.mark.parametrize("bad", [None, 0.0, -1.0, math.nan, math.inf])
def test_law_8_a_reading_that_is_no_distance_is_unknown_and_the_others_are_known(side: int, bad: float | None) -> None:
    last = [bad if n == side else r for n, r in enumerate(FREE)]
    known = monitor_of(*noisy(FREE), tuple(last)).known()
    assert known == tuple(None if n == side else r for n, r in enumerate(FREE))


def test_law_8_a_reading_that_did_not_change_within_a_second_is_unknown() -> None:
    changed = (2.5, *FREE[1:])
    still = [FREE] * 4
    assert monitor_of(changed, *still, every_s=0.25).known()[0] == 2.0, "it changed a second ago"
    assert monitor_of(changed, *still, FREE, every_s=0.25).known() == (None,) * 4
    assert monitor_of(changed, *still, every_s=0.25).known()[1:] == (None,) * 3


def test_a_window_is_settled_when_it_holds_almost_a_second() -> None:
    assert not monitor_of(*noisy(FREE, 6), every_s=0.15).settled
    assert monitor_of(*noisy(FREE, 7), every_s=0.15).settled
    assert not monitor_of(*noisy(FREE, 3), every_s=0.5).settled, "too few"


@pytest.mark.parametrize(
    ("direction", "needed"),
    [
        (F, {0: 0.675, 1: 0.21, 3: 0.21}),
        (L, {1: 0.485, 2: 0.40, 0: 0.40}),
        (B, {2: 0.675, 3: 0.21, 1: 0.21}),
        (R, {3: 0.485, 0: 0.40, 2: 0.40}),
    ],
)
def test_law_8_a_walk_needs_room_ahead_by_its_speed_and_some_at_its_flanks(
    direction: Direction, needed: dict[int, float]
) -> None:
    assert dict(clearances(move(1.0, direction), 0.5)) == pytest.approx(needed)


def test_law_8_a_turn_needs_room_on_all_sides_and_a_gesture_is_not_judged() -> None:
    assert dict(clearances(turn(90), 0.0)) == dict.fromkeys(range(4), 0.40)
    assert clearances(Primitive(Op.HELLO), 0.0) == ()


def test_law_8_a_turn_on_a_foot_that_stays_needs_what_the_robot_declares() -> None:
    stays = replace(BUILT_IN[Op.TURN], travel_m=0.0)
    assert clearances(replace(turn(90), declared=stays), 0.0) == ()
    roomy = replace(turn(90), declared=replace(stays, free_space_m=0.25))
    assert dict(clearances(roomy, 0.0)) == dict.fromkeys(range(4), 0.25)
    leaves = replace(turn(90), declared=replace(BUILT_IN[Op.TURN], free_space_m=0.1))
    assert dict(clearances(leaves, 0.0)) == dict.fromkeys(range(4), 0.40), "it may leave its place: as for any robot"


@pytest.mark.parametrize(("side", "named"), [(0, "ahead"), (1, "to the left"), (2, "behind"), (3, "to the right")])
def test_law_8_what_is_nearer_than_needed_is_an_obstacle_and_is_named_with_its_side(side: int, named: str) -> None:
    near = tuple(0.39 if n == side else 1.0 for n in range(4))
    sentence = monitor_of(*noisy(near)).obstacle(turn(90), 0.0)
    assert sentence == f"Something is 0.39 m {named}; this step needs 0.40 m there."
    assert obstacle_in(sentence) == ([F, L, B, R][side], "0.39", "0.40")
    enough = tuple(0.40 if n == side else 1.0 for n in range(4))
    assert monitor_of(*noisy(enough)).obstacle(turn(90), 0.0) is None
    assert obstacle_in("The time for this step was over.") is None


def test_law_8_a_step_is_unknown_if_a_side_that_it_needs_is() -> None:
    monitor = monitor_of(*noisy(FREE), (None, *FREE[1:]))
    assert monitor.unknown(move(1.0))
    assert monitor.unknown(turn(90))
    assert not monitor.unknown(move(1.0, B))
    assert not monitor.unknown(Primitive(Op.HELLO))
