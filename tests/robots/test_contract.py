"""The built-in robots fulfil the contract for third-party robots."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.robots.contract import RobotContract
from agentrob.robots.fake import FakeRobot
from agentrob.robots.protocol import Robot
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt

SETTINGS = RobotConfig(model="fake", simulated=True, home_on_start=True, options={"time_scale": 10})


class TestFakeRobot(RobotContract):
    @pytest.fixture
    def robot(self) -> Robot:
        return FakeRobot(SETTINGS)


class TestGuardedFakeRobot(RobotContract):
    @pytest.fixture
    def robot(self, tmp_path: Path) -> Iterator[Robot]:
        guard = Guard(FakeRobot(SETTINGS), SETTINGS, Halt(tmp_path / "halt"))
        yield guard
        guard.close()
