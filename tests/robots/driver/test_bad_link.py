"""Laws 11, 13 and 16 over a link with 100 ms delay each way and 2 % loss, and over one that is cut."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.errors import RobotError
from agentrob.model import Direction, Op, Primitive
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.connection import LEASE_CONNECTIONS, STOP_CONNECTIONS, DriverConnection
from agentrob.robots.driver.lease import TTL_S
from tests.robots.driver.network_scene import TOKEN_ENV, NetworkDrivers
from tests.robots.driver.slow_link import SlowLink
from tests.robots.driver_scene import FAR, NEAR, at_rest, seconds_until
from tests.sizes import size
from tests.waiting import until

DELAY_S, LOSS = 0.1, 0.02
#: What a busy machine may add.
SLACK_S = 0.3
LONG = Primitive(Op.MOVE, Direction.FORWARD, distance_m=4.5, speed_mps=0.2)


@pytest.fixture
def network(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[NetworkDrivers]:
    monkeypatch.setenv(TOKEN_ENV, "")
    started = NetworkDrivers(tmp_path)
    yield started
    started.close()


@contextlib.asynccontextmanager
async def linked(
    network: NetworkDrivers, loss: float = LOSS, seed: int = 0
) -> AsyncIterator[tuple[DriverClient, DriverClient, SlowLink]]:
    """A client over a bad link with open connections, one on the robot's machine, and the link."""
    fence = {"x_min_m": -99.0, "x_max_m": 99.0, "y_min_m": -99.0, "y_max_m": 99.0}
    name = network.serve(fence=fence, options={"faults": {"stop_s": 0.03}, "room": [-99, 99, -99, 99]})
    link = SlowLink(network.listens[name], DELAY_S, loss, seed)
    async with link.open(), network.remote(name, port=link.port) as far, network.client(name) as near:
        await until(near.state, lambda state: state.homed)
        await far.state()
        await until(near.state, lambda _: link.connections > STOP_CONNECTIONS + LEASE_CONNECTIONS)
        for _ in range(3):
            await far.state()  # meanwhile their TLS handshakes end
        yield far, near, link


async def walking(near: DriverClient) -> None:
    await until(near.state, lambda state: abs((state.velocity_mps or (0, 0))[0]) > 0.1)


async def test_law_13_a_stop_needs_one_way_and_no_handshake(network: NetworkDrivers) -> None:
    async with linked(network, loss=0.0) as (far, near, _), far.lease("agent") as lease:
        step = asyncio.create_task(far.step(lease, LONG, 60))
        await walking(near)
        asked_s = time.monotonic()
        stopping = asyncio.create_task(far.stop("a person"))
        await until(near.state, at_rest)
        assert time.monotonic() - asked_s < DELAY_S + SLACK_S
        stopped = await stopping
        assert time.monotonic() - asked_s < 2 * DELAY_S + 2 * SLACK_S
        assert stopped.confirmed
        assert DELAY_S * 1000 <= stopped.latency_ms < (2 * DELAY_S + SLACK_S) * 1000, "with its way, at most"
        assert (await step).reason == "stop"


@pytest.mark.parametrize("seed", range(size(2, 10)))
async def test_law_13_a_stop_does_not_wait_for_a_packet_that_was_lost(network: NetworkDrivers, seed: int) -> None:
    async with linked(network, loss=0.1, seed=seed) as (far, _, link):
        ways_s = []
        for _ in range(9):
            asked_s = time.monotonic()
            await far.stop("a person")
            _, arrived_s = far._own_stop  # by the driver's clock, which here is ours
            ways_s.append(arrived_s - asked_s)
        assert link.lost > 0
        assert sorted(ways_s)[4] < DELAY_S + 0.1
        assert max(ways_s) < 1.5


@pytest.mark.slow
async def test_law_11_a_walk_over_a_bad_link_ends_as_asked_and_the_lease_never_lapses(network: NetworkDrivers) -> None:
    async with linked(network) as (far, _, link), far.lease("agent") as lease:
        for step in (LONG, NEAR, NEAR, LONG):
            result = await far.step(lease, step, 60)
            assert result.ok, (result.reason, result.message)
            assert await far.lost(lease) is None
        assert link.lost > 5


async def test_law_11_a_link_that_is_cut_stops_the_robot_within_the_leases_time(network: NetworkDrivers) -> None:
    async with linked(network) as (far, near, link), contextlib.AsyncExitStack() as stack:
        lease = await stack.enter_async_context(far.lease("agent"))
        step = asyncio.create_task(far.step(lease, FAR, 60))
        await walking(near)
        link.cut()
        cut_s = time.monotonic()
        await until(near.state, at_rest)
        assert 0.2 < time.monotonic() - cut_s < TTL_S + SLACK_S
        assert await near.holder() is None
        step.cancel()


async def test_law_11_a_renewal_says_when_it_was_sent_by_the_drivers_clock(
    network: NetworkDrivers, monkeypatch: pytest.MonkeyPatch
) -> None:
    renewals: list[tuple[float, float]] = []  # when it was sent, by our clock, which here is the driver's; what it says
    ask = DriverConnection.ask

    async def recorded(self: DriverConnection, method: str, path: str, body: Any = None, *rest: Any) -> Any:
        if method == "PUT":
            renewals.append((time.monotonic(), body["sent_s"]))
        return await ask(self, method, path, body, *rest)

    monkeypatch.setattr(DriverConnection, "ask", recorded)
    async with linked(network) as (far, _, _), far.lease("agent") as lease:
        assert await far.lost(lease) is None
        await until(lambda: len(renewals) >= 10)  # each is sent by the client's own clock
    for sent_s, said_s in renewals:
        assert 0 <= sent_s - said_s < 2 * DELAY_S + SLACK_S, "never later than it was"


async def test_law_13_a_stop_that_cannot_arrive_stops_the_robot_by_the_lease(network: NetworkDrivers) -> None:
    async with linked(network) as (far, near, link), contextlib.AsyncExitStack() as stack:
        lease = await stack.enter_async_context(far.lease("agent"))
        step = asyncio.create_task(far.step(lease, FAR, 60))
        await walking(near)
        link.cut()
        asked_s = time.monotonic()
        with pytest.raises(RobotError):
            await asyncio.gather(far.stop("a person"), until(near.state, at_rest))
        rest_s = await seconds_until(near, at_rest)
        assert rest_s < 0.5
        assert time.monotonic() - asked_s < 5.0 + TTL_S + SLACK_S, "and the client says that it could not stop it"
        step.cancel()
