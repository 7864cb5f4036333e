"""The Go2 on real DDS: the contract, and what only a real network shows, against the simulated world's process."""

from __future__ import annotations

import asyncio
import json
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotBusy
from agentrob.model import Direction, Op, Outcome, Primitive
from agentrob.robots.contract import RobotContract, fresh, go_on
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.protocol import Robot
from agentrob.robots.unitree.go2 import Go2
from tests.host_numbers import dds_number
from tests.waiting import until, wait_for

DOMAIN = 171 + dds_number()
SETTINGS = RobotConfig(model="go2", domain=DOMAIN, simulated=True, home_on_start=True)

pytestmark = pytest.mark.sim


def start(*command: str, camera: str = "") -> subprocess.Popen[str]:
    """Start a process that prints one line of JSON when it is ready. Without `camera` it loads no GL."""
    env = {**os.environ, **({"MUJOCO_GL": camera} if camera else {})}
    process = subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, text=True, env=env)
    assert process.stdout is not None
    assert json.loads(process.stdout.readline())["ready"]
    return process


def start_world(domain: int, *options: str, camera: str = "") -> subprocess.Popen[str]:
    return start("-m", "agentrob.sim.server", "--domain", str(domain), *options, camera=camera)


@pytest.fixture(scope="module")
def world() -> Iterator[subprocess.Popen[str]]:
    """Start the simulated world in its own process."""
    process = start_world(DOMAIN, "--pace", "4")  # its duration does not matter here
    yield process
    process.send_signal(signal.SIGTERM)
    process.wait(60)


@pytest.fixture(scope="module")
def go2(world: subprocess.Popen[str]) -> Iterator[Go2]:
    """One per module: the SDK joins one DDS domain per process."""
    robot = Go2(SETTINGS)
    yield robot
    robot.close()


class TestGo2OnTheSimulatedWorld(RobotContract):
    @pytest.fixture
    def robot(self, go2: Go2) -> Robot:
        return go2


def test_one_process_speaks_for_one_robot(go2: Go2) -> None:
    with pytest.raises(RobotBusy, match=str(DOMAIN)):
        Go2(RobotConfig(model="go2", domain=DOMAIN + 30))


def test_its_battery_and_ranges_come_over_the_wire(go2: Go2) -> None:
    state = fresh(go2)
    assert all(r is not None and r > 0 for r in state.ranges_m)
    assert state.battery_percent is not None
    assert 0 < state.battery_percent <= 100
    assert state.mode in ("idle", "walking")


def test_what_the_robot_does_not_offer_is_a_failure_with_its_code(go2: Go2) -> None:
    fresh(go2)
    go2._gestures[Op.CLAP] = (go2._actions.LeftFlip,)  # which the simulated one does not support
    try:
        result = go2.step(Primitive(Op.CLAP), go_on)
    finally:
        del go2._gestures[Op.CLAP]
    assert (result.outcome, result.reason) == (Outcome.FAILED, "unsupported")
    assert "3203" in result.message


def mode(robot: Go2, wanted: str, limit_s: float = 60.0) -> None:
    """Wait until the robot is in a mode."""
    wait_for(lambda: robot.state().mode == wanted, limit_s=limit_s)


def test_law_12_and_14_the_robot_is_not_stood_ready_out_of_damping_or_after_a_stop(go2: Go2) -> None:
    near = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.3)
    assert go2._actions.StandUp() == 0  # like an operator's remote control
    mode(go2, "locked")
    stopped = go2.step(near, lambda _: "lease_lapsed")
    assert (stopped.outcome, stopped.reason) == (Outcome.STOPPED, "lease_lapsed")
    assert "before it began" in stopped.message
    ended_s = time.monotonic()
    wait_for(lambda: (go2._state.newest() or (0.0,))[0] >= ended_s + 0.1)  # its reply after everything was sent
    assert go2.state().mode == "locked"
    assert go2._actions.Damp() == 0
    mode(go2, "damping")
    refused = go2.step(near, go_on)
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "posture")
    mode(go2, "damping", 0.5)
    assert go2.step(Primitive(Op.STAND), go_on).ok  # the guard would not let this through
    mode(go2, "idle")


DRIVER = """
import sys
from pathlib import Path
from agentrob.config.robots import RobotConfig
from agentrob.robots.driver.process import run_driver
folder, domain = Path(sys.argv[1]), int(sys.argv[2])
settings = RobotConfig(model="go2", domain=domain, simulated=True, home_on_start=True)
run_driver("quadruped", settings, folder / "quadruped.sock", folder)
"""


async def test_law_8_a_world_that_dies_under_a_walk_ends_it_and_the_next_one_is_walked_again(tmp_path: Path) -> None:
    domain = DOMAIN + 10
    far, near = (Primitive(Op.MOVE, Direction.FORWARD, distance_m=d) for d in (3.0, 0.3))
    processes = [await asyncio.to_thread(start_world, domain, camera="off")]
    try:
        processes.append(await asyncio.to_thread(start, "-c", DRIVER, str(tmp_path), str(domain)))
        async with DriverClient("quadruped", tmp_path / "quadruped.sock") as robot:
            async with robot.lease("walker") as lease:
                step = asyncio.create_task(robot.step(lease, far, 30))
                await until(robot.state, lambda state: math.hypot(*(state.velocity_mps or (0, 0))) > 0.25)
                processes[0].kill()
                killed_s = time.monotonic()
                result = await step
                assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
                stopped = await robot.stop("walker")
                assert not stopped.confirmed
                assert "old" in stopped.message
                assert time.monotonic() - killed_s < 10
            processes.append(await asyncio.to_thread(start_world, domain, camera="off"))
            await until(robot.state, lambda state: state.age_s < 0.2 and state.homed)
            async with robot.lease("walker") as lease:
                result = await robot.step(lease, near, 30)
                assert result.ok, result.message
    finally:
        for process in processes:
            process.kill()
            process.wait()


async def test_a_driver_without_a_robot_serves_and_moves_nothing(tmp_path: Path) -> None:
    driver = await asyncio.to_thread(start, "-c", DRIVER, str(tmp_path), str(DOMAIN + 40))
    try:
        async with DriverClient("quadruped", tmp_path / "quadruped.sock") as robot:
            assert math.isinf((await robot.state()).age_s)
            async with robot.lease("walker") as lease:
                step = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.3)
                result = await robot.step(lease, step, 10)
                assert (result.outcome, result.reason) == (Outcome.REFUSED, "stale_state")
                picture = await robot.step(lease, Primitive(Op.GET_FRONT_IMAGE), 10)
                assert (picture.outcome, picture.reason) == (Outcome.FAILED, "no_answer")
            stopped = await robot.stop("walker")
            assert not stopped.confirmed
            assert "no state ever came" in stopped.message
            driver.send_signal(signal.SIGTERM)
            assert await asyncio.to_thread(driver.wait, 5) == 0
    finally:
        driver.kill()
        driver.wait()
