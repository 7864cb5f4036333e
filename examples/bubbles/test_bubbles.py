"""The robot that blows bubbles keeps the contract that every robot keeps, also for the operation that it declares."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from agentrob_bubbles import BubbleRobot

from agentrob import Robot, RobotConfig, RobotContract


class TestBubbleRobot(RobotContract):
    @pytest.fixture
    def robot(self) -> Iterator[Robot]:
        robot = BubbleRobot(RobotConfig(model="bubbles", simulated=True))
        yield robot
        robot.close()
