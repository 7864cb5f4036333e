"""The simulated base: its scan shows walls and things where they are, and it moves as its wheels do."""

from __future__ import annotations

import math

import pytest
from agentrob_ros2.simulated_base import BEAMS, RANGE_MAX_M, Box, Pillar, SimulatedBase

NOISE_M = 0.05  # six sigma


def beam(base: SimulatedBase, degrees: float) -> float:
    return base.scan()[round(degrees * BEAMS / 360) % BEAMS]


def test_a_scan_shows_walls_boxes_and_pillars_where_they_are() -> None:
    base = SimulatedBase(obstacles=[Box(2.0, 0.0, 0.5, 0.5), Pillar(0.0, -1.5, 0.2)])
    assert beam(base, 0) == pytest.approx(1.75, abs=NOISE_M)
    assert beam(base, 90) == pytest.approx(4.0, abs=NOISE_M)
    assert beam(base, 180) == pytest.approx(4.0, abs=NOISE_M)
    assert beam(base, 270) == pytest.approx(1.3, abs=NOISE_M)
    assert beam(base, 20) == pytest.approx(4.0 / math.cos(math.radians(20)), abs=NOISE_M)
    base.yaw_rad = math.pi
    assert beam(base, 180) == pytest.approx(1.75, abs=NOISE_M)


def test_what_is_beyond_its_range_is_infinite() -> None:
    base = SimulatedBase(obstacles=[], room_m=4 * RANGE_MAX_M)
    assert all(map(math.isinf, base.scan()))


def test_it_moves_as_commanded_and_stops_by_itself() -> None:
    base = SimulatedBase(obstacles=[])
    base.command(0.4, 0.0)
    base.advance(0.4)
    assert 0.08 < base.x_m < 0.16
    base.advance(2.0)  # nobody sends on: the command expires
    assert base.x_m < 0.25
    assert base.odom_speed == (0.0, 0.0)
    assert base.x_m == pytest.approx(base.odom[0], rel=0.02)


def test_it_stands_against_what_it_hits() -> None:
    base = SimulatedBase(obstacles=[Box(0.6, 0.0, 0.2, 2.0)])
    for _ in range(40):
        base.command(0.5, 0.0)
        base.advance(0.1)
    assert base.bumped
    assert base.x_m == pytest.approx(0.5 - 0.17, abs=0.01)
