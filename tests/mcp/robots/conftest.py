"""Fixtures for the tests of the robots' MCP server: a driver and a served agent."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest

from tests.agent.agent_scene import Driver, robot_settings
from tests.service.service_scene import Service, make_service


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings(options={"time_scale": 3}), name="shown")
    yield made
    made.end()


@pytest.fixture
async def service(driver: Driver, tmp_path: Path) -> AsyncIterator[Service]:
    """Serve an agent that listens to its forum."""
    async with make_service(driver, tmp_path) as made:
        yield made
