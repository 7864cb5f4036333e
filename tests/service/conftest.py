"""Fixtures of the service's tests: the agent's scenes, with HTTP in front."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest

from tests.agent.agent_scene import Driver, robot_settings
from tests.service.service_scene import Service, make_service


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Iterator[Driver]:
    """In real time, so that there is something to stop, where the file of tests does not say how much faster."""
    scale = getattr(request.module, "TIME_SCALE", 1)
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings(options={"time_scale": scale}), name="served")
    yield made
    made.end()


@pytest.fixture
async def service(driver: Driver, tmp_path: Path) -> AsyncIterator[Service]:
    """A served agent that listens to its forum."""
    async with make_service(driver, tmp_path) as made:
        yield made
