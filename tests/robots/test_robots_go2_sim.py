"""The Go2 on the real DDS wire: the contract, and what only a wire can show, against the simulated world's process."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from agentrob.config import RobotConfig
from agentrob.robots.contract import RobotContract
from agentrob.robots.go2 import Go2
from agentrob.robots.robot import Robot

DOMAIN = 171 + os.getpid() % 10
SETTINGS = RobotConfig(model="go2", domain=DOMAIN, simulated=True, home_on_start=True)

pytestmark = pytest.mark.sim


@pytest.fixture(scope="module")
def world() -> Iterator[subprocess.Popen[str]]:
    """The simulated world as a process of its own; ready when it says so."""
    command = [sys.executable, "-m", "agentrob.sim.serve", "--domain", str(DOMAIN)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert json.loads(process.stdout.readline())["ready"]
    yield process
    process.send_signal(signal.SIGTERM)
    process.wait(10)


@pytest.fixture(scope="module")
def go2(world: subprocess.Popen[str]) -> Iterator[Go2]:
    """One for the module: the SDK joins one DDS domain per process."""
    robot = Go2(SETTINGS)
    yield robot
    robot.close()


class TestGo2OnTheSimulatedWorld(RobotContract):
    @pytest.fixture
    def robot(self, go2: Go2) -> Robot:
        return go2
