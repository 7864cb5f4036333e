"""Two robots, each with a driver of its own, for all tests of a module."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.agent.agent_scene import Driver, robot_settings
from tests.agent.joint.joint_scene import JointScene, make_joint_scene


@pytest.fixture(scope="module")
def drivers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Driver]]:
    folder, domain = tmp_path_factory.mktemp("drivers"), int(os.environ["AGENTROB_TEST_DOMAIN"])
    made = {
        name: Driver(folder, robot_settings(domain=domain ^ number, options={"time_scale": 2}), name)
        for number, name in enumerate(("quadruped", "humanoid"))
    }
    yield made
    for driver in made.values():
        driver.end()


@pytest.fixture
def scene(drivers: dict[str, Driver], tmp_path: Path) -> JointScene:
    return make_joint_scene(drivers, tmp_path)
