"""Law 11 in a shared room, with real driver processes: no client moves a robot where another one moves, a killed
driver's zone stays taken until its robot is known to be at rest, and a stop never asks for a zone."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.model import ActionResult, Direction, Hindrance, Op, Outcome, Primitive
from agentrob.robots.driver.client import DriverClient
from tests.robots.driver.network_scene import TOKEN, TOKEN_ENV, NetworkDrivers
from tests.robots.driver_scene import FAR, NEAR, Drivers, at_rest, moving
from tests.waiting import until

TURN = Primitive(Op.TURN, Direction.LEFT, degrees=90)


def in_lab(at_m: tuple[float, float], error_m: float | None = 0.1, **more: Any) -> dict[str, Any]:
    """Settings of a robot in the room "lab" whose home is there."""
    shared = {"room": "lab", "room_error_m": error_m, "map": {"room": "lab", "home_at_m": at_m}}
    return {**shared, "options": {"time_scale": 2}, **more}


async def homed(robot: DriverClient) -> None:
    await until(robot.state, lambda state: state.homed)


async def entered(robot: DriverClient, step: Primitive, limit_s: float = 60.0) -> None:
    """Wait for the room, as an agent does."""
    end_s = time.monotonic() + limit_s
    while await robot.enter_room([step]) is not None:
        assert time.monotonic() < end_s, "the room did not become free"
        await asyncio.sleep(0.1)


async def hindered(robot: DriverClient, step: Primitive, reason: str, limit_s: float = 60.0) -> Hindrance:
    """Wait until the room says no for this reason."""
    end_s = time.monotonic() + limit_s
    while (hindrance := await robot.enter_room([step])) is None or hindrance.reason != reason:
        assert time.monotonic() < end_s, f"found {hindrance}"
        await asyncio.sleep(0.1)
    return hindrance


async def drive(robot: DriverClient, step: Primitive) -> ActionResult:
    async with robot.lease("tester") as lease:
        return await robot.step(lease, step, 30)


async def test_law_11_one_robot_of_a_room_moves_and_the_other_is_refused_by_name_for_every_client(
    drivers: Drivers,
) -> None:
    ann, bob = (drivers.start(**in_lab((0, 0), None))[0] for _ in range(2))
    async with drivers.client(ann) as first, drivers.client(bob) as second:
        await homed(first)
        await homed(second)
        walk = asyncio.create_task(drive(first, FAR))
        await moving(first)
        refused = await drive(second, NEAR)  # a client that knows nothing of rooms
        assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "room_busy")
        assert f"{ann} moves" in refused.message
        busy = await hindered(second, NEAR, "room_busy")
        assert (busy.robot, busy.doing) == (ann, "move")
        assert (await drive(second, Primitive(Op.GET_FRONT_IMAGE))).ok, "a photo needs no zone"
        stopped = await second.stop("somebody")  # nor does a stop
        assert stopped.confirmed
        await first.stop("somebody")
        assert (await walk).reason == "stop"
        await entered(second, NEAR)
        assert (await drive(second, NEAR)).ok


async def test_paths_that_stay_apart_run_together_and_crossing_ones_do_not(drivers: Drivers) -> None:
    ann, bob = (drivers.start(**in_lab((0, y_m)))[0] for y_m in (0.0, 2.0))
    async with drivers.client(ann) as first, drivers.client(bob) as second:
        await homed(first)
        await homed(second)
        walk = asyncio.create_task(drive(first, FAR))
        await moving(first)
        assert (await drive(second, NEAR)).ok
        across = await second.enter_room([Primitive(Op.MOVE, Direction.RIGHT, distance_m=4.0)])
        assert across is not None
        assert (across.reason, across.robot) == ("room_busy", ann)
        assert (await walk).ok
        into = Primitive(Op.MOVE, Direction.RIGHT, distance_m=1.0)
        await entered(second, into)  # where the other one came from


async def test_a_robot_in_the_way_is_named(drivers: Drivers) -> None:
    ann, bob = (drivers.start(**in_lab((x_m, 0)))[0] for x_m in (0.0, 2.0))
    async with drivers.client(ann) as first, drivers.client(bob) as second:
        await homed(first)
        await homed(second)
        assert (await drive(second, TURN)).ok  # and so it is known where it stands
        blocked = await hindered(first, FAR, "room_blocked")
        assert blocked.robot == bob
        refused = await drive(first, FAR)
        assert (refused.reason, refused.message) == ("room_blocked", f"{bob} stands in the way.")


async def test_the_zone_of_a_killed_driver_stays_taken_until_its_next_driver_says_that_the_robot_rests(
    drivers: Drivers,
) -> None:
    settings = in_lab((0, 0), None)
    ann, process = drivers.start(**settings)
    bob, _ = drivers.start(**settings)
    async with drivers.client(ann) as first, drivers.client(bob) as second:
        await homed(first)
        await homed(second)
        walk = asyncio.create_task(drive(first, FAR))
        await moving(first)
        process.kill()
        process.communicate()
        with pytest.raises(Exception, match="no driver"):
            await walk
        busy = await hindered(second, NEAR, "room_busy")
        assert busy.robot == ann
        drivers.start(ann, **settings)
        await entered(second, NEAR)
        assert (await drive(second, NEAR)).ok


@pytest.fixture
async def network(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[NetworkDrivers]:
    monkeypatch.setenv(TOKEN_ENV, TOKEN)
    started = NetworkDrivers(tmp_path)
    yield started
    started.close()


@pytest.fixture
def far_host(tmp_path: Path) -> Iterator[Drivers]:
    """Drivers of another host: with a data folder of their own."""
    (tmp_path / "far").mkdir()
    started = Drivers(tmp_path / "far")
    yield started
    started.close()


@pytest.mark.parametrize("way", ["certificate", "plain"])
async def test_drivers_of_two_hosts_share_a_room_that_one_of_them_keeps(
    network: NetworkDrivers, far_host: Drivers, way: str
) -> None:
    ann = network.serve(by=way, **in_lab((0, 0), None))
    scheme = "http" if way == "plain" else "https"
    mine = {"driver_token_env": TOKEN_ENV} if way == "plain" else network.authority.issue("far")
    url = f"{scheme}://127.0.0.1:{network.listens[ann].rpartition(':')[2]}"
    bob, _ = far_host.start(**in_lab((0, 0), None, room_url=url, **mine))
    async with network.client(ann) as first, far_host.client(bob) as second:
        await homed(first)
        await homed(second)
        assert (await drive(second, NEAR)).ok
        walk = asyncio.create_task(drive(second, FAR))
        await moving(second)
        busy = await hindered(first, NEAR, "room_busy")
        assert (busy.robot, busy.doing) == (bob, "move")
        network.processes[0].kill()  # whoever keeps the room dies
        network.processes[0].communicate()
        result = await walk
        assert result.reason == "room_lost"
        assert at_rest(await second.state())
        refused = await drive(second, NEAR)
        assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "room_unreachable")
        assert url in refused.message
        assert (await second.stop("somebody")).confirmed
        network.serve(ann, by=way, **in_lab((0, 0), None))
        await entered(second, NEAR)
        assert (await drive(second, NEAR)).ok
