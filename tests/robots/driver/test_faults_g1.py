"""The same faults with the other body: a simulated G1, with its driver in a separate process."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import httpx2
import pytest

from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Op, Outcome, Primitive
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.unitree.g1_fsm import OLD_S
from tests.robots.sim_steps import METRE, NEAR, do
from tests.waiting import until

pytestmark = [pytest.mark.sim, pytest.mark.slow]

DOMAINS = range(221, 230)
#: Full physics of 29 joints is slow on a busy machine.
CLAP, PHOTO = Primitive(Op.CLAP), Primitive(Op.GET_FRONT_IMAGE)


class Stand(NamedTuple):
    room: httpx2.Client
    socket: Path

    def faults(self, **faults: Any) -> None:
        self.room.post("/faults", json=faults).raise_for_status()


def start(*words: str, **env: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "agentrob", *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=os.environ | env)


@pytest.fixture(scope="module")
def stand(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stand]:
    """A world with a G1, and a driver whose owner allows it to walk without range sensors."""
    folder = tmp_path_factory.mktemp("g1")
    for domain in DOMAINS:
        world = start("sim", "--domain", f"g1={domain}", MUJOCO_GL="off")
        assert world.stdout is not None
        if line := world.stdout.readline():
            break
    settings = RobotConfig(model="g1", domain=domain, simulated=True, home_on_start=True, allow_unknown_ranges=True)
    Config(data=str(folder), robots={"humanoid": settings}).write(folder / "agentrob.toml")
    driver = start("driver", "humanoid", "--config", str(folder / "agentrob.toml"), AGENTROB_RUNTIME=str(folder))
    assert driver.stdout is not None
    ready = json.loads(driver.stdout.readline())
    with httpx2.Client(base_url=json.loads(line)["http"], timeout=100) as room:
        yield Stand(room, Path(ready["socket"]))
    for process in (driver, world):
        process.terminate()
        process.communicate(timeout=100)


@pytest.fixture
async def robot(stand: Stand) -> AsyncIterator[DriverClient]:
    """Well, at its start, at home and released: in this order, as an owner does it.

    A fallen G1 that is set up stands damped until its motion service, asked five times a second, tells another state;
    and a damped robot is halted (law 12). What it told before the reset is forgotten after `OLD_S`.
    """
    stand.room.post("/reset").raise_for_status()
    set_up_s = time.monotonic() + OLD_S
    async with DriverClient("humanoid", stand.socket) as client:
        await until(
            client.state, lambda s: time.monotonic() > set_up_s and s.age_s < 0.2 and s.homed and s.mode == "idle"
        )
        await client.release("owner")
        assert not (await client.state()).halted
        yield client


async def walking(stand: Stand, robot: DriverClient, **faults: Any) -> ActionResult:
    """Walk one metre, let this happen on the way, and return the result."""
    async with robot.lease("tester") as lease:
        step = asyncio.create_task(robot.step(lease, METRE, 30))
        await until(robot.state, lambda s: s.pose is not None and s.pose.x_m > 0.3)
        stand.faults(**faults)
        return await step


async def test_law_8_a_g1_that_falls_stays_down(stand: Stand, robot: DriverClient) -> None:
    result = await walking(stand, robot, tip=True)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "fallen"), result.message
    await until(robot.state, lambda s: s.upright is False)
    for primitive in (NEAR, CLAP):
        refused = await do(robot, primitive)
        assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "fallen"), refused.message


async def test_a_g1_that_freezes_is_reported_with_how_far_it_came(stand: Stand, robot: DriverClient) -> None:
    result = await walking(stand, robot, drops=1.0)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "stalled"), result.message
    assert 0.25 < result.measured["distance_m"] < 0.8


async def test_a_g1_whose_cable_is_pulled_is_not_known_to_rest(stand: Stand, robot: DriverClient) -> None:
    result = await walking(stand, robot, unplugged=True)
    assert (result.outcome, result.reason, result.measured) == (Outcome.STOPPED, "stale_state", {}), result.message
    assert not (await robot.stop("tester")).confirmed
    assert (await do(robot, NEAR)).reason == "stale_state"


async def test_law_9_a_g1_without_odometry_is_stopped(stand: Stand, robot: DriverClient) -> None:
    result = await walking(stand, robot, lost=True)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state"), result.message
    assert "tells no position" in result.message


async def test_a_black_picture_of_a_g1_is_a_failure(stand: Stand, robot: DriverClient) -> None:
    stand.faults(camera="black")
    result = await do(robot, PHOTO)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "bad_image"), result.message
    stand.faults()
    assert (await do(robot, PHOTO)).ok
