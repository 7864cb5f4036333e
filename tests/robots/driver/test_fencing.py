"""Fencing numbers: a worker that lost the robot cannot move it any more; a stop needs none."""

from __future__ import annotations

import asyncio
import errno
import json
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.errors import Fenced, LeaseLost, RobotError
from agentrob.model import FencingToken
from agentrob.process.host_lock import namespaced
from agentrob.robots.driver.fencing import STORES, FencingNumbers
from agentrob.robots.driver.lease import Leases
from agentrob.robots.driver.stop import stop_driver
from tests.robots.driver_scene import FAR, NEAR, Drivers, Standing, at_rest, moving
from tests.waiting import until


async def test_law_11_a_newer_worker_stops_the_robot_of_an_older_one_and_locks_it_out(drivers: Drivers) -> None:
    name, _ = drivers.start()
    async with drivers.client(name) as older, drivers.client(name) as newer:
        await older.fence(FencingToken("db", 1))
        async with older.lease("older") as lease:
            step = asyncio.create_task(older.step(lease, FAR, 60))
            await moving(older)
            await newer.fence(FencingToken("db", 2))
            assert (await step).reason == "fenced"
            lost = await older.lost(lease)
            assert lost is not None
            assert (lost.why, lost.by) == ("fenced", "")
            assert "because another worker took the robot" in str(lost)
            with pytest.raises(LeaseLost):
                await older.step(lease, NEAR, 10)
        await until(newer.state, at_rest)
        async with newer.lease("newer") as lease:
            assert (await newer.step(lease, NEAR, 10)).ok
        for call in (older.fence(FencingToken("db", 1)), older.lease("older").__aenter__()):
            with pytest.raises(Fenced, match=r"its number is 2, yours is 1\); take the robot again"):
                await call
        assert (await older.stop("older")).confirmed, "a stop needs no fencing number"


async def test_an_equal_number_a_lease_without_one_and_another_database_are_accepted(standing: Standing) -> None:
    drivers, name = standing
    async with drivers.client(name) as worker, drivers.client(name) as shell, drivers.client(name) as other:
        await worker.fence(FencingToken("db", 7))
        await worker.fence(FencingToken("db", 7))
        async with shell.lease("drive") as lease:
            assert (await shell.step(lease, NEAR, 10)).ok
            await worker.fence(FencingToken("db", 8))
            assert await shell.lost(lease) is None, "only a lease with a smaller number ends"
        await other.fence(FencingToken("another", 1))
        for client in (worker, other):
            async with client.lease("worker") as lease:
                await worker.fence(FencingToken("db", 8))
                assert await client.lost(lease) is None


async def test_law_11_a_killed_driver_knows_the_number_when_it_starts_again(drivers: Drivers) -> None:
    name, process = drivers.start()
    async with drivers.client(name) as older, drivers.client(name) as newer:
        await older.fence(FencingToken("db", 1))
        await newer.fence(FencingToken("db", 2))
        process.kill()
        process.communicate()
        drivers.start(name)
        with pytest.raises(Fenced):
            async with older.lease("older"):
                pass
        async with newer.lease("newer"):
            pass


async def test_a_lease_request_alone_brings_its_number(drivers: Drivers) -> None:
    name, process = drivers.start()
    async with drivers.client(name) as older, drivers.client(name) as newer:
        await newer.fence(FencingToken("db", 2))
        process.kill()
        process.communicate()
        (drivers.folder / "drivers" / f"{name}.fence").unlink()
        drivers.start(name)
        async with newer.lease("newer"):
            pass
        with pytest.raises(Fenced):
            await older.fence(FencingToken("db", 1))
    kept = json.loads((drivers.folder / "drivers" / f"{name}.fence").read_text())
    assert kept == {"db": 2}


async def test_law_13_numbers_that_cannot_be_read_lock_workers_out_but_not_a_stop(drivers: Drivers) -> None:
    (drivers.folder / "drivers").mkdir()
    name = "unreadable"
    (drivers.folder / "drivers" / f"{name}.fence").write_text('{"db": "many"}')
    drivers.start(name)
    async with drivers.client(name) as robot:
        with pytest.raises(Fenced, match=r"cannot be read .* remove the file"):
            await robot.fence(FencingToken("db", 99))
        assert (await robot.stop("passer-by")).confirmed
    assert stop_driver(namespaced(f"driver/fake/{name}"), "shell").confirmed


@pytest.mark.parametrize(
    "body",
    [{}, {"store": "", "number": 1}, {"store": "db"}, {"store": "db", "number": -1}, {"store": "db", "number": True},
     {"store": "d\nb", "number": 1}, {"store": "db", "number": 1.5}, {"store": "x" * 201, "number": 1},
     {"store": "db", "number": 2**63}],
)  # fmt: skip
async def test_a_number_that_cannot_be_read_is_refused(standing: Standing, body: object) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot:
        for path, request in (("/fence", body), ("/lease", {"holder": "me", "fence": body})):
            with pytest.raises(RobotError, match="must") as caught:
                await robot._call("POST", path, request)
            assert not isinstance(caught.value, Fenced)


# ------------------------------------------------------------------ the numbers themselves
@given(st.lists(st.tuples(st.sampled_from("ab"), st.integers(0, 5)), max_size=30))
def test_a_number_is_accepted_exactly_if_none_of_its_database_was_larger(asked: list[tuple[str, int]]) -> None:
    numbers, largest = FencingNumbers(), {"a": -1, "b": -1}
    for store, number in asked:
        try:
            raised = numbers.see(FencingToken(store, number))
        except Fenced:
            assert number < largest[store]
        else:
            assert number >= largest[store]
            assert raised == (number > largest[store])
            largest[store] = number


def test_numbers_survive_and_their_file_is_written_only_if_one_has_changed(tmp_path: Path) -> None:
    path = tmp_path / "new folder" / "r.fence"
    numbers = FencingNumbers(path)
    assert not numbers.known
    numbers.see(FencingToken("db", 3))
    numbers.save()
    written_ns = path.stat().st_mtime_ns
    numbers.see(FencingToken("db", 3))
    numbers.save()
    assert path.stat().st_mtime_ns == written_ns
    again = FencingNumbers(path)
    assert again.known
    with pytest.raises(Fenced):
        again.check(FencingToken("db", 2))
    again.check(FencingToken("db", 3))
    assert list(path.parent.iterdir()) == [path]


def test_a_number_that_cannot_be_written_holds_in_memory_and_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    numbers = FencingNumbers(tmp_path / "r.fence")
    monkeypatch.setattr(os, "fsync", full)
    for _ in range(2):  # the second attempt must not take the first for a success
        numbers.see(FencingToken("db", 3))
        with pytest.raises(RobotError, match="cannot be written"):
            numbers.save()
    with pytest.raises(Fenced):
        numbers.check(FencingToken("db", 2))


def test_numbers_of_a_bounded_count_of_databases_are_kept_and_none_is_forgotten() -> None:
    numbers = FencingNumbers()
    for store in range(STORES):
        numbers.see(FencingToken(f"db{store}", 2))
    with pytest.raises(Fenced, match="keeps no more"):
        numbers.see(FencingToken("one more", 1))
    for store in range(STORES):
        with pytest.raises(Fenced):
            numbers.see(FencingToken(f"db{store}", 1))


def test_law_11_a_worker_that_is_locked_out_while_it_waits_gets_no_lease() -> None:
    leases = Leases()
    leases.fence(FencingToken("db", 1))
    leases.fence(FencingToken("db", 2))
    with pytest.raises(Fenced):
        leases.take("older", fence=FencingToken("db", 1))
    assert leases.holder is None
