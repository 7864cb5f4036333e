"""Fixtures of the agent's tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.agent.media import pictures
from agentrob.robots.driver.lease import TTL_S
from tests.agent.agent_process import end_agents
from tests.agent.agent_scene import PATIENT_LEASE_S, Driver, Scene, make_scene, robot_settings

#: The smallest PNG.
BLANK = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108000000003a7e9b550000000a49444154789c63f80f0001010100b138f614"
    "0000000049454e44ae426082"
)


@pytest.fixture(scope="module")
def driver(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    """Start one driver for all tests of a module; its leases are as short as a real one's in modules with
    `AGENTS_DIE`."""
    lease_s = TTL_S if getattr(request.module, "AGENTS_DIE", False) else PATIENT_LEASE_S
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings(), lease_s=lease_s)
    yield made
    made.end()


@pytest.fixture
def scene(driver: Driver, tmp_path: Path) -> Scene:
    return make_scene(driver, tmp_path)


@pytest.fixture(autouse=True)
def no_agent_is_left() -> Iterator[None]:
    """End agents that a failed test left running."""
    yield
    end_agents()


@pytest.fixture(autouse=True)
def paths_are_not_drawn(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace path plots with a fixed picture, except in modules with `DRAWS`: drawing takes half of a command's
    time."""
    if not getattr(request.module, "DRAWS", False):
        monkeypatch.setattr(pictures, "path_plot", lambda _: BLANK)
