"""Fixtures of the worker's tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.agent.agent_scene import Driver, robot_settings


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    """Start one driver for all tests of a module."""
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings())
    yield made
    made.end()
