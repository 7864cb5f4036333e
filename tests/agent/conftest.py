"""Fixtures of the agent's tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from agent_process import end_agents
from agent_scene import Driver, Scene, make_scene, robot_settings


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    """One driver for all tests of a file."""
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings())
    yield made
    made.end()


@pytest.fixture
def scene(driver: Driver, tmp_path: Path) -> Scene:
    return make_scene(driver, tmp_path)


@pytest.fixture(autouse=True)
def no_agent_is_left() -> Iterator[None]:
    """Not even by a test that failed."""
    yield
    end_agents()
