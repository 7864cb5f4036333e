"""Fixtures for the service's tests: a driver and an agent served over HTTP."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest

from tests.agent.agent_scene import Driver, robot_settings
from tests.service.service_scene import Service, make_service


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Iterator[Driver]:
    """Start a driver, in real time unless the test module sets `TIME_SCALE`, so that motions last long enough to
    stop."""
    scale = getattr(request.module, "TIME_SCALE", 1)
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings(options={"time_scale": scale}), name="served")
    yield made
    made.end()


@pytest.fixture
async def service(driver: Driver, tmp_path: Path) -> AsyncIterator[Service]:
    """Serve an agent that listens to its forum."""
    async with make_service(driver, tmp_path) as made:
        yield made
