"""What the tests of robots share."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from driver_scene import Drivers
from guard_scene import Make

from agentrob.config import RobotConfig
from agentrob.robots.fake import FakeRobot
from agentrob.robots.guard import Guard
from agentrob.robots.halt import Halt

pytest.register_assert_rewrite("agentrob.robots.contract")


@pytest.fixture
def drivers(tmp_path: Path) -> Iterator[Drivers]:
    """Starts drivers of fake robots and ends them all."""
    started = Drivers(tmp_path)
    yield started
    started.close()


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    """Makes guarded fake robots that take no time; keywords are settings and, as `options`, the fake's."""
    made: list[Guard] = []

    def make(options: dict[str, Any] | None = None, **changed: Any) -> Guard:
        given: dict[str, Any] = {"model": "fake", "simulated": True, "home_on_start": True, **changed}
        config = RobotConfig(options={"time_scale": math.inf, **(options or {})}, **given)
        guard = Guard(FakeRobot(config), config, Halt(tmp_path / "fake.halt"))
        made.append(guard)
        return guard

    yield make
    for guard in made:
        guard.close()
