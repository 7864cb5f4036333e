"""The clock of a simulated robot: it follows the timestamps of its states, and never lets a wait last forever."""

from __future__ import annotations

import threading
import time

import pytest

from agentrob.robots.control.clock import LATE_S, SILENT_S, STATE_EVERY_S, StampClock

PERIOD_S = 0.02


def passed(clock: StampClock, states: int, *, every_s: float, stamps_s: float, from_s: float = 100.0) -> float:
    """Return how far the clock advances over `states` states that arrive `every_s` apart, with timestamps `stamps_s`
    apart."""
    came_s = time.monotonic() - states * every_s
    clock.take(came_s, from_s)
    start_s = clock._at(came_s)
    for k in range(1, states + 1):
        clock.take(came_s + k * every_s, from_s + k * stamps_s)
    return clock._at(came_s + states * every_s) - start_s


@pytest.mark.parametrize("speed", [0.3, 0.5, 1.0, 4.0])
def test_it_goes_as_fast_as_the_robots_world(speed: float) -> None:
    assert passed(StampClock(), 100, every_s=PERIOD_S / speed, stamps_s=PERIOD_S) == pytest.approx(2.0, abs=0.03)


@pytest.mark.parametrize("stamps_s", [0.0, -1.0, 3600.0], ids=["none", "going back", "leaping"])
def test_where_the_stamps_tell_nothing_it_goes_as_the_hosts_clock(stamps_s: float) -> None:
    assert passed(StampClock(), 100, every_s=PERIOD_S, stamps_s=stamps_s) == pytest.approx(2.0, abs=0.03)


def test_a_wait_lasts_until_the_robots_clock_is_there() -> None:
    clock, ended = StampClock(), threading.Event()
    clock.take(time.monotonic(), 50.0)
    goal_s = clock.now_s() + 10 * PERIOD_S
    began_s = time.monotonic()

    def world() -> None:  # at four times real time
        for k in range(1, 20):
            time.sleep(PERIOD_S / 4)
            clock.take(time.monotonic(), 50.0 + k * PERIOD_S)
        ended.set()

    threading.Thread(target=world, daemon=True).start()
    clock.wait_until(goal_s)
    assert clock.now_s() >= goal_s
    assert time.monotonic() - began_s < 10 * PERIOD_S + LATE_S
    assert ended.wait(60)


def test_a_wait_for_a_robot_that_sends_nothing_ends_so_that_a_stop_is_noticed() -> None:
    clock, began_s = StampClock(), time.monotonic()
    clock.take(began_s, 50.0)
    clock.wait_until(clock.now_s() + 0.05)
    assert 0.05 <= time.monotonic() - began_s < 1.0
    assert clock.now_s() < 0.05 + STATE_EVERY_S


def test_the_clock_of_a_silent_robot_goes_on() -> None:
    clock, now_s = StampClock(), time.monotonic()
    clock.take(now_s, 50.0)
    assert clock._at(now_s + SILENT_S + 3.0) - clock._at(now_s) == pytest.approx(3.0 + STATE_EVERY_S)


def test_it_never_goes_back() -> None:
    clock, now_s = StampClock(), time.monotonic()
    clock.take(now_s - 10, 50.0)
    before_s = clock.now_s()
    clock.take(now_s, 50.02)  # silent for ten seconds in a paused world
    assert clock.now_s() >= before_s
