"""Fixtures: a simulated daemon on a free port of loopback, and the robot that it is."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from agentrob_reachy_mini.robot import ReachyMiniSim
from agentrob_reachy_mini.simulated_daemon import SimulatedDaemon

from agentrob.config.robots import RobotConfig
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt


@pytest.fixture
def listening() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server


@pytest.fixture
def url(listening: socket.socket) -> str:
    return f"http://127.0.0.1:{listening.getsockname()[1]}"


@pytest.fixture
def daemon(listening: socket.socket) -> Iterator[SimulatedDaemon]:
    running = SimulatedDaemon(listening)
    yield running
    running.close()


@pytest.fixture
def settings(url: str) -> RobotConfig:
    return RobotConfig(model="reachy-mini-sim", simulated=True, home_on_start=True, options={"url": url})


@pytest.fixture
def robot(daemon: SimulatedDaemon, settings: RobotConfig) -> Iterator[ReachyMiniSim]:
    reachy = ReachyMiniSim(settings)
    yield reachy
    reachy.close()


@pytest.fixture
def guard(robot: ReachyMiniSim, settings: RobotConfig, tmp_path: Path) -> Iterator[Guard]:
    """The guard around the robot, as its driver has it."""
    guarded = Guard(robot, settings, Halt(tmp_path / "halt"))
    yield guarded
    guarded.close()
