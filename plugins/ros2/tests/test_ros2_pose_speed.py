"""The speed of a base whose messages tell only where it is, also when they come late."""

from __future__ import annotations

import math

import pytest
from agentrob_ros2.pose_speed import MAX_DELAY_S, PoseSpeed
from hypothesis import given
from hypothesis import strategies as st

from agentrob.model import Pose

SENT_EVERY_S = 0.02
DELAYS = st.lists(st.floats(0.0, MAX_DELAY_S), min_size=12, max_size=60)


def walked(speed_mps: float, seconds: float) -> Pose:
    return Pose(speed_mps * seconds * math.cos(1.0), speed_mps * seconds * math.sin(1.0), 1.0)


@given(DELAYS, st.floats(-1.5, 1.5))
def test_messages_that_come_late_do_not_change_the_speed(delays: list[float], speed_mps: float) -> None:
    speed, came_s = PoseSpeed(), 0.0
    for number, delay_s in enumerate(delays):
        sent_s = number * SENT_EVERY_S
        came_s = max(came_s, sent_s + delay_s)
        velocity = speed.update(came_s, 1000.0 + sent_s, walked(speed_mps, sent_s))
    assert velocity == pytest.approx((speed_mps, 0.0, 0.0), abs=1e-6)


def test_a_base_that_turns_has_a_turning_speed() -> None:
    speed = PoseSpeed()
    speed.update(0.0, 5.0, Pose(0.0, 0.0, math.radians(179)))
    velocity = speed.update(0.0, 5.2, Pose(0.0, 0.0, math.radians(-179)))
    assert velocity == pytest.approx((0.0, 0.0, math.radians(10)))


@pytest.mark.parametrize("stamps_s", [(0.0, 0.0), (5.0, 5.0), (5.0, 4.0), (5.0, 3605.0)])
def test_without_stamps_that_advance_with_the_arrivals_the_arrivals_count(stamps_s: tuple[float, float]) -> None:
    speed = PoseSpeed()
    assert speed.update(1.0, stamps_s[0], walked(0.5, 0.0)) is None
    assert speed.update(1.2, stamps_s[1], walked(0.5, 0.2)) == pytest.approx((0.5, 0.0, 0.0))


def test_a_message_without_a_pose_makes_the_speed_unknown_until_two_more_came() -> None:
    speed = PoseSpeed()
    speed.update(0.0, 1.0, walked(0.5, 0.0))
    assert speed.update(0.2, 1.2, walked(0.5, 0.2)) is not None
    assert speed.update(0.4, 1.4, None) is None
    assert speed.update(0.6, 1.6, walked(0.5, 0.6)) is None
    assert speed.update(0.8, 1.8, walked(0.5, 0.8)) == pytest.approx((0.5, 0.0, 0.0))
