"""Fixtures: a simulated base on a DDS domain of its own, and the robot that drives it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from agentrob_ros2.base import Ros2Sim
from agentrob_ros2.simulator import Simulator

from agentrob.config.robots import RobotConfig
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from agentrob.sim.domains import PrivateDomain


@pytest.fixture
def domain() -> Iterator[int]:
    private = PrivateDomain()
    yield private.number
    private.close()


@pytest.fixture
def simulator(domain: int) -> Iterator[Simulator]:
    running = Simulator(domain)
    yield running
    running.close()


@pytest.fixture
def robot(simulator: Simulator, domain: int) -> Iterator[Ros2Sim]:
    base = Ros2Sim(RobotConfig(model="ros2-sim", domain=domain, simulated=True, home_on_start=True))
    yield base
    base.close()


@pytest.fixture
def guard(robot: Ros2Sim, domain: int, tmp_path: Path) -> Iterator[Guard]:
    """The guard around the robot, as its driver has it."""
    settings = RobotConfig(model="ros2-sim", domain=domain, simulated=True, home_on_start=True)
    guarded = Guard(robot, settings, Halt(tmp_path / "halt"))
    yield guarded
    guarded.close()
