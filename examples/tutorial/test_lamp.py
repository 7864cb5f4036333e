"""The lamp keeps the contract of every robot."""

from collections.abc import Iterator

import pytest
from agentrob_lamp import Lamp

from agentrob import Robot, RobotConfig, RobotContract


class TestLamp(RobotContract):
    @pytest.fixture
    def robot(self) -> Iterator[Robot]:
        lamp = Lamp(RobotConfig(model="lamp", simulated=True))
        yield lamp
        lamp.close()
