"""The door to the Unitree SDK and to DDS, and what a stop says of a robot by its states."""

from __future__ import annotations

import itertools
import math
import os
import threading
from dataclasses import replace

import pytest
from cyclonedds.domain import DomainParticipant
from cyclonedds.topic import Topic

import agentrob.dds
from agentrob.model import Pose, RobotState
from agentrob.robots.unitree_robot import UnitreeRobot

DOMAIN = 201 + int(os.environ["AGENTROB_TEST_NUMBER"])


def test_topics_are_created_one_at_a_time_for_two_at_once_may_hang_the_process() -> None:
    from unitree_sdk2py.idl.unitree_api.msg.dds_ import Request_

    participant = DomainParticipant(DOMAIN)
    made = threading.Event()
    thread = threading.Thread(target=lambda: (Topic(participant, "rt/one", Request_), made.set()), daemon=True)
    with agentrob.dds._one_topic:
        thread.start()
        assert not made.wait(0.3)
    assert made.wait(10.0)
    thread.join(10.0)


AT_REST = RobotState(
    age_s=0.01, pose=Pose(0, 0, math.pi), velocity_mps=(0.0, 0.0), yaw_rate_rps=0.0, mode="idle", battery_percent=None,
    ranges_m=(None,) * 4, upright=True, error_code=0,
)  # fmt: skip


class Told(UnitreeRobot):
    """Says the states it is given, and then the last of them for ever."""

    def __init__(self, *states: RobotState) -> None:
        super().__init__()
        self._states = itertools.chain(states, itertools.repeat(states[-1]))

    def state(self) -> RobotState:
        return next(self._states)

    def _send_stop(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("before", "after", "was_moving"),
    [
        ({}, Pose(0, 0, math.pi), False),
        ({}, Pose(0.02, 0.01, -math.pi + 0.03), False),  # a sway
        ({"velocity_mps": (0.3, 0.0)}, Pose(0, 0, math.pi), True),
        ({"yaw_rate_rps": -0.5}, Pose(0, 0, math.pi), True),
        ({}, Pose(0.08, 0, math.pi), True),  # between two strides, and it came on
        ({}, Pose(0, 0, -math.pi + 0.15), True),
    ],
)
def test_a_stop_says_whether_the_robot_was_moving(before: dict[str, object], after: Pose, was_moving: bool) -> None:
    stopped = Told(replace(AT_REST, **before), replace(AT_REST, pose=after)).stop()  # type: ignore[arg-type]
    assert stopped.confirmed, stopped.message
    assert stopped.was_moving is was_moving
