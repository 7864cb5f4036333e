"""The interface to the Unitree SDK and DDS, and how a stop judges a robot by its states."""

from __future__ import annotations

import itertools
import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest
from cyclonedds.domain import DomainParticipant

import agentrob.process.dds
from agentrob.model import Pose, RobotState
from agentrob.robots.unitree.robot import UnitreeRobot
from tests.host_numbers import dds_number

DOMAIN = 201 + dds_number()


def test_topics_are_created_one_at_a_time_for_two_at_once_may_hang_the_process() -> None:
    from unitree_sdk2py.idl.unitree_api.msg.dds_ import Request_

    participant = DomainParticipant(DOMAIN)
    made = threading.Event()
    thread = threading.Thread(
        target=lambda: (agentrob.process.dds.Topic(participant, "rt/one", Request_), made.set()), daemon=True
    )
    with agentrob.process.dds._one_topic:
        thread.start()
        assert not made.wait(0.3)
    assert made.wait(60)
    thread.join(60)


AT_REST = RobotState(
    age_s=0.01, pose=Pose(0, 0, math.pi), velocity_mps=(0.0, 0.0), yaw_rate_rps=0.0, mode="idle", battery_percent=None,
    ranges_m=(None,) * 4, upright=True, error_code=0,
)  # fmt: skip


class ScriptedRobot(UnitreeRobot):
    """Returns the given states in order, and the last one from then on."""

    def __init__(self, *states: RobotState, recent: Sequence[tuple[float, Pose]] = ()) -> None:
        super().__init__()
        self._recent = lambda: tuple(recent)  # type: ignore[method-assign]
        self._states = itertools.chain(states, itertools.repeat(states[-1]))

    def state(self) -> RobotState:
        return next(self._states)

    def _send_stop(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("before", "after", "was_moving"),
    [
        ({}, Pose(0, 0, math.pi), False),
        ({}, Pose(0.02, 0.01, -math.pi + 0.03), False),  # swaying
        ({"velocity_mps": (0.3, 0.0)}, Pose(0, 0, math.pi), True),
        ({"yaw_rate_rps": -0.5}, Pose(0, 0, math.pi), True),
        ({}, Pose(0.08, 0, math.pi), True),  # between two strides, and it moved
        ({}, Pose(0, 0, -math.pi + 0.15), True),
    ],
)
def test_a_stop_says_whether_the_robot_was_moving(before: dict[str, object], after: Pose, was_moving: bool) -> None:
    stopped = ScriptedRobot(replace(AT_REST, **before), replace(AT_REST, pose=after)).stop()  # type: ignore[arg-type]
    assert stopped.confirmed, stopped.message
    assert stopped.was_moving is was_moving


def recent_poses(path: Callable[[float], Pose]) -> list[tuple[float, Pose]]:
    """Return the poses of the last half second; `path` maps seconds to poses."""
    return [(100.0 + k / 50, path(k / 50)) for k in range(26)]


@pytest.mark.parametrize(
    ("before", "path", "was_moving"),
    [
        # a standing body that sways shows walking speed for a moment, and returns
        ({"velocity_mps": (0.28, 0.0)}, lambda t: Pose(0.008 * math.sin(30 * t), 0, math.pi), False),
        ({"yaw_rate_rps": 0.5}, lambda t: Pose(0, 0, math.pi - 0.01 * math.sin(30 * t)), False),
        # one that turns or walks shows none for a moment, between two strides
        ({"yaw_rate_rps": 0.04}, lambda t: Pose(0, 0, math.pi - 0.5 * (0.5 - t)), True),
        ({"velocity_mps": (0.02, 0.0)}, lambda t: Pose(-0.15 * (0.5 - t), 0, math.pi), True),
        # and one whose odometry jumped did not move
        ({}, lambda t: Pose(0 if t > 0.2 else 1.5, 0, math.pi), False),
    ],
)
def test_a_sway_is_no_motion_and_a_moment_of_standing_within_a_stride_is_no_rest(
    before: dict[str, object], path: Callable[[float], Pose], was_moving: bool
) -> None:
    at = replace(AT_REST, **before)  # type: ignore[arg-type]
    stopped = ScriptedRobot(at, AT_REST, recent=recent_poses(path)).stop()
    assert stopped.confirmed, stopped.message
    assert stopped.was_moving is was_moving


def test_a_second_stop_does_not_count_the_motion_that_the_first_one_ended() -> None:
    robot, asked_s = ScriptedRobot(AT_REST), time.monotonic()
    assert robot.stop().confirmed
    rested_s = time.monotonic()

    def turned_before_the_first_stop(at_s: float) -> Pose:
        return Pose(0, 0, math.pi - 2 * max(0.0, asked_s - at_s))

    times_s = [rested_s - 0.9 + k / 50 for k in range(46)]
    robot._recent = lambda: tuple((at_s, turned_before_the_first_stop(at_s)) for at_s in times_s)  # type: ignore[method-assign]
    second = robot.stop()
    assert (second.confirmed, second.was_moving) == (True, False)


def test_law_18_a_stop_tells_no_way_across_a_jump_of_the_odometry() -> None:
    stopped = ScriptedRobot(AT_REST, AT_REST, replace(AT_REST, pose=Pose(1.0, 0, math.pi))).stop()
    assert stopped.confirmed, stopped.message
    assert (stopped.was_moving, stopped.coasted_m) == (False, None)


def test_law_18_a_stop_that_is_not_confirmed_tells_no_way() -> None:
    gone = replace(AT_REST, pose=Pose(math.nan, 0, 0))
    stopped = ScriptedRobot(
        AT_REST, *[replace(AT_REST, pose=Pose(0.01 * k, 0, math.pi)) for k in range(5)], gone
    ).stop()
    assert (stopped.confirmed, stopped.coasted_m) == (False, None)
