"""Fixtures shared by the tests of robots."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.fake import FakeRobot
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from tests.robots.driver_scene import Drivers, Standing, at_rest
from tests.robots.guard_scene import Make
from tests.robots.sim_scene import SimScene
from tests.waiting import until

pytest.register_assert_rewrite("agentrob.robots.contract")

#: So wide that no walk in a module's tests reaches its edge.
WIDE = {"x_min_m": -999.0, "x_max_m": 999.0, "y_min_m": -999.0, "y_max_m": 999.0}


@pytest.fixture
def drivers(tmp_path: Path) -> Iterator[Drivers]:
    """Start drivers of fake robots, and end all of them."""
    started = Drivers(tmp_path)
    yield started
    started.close()


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Standing]:
    """Start one driver for all tests that leave it running."""
    drivers = Drivers(tmp_path_factory.mktemp("d"))
    name, _ = drivers.start(fence=WIDE, options={"room": [-999, 999, -999, 999]})
    yield drivers, name
    drivers.close()


@pytest.fixture
async def standing(shared: Standing) -> AsyncIterator[Standing]:
    """A driver whose robot stands, not halted and without a lease."""
    drivers, name = shared
    yield shared
    async with drivers.client(name) as robot:
        await robot.stop("the end of a test")
        if (await robot.state()).halted:
            await robot.release("owner")
        await until(robot.state, at_rest)


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    """Make guarded fake robots in virtual time; keywords are settings, and `options` are the fake's."""
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


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimScene]:
    """A room with a Go2 in full physics, its driver and the room's ground truth; one per module."""
    made = SimScene(tmp_path_factory.mktemp("place"))
    yield made
    made.close()


@pytest.fixture
async def robot(place: SimScene) -> AsyncIterator[DriverClient]:
    """A driver with the usual settings; the robot is at its start and homed."""
    place.drive()
    async with place.client() as client:
        await place.begin(client)
        yield client
