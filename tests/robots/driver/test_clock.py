"""The clock of a driver on another host: what is converted errs on the side that stops the robot."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.errors import LeaseLost, RobotError
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.clock import DRIFT, DriverClock
from agentrob.robots.driver.connection import DriverConnection
from tests.robots.driver.network_scene import TOKEN_ENV, NetworkDrivers
from tests.robots.driver_scene import NEAR

SECONDS = st.floats(0, 0.5)


@given(
    offset_s=st.floats(-1e6, 1e6),
    drift=st.floats(-DRIFT / 2, DRIFT / 2),
    trips=st.lists(st.tuples(SECONDS, SECONDS, st.floats(0, 60)), min_size=1, max_size=8),
    later_s=st.floats(0, 60),
)
def test_bounds_hold_whatever_the_way_takes_and_however_the_clocks_drift(
    offset_s: float, drift: float, trips: list[tuple[float, float, float]], later_s: float
) -> None:
    def theirs_s(ours_s: float) -> float:
        return offset_s + ours_s * (1 + drift)

    clock, now_s, narrowest_s, measured_s = DriverClock(), 100.0, math.inf, 100.0
    for there_s, back_s, pause_s in trips:
        clock.measured("boot", theirs_s(now_s + there_s), now_s, now_s + there_s + back_s)
        answered_s = now_s + there_s + back_s
        narrowest_s = min(narrowest_s + 2 * DRIFT * (answered_s - measured_s), there_s + back_s)
        measured_s = answered_s
        assert clock.high_s - clock.low_s <= narrowest_s + 1e-6, "a slow trip does not spoil what a fast one showed"
        now_s += there_s + back_s + pause_s
    now_s += later_s
    event_s = now_s - 1.0
    error_s = 1e-6 + 2 * DRIFT  # of converting a time that is not now
    assert clock.earliest_there(event_s, now_s) <= theirs_s(event_s) + error_s
    assert clock.earliest_here(theirs_s(event_s), now_s) <= event_s + error_s
    assert clock.latest_here(theirs_s(event_s), now_s) >= event_s - error_s


def test_another_boot_and_a_clock_that_jumped_replace_what_was_measured() -> None:
    clock = DriverClock()
    clock.measured("first", 1000.0, 0.0, 0.1)
    clock.measured("second", 1000.05, 1.0, 1.1)
    assert (clock.boot, clock.low_s, clock.high_s) == ("second", 1000.05 - 1.1, 1000.05 - 1.0)
    clock.measured("second", 500.0, 2.0, 2.1)
    assert (clock.low_s, clock.high_s) == (500.0 - 2.1, 500.0 - 2.0)


# ------------------------------------------------------------------ with a driver
class ShiftedConnection(DriverConnection):
    """Of a host that was booted at another time."""

    shift_s = 40_000.0

    @classmethod
    def now_s(cls) -> float:  # type: ignore[override]
        return time.monotonic() + cls.shift_s


@pytest.fixture
def network(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[NetworkDrivers]:
    monkeypatch.setenv(TOKEN_ENV, "")
    monkeypatch.setattr("agentrob.robots.driver.client.DriverConnection", ShiftedConnection)
    started = NetworkDrivers(tmp_path)
    yield started
    started.close()


async def leased(robot: DriverClient, since_s: float | None) -> bool:
    try:
        async with robot.lease("agent", since_s):
            return True
    except LeaseLost:
        return False


async def leased_soon(robot: DriverClient) -> None:
    """Wait until a command surely counts as later than a stop, which is a round trip after it."""
    async with asyncio.timeout(10):
        while not await leased(robot, ShiftedConnection.now_s()):
            pass


@pytest.mark.parametrize("shift_s", [40_000.0, -40_000.0])
async def test_law_14_a_stop_ends_what_was_accepted_before_it_by_whatever_clock(
    network: NetworkDrivers, monkeypatch: pytest.MonkeyPatch, shift_s: float
) -> None:
    monkeypatch.setattr(ShiftedConnection, "shift_s", shift_s)
    name = network.serve()
    now_s = ShiftedConnection.now_s
    async with network.remote(name) as agent, network.client(name) as near:
        accepted_s = now_s()
        assert await leased(agent, accepted_s)
        assert await leased(agent, None)
        await near.stop("a person at the robot")
        assert not await leased(agent, accepted_s)
        await leased_soon(agent)
        async with agent.lease("agent") as lease:
            asked_s = now_s()
            result = await agent.step(lease, NEAR, 10)
            assert asked_s - 0.5 <= result.started_s < result.ended_s <= now_s()
        lock_asked_s = now_s()
        await near.halt("a person at the robot")
        with pytest.raises(RobotError, match="locked after this release was requested"):
            await agent.release("owner", lock_asked_s)
        async with asyncio.timeout(10):
            while (await near.state()).halted:
                with contextlib.suppress(RobotError):  # up to a round trip after the halt
                    await agent.release("owner")


async def test_law_14_our_own_stop_does_not_hide_that_of_a_person_after_it(network: NetworkDrivers) -> None:
    name, now_s = network.serve(), ShiftedConnection.now_s
    async with network.remote(name) as agent, network.client(name) as near:
        for _ in range(20):
            accepted_s = now_s()
            asked_s = now_s()
            stopped = await agent.stop("agent")
            assert asked_s <= stopped.ended_s <= now_s()
            assert await leased(agent, None), "a command that comes once we have heard of it is later"
            assert not await leased(agent, accepted_s)
            counted_s = math.nextafter(stopped.ended_s, math.inf)
            assert await leased(agent, counted_s), "counted from our own stop on"
            await agent.stop("agent: a command of its own", running_only=True)
            assert await leased(agent, counted_s), "it ended no command that waits"
        await near.stop("a person at the robot")
        assert not await leased(agent, counted_s)


async def test_law_14_a_driver_on_another_boot_is_asked_for_its_clock_again(
    network: NetworkDrivers, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, now_s = network.serve(), ShiftedConnection.now_s
    async with network.remote(name) as agent, network.client(name) as near:
        accepted_s = now_s()
        await near.stop("a person at the robot")
        await agent.state()
        clock = agent._connection.clock
        await agent._connection.measure_clock()
        clock.boot, clock.low_s, clock.high_s = "before", clock.low_s + 1000, clock.high_s + 1000
        monkeypatch.setattr(agent._connection, "_keep_open", lambda: None)
        assert not await leased(agent, accepted_s), "by the old clock it would have come after the stop"
        assert clock.boot != "before"
        await leased_soon(agent)


async def test_a_stop_by_two_requests_is_done_once(network: NetworkDrivers) -> None:
    name = network.serve()
    async with network.client(name) as near:
        body: dict[str, Any] = {"by": "a person", "id": "the same"}
        first = await near._call("POST", "/stop", body)
        await near.release("owner")
        assert await near._call("POST", "/stop", body) == first
        assert await near._call("POST", "/stop", {**body, "id": "another"}) != first
        await near._call("POST", "/halt", {**body, "id": "halt"})
        assert await near.release("owner") is not None
        await near._call("POST", "/halt", {**body, "id": "halt"})
        assert not (await near.state()).halted, "the copy came after the release"
