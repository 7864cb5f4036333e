"""Session locks on a real PostgreSQL: who holds a robot, until when, and what a question that fails costs."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import create_engine, make_url, text
from structlog.testing import capture_logs

from agentrob.agent.store.journals import PostgresJournals
from agentrob.agent.store.session_locks import ANSWER_S, BEAT_S, SILENT_S, SessionLocks, connect_options
from agentrob.agent.store.versions import VERSION, VERSION_LOCK
from agentrob.errors import JournalError, JournalHeld
from tests.board.running_board import database_for
from tests.waiting import until

REX, MAX = "rex", "max"
#: How much later a busy machine may notice something.
SLACK_S = 10.0


@asynccontextmanager
async def locks_of(url: str) -> AsyncIterator[SessionLocks]:
    locks = await SessionLocks.connect(make_url(url))
    locks.store = "here"
    try:
        yield locks
    finally:
        await locks.close()


@pytest.fixture
async def tables(postgres: str, tmp_path: Path) -> str:
    """The URL of a database with the tables of the journal."""
    url = database_for(postgres, tmp_path)
    journals = PostgresJournals(url, tmp_path)
    await (await journals.open(REX)).close()
    await journals.close()
    return url


def execute(url: str, query: str) -> list[Any]:
    engine = create_engine(url, isolation_level="AUTOCOMMIT")
    try:
        with engine.connect() as db:
            result = db.execute(text(query))
            return [row[0] for row in result] if result.returns_rows else []
    finally:
        engine.dispose()


def holder_of_locks(url: str) -> int:
    """The id of the one server process that holds robots in this database."""
    query = "SELECT DISTINCT pid FROM pg_locks WHERE locktype = 'advisory' AND objsubid = 1 AND database = "
    (pid,) = execute(url, query + "(SELECT oid FROM pg_database WHERE datname = current_database())")
    return int(pid)


async def freed(locks: SessionLocks, robot: str) -> None:
    """Return when nobody holds the robot: the server frees what a connection held a moment after its end, and long
    before it ends a silent one."""
    await until(lambda: locks.free([robot]), lambda free: robot in free, limit_s=SILENT_S / 2)


async def test_law_11_a_released_robot_is_anybodys_at_once_under_a_larger_number(tables: str) -> None:
    async with locks_of(tables) as a, locks_of(tables) as b:
        first, other = await a.take(REX), await a.take(MAX)
        assert first.fence.store == "here"
        assert await b.free([REX, MAX, "nobody"]) == {"nobody"}
        with pytest.raises(JournalHeld, match="another worker"):
            await b.take(REX)
        await a.release(REX)
        assert await a.free([REX, MAX]) == {REX}
        again = await b.take(REX)
        assert again.fence.number > first.fence.number
        with pytest.raises(JournalHeld, match="another worker"):
            await a.take(REX)
        assert not other.lost.is_set()
        with pytest.raises(JournalHeld, match="another worker"):
            await b.take(MAX)


async def test_law_11_the_locks_of_a_connection_that_is_closed_are_lost_and_free(tables: str) -> None:
    async with locks_of(tables) as b:
        with capture_logs() as logs:
            async with locks_of(tables) as a:
                lock = await a.take(REX)
                assert (a.lost, lock.lost.is_set()) == (False, False)
        assert not logs, "this is no fault"
        assert (a.lost, lock.lost.is_set()) == (True, True)
        with pytest.raises(JournalError, match="lost"):
            await a.free([REX])
        await freed(b, REX)
        await b.take(REX)
        assert not b.lost


async def test_law_6_a_connection_that_the_server_ends_loses_its_robots_with_the_next_beat(tables: str) -> None:
    async with locks_of(tables) as a, locks_of(tables) as b:
        with capture_logs() as logs:
            lock = await a.take(REX)
            execute(tables, f"SELECT pg_terminate_backend({holder_of_locks(tables)})")
            async with asyncio.timeout(BEAT_S + ANSWER_S + SLACK_S):
                await lock.lost.wait()
        assert a.lost
        assert [log["robots"] for log in logs if log["event"] == "robots lost"] == [[REX]]
        with pytest.raises(JournalError, match="lost"):
            await a.take(MAX)
        await freed(b, REX)
        await b.take(REX)


async def test_law_6_a_server_that_does_not_answer_costs_all_robots_and_keeps_none_of_them_later(tables: str) -> None:
    async with locks_of(tables) as a, locks_of(tables) as b:
        lock = await a.take(REX)
        server = holder_of_locks(tables)
        os.kill(server, signal.SIGSTOP)
        try:
            begun_s = time.monotonic()
            with pytest.raises(JournalError, match="does not answer"):
                await a.free([REX])
            assert ANSWER_S < time.monotonic() - begun_s < ANSWER_S + SLACK_S
            assert (a.lost, lock.lost.is_set()) == (True, True)
        finally:
            os.kill(server, signal.SIGCONT)
        await freed(b, REX)


async def test_a_question_that_fails_costs_no_robot_and_leaves_the_robot_that_it_was_for(tables: str) -> None:
    async with locks_of(tables) as a, locks_of(tables) as b:
        held = await a.take(REX)
        execute(tables, "ALTER TABLE holder RENAME TO away")
        with pytest.raises(JournalError, match="cannot be used"):
            await a.take(MAX)
        execute(tables, "ALTER TABLE away RENAME TO holder")
        assert (a.lost, held.lost.is_set()) == (False, False)
        await b.take(MAX)
        with pytest.raises(JournalHeld):
            await b.take(REX)
        with pytest.raises(JournalHeld, match="already runs"):
            await a.take(REX)
        assert await a.free([REX, MAX]) == set()


async def test_law_6_a_robot_is_taken_only_once_the_transaction_of_its_last_holder_has_ended(tables: str) -> None:
    engine = create_engine(tables)
    try:
        async with locks_of(tables) as a:
            with engine.begin() as last:
                last.execute(text("SELECT * FROM holder WHERE robot = 'rex' FOR UPDATE"))
                with pytest.raises(JournalHeld, match="transaction is not ended yet"):
                    await a.take(REX)
                assert not a.lost
            await a.take(REX)
    finally:
        engine.dispose()


async def test_law_6_a_query_that_waits_for_the_connection_is_not_one_without_an_answer(tables: str) -> None:
    """Each is refused after a second, so the last one waits for longer than `ANSWER_S`."""
    engine = create_engine(tables)
    robots = [f"robot-{number}" for number in range(5)]
    try:
        async with locks_of(tables) as a:
            held = await a.take(REX)
            with engine.begin() as other:
                other.execute(text("LOCK TABLE holder IN EXCLUSIVE MODE"))
                begun_s = time.monotonic()
                taken = await asyncio.gather(*map(a.take, robots), return_exceptions=True)
                assert time.monotonic() - begun_s > ANSWER_S + BEAT_S, "none had to wait"
            assert {type(one) for one in taken} == {JournalHeld}, taken
            assert (a.lost, held.lost.is_set()) == (False, False)
            assert await a.free([REX, *robots]) == set(robots)
    finally:
        engine.dispose()


async def test_a_connected_worker_says_which_version_of_the_tables_it_uses(tables: str) -> None:
    used = f"SELECT objid FROM pg_locks WHERE locktype = 'advisory' AND classid = {VERSION_LOCK} AND objsubid = 2"
    async with locks_of(tables):
        assert set(execute(tables, used)) == {VERSION}


def test_what_the_url_says_of_the_connection_counts() -> None:
    found = connect_options(make_url("postgresql://db/x?connect_timeout=9&options=-c%20work_mem%3D8MB"))
    assert "connect_timeout" not in found
    assert found["tcp_user_timeout"] == "3000"
    assert "-c lock_timeout=8s" in found["options"]
    assert found["options"].endswith(" -c work_mem=8MB")


async def test_a_database_that_is_not_there_is_an_error() -> None:
    with pytest.raises(JournalError, match="cannot be reached"):
        await SessionLocks.connect(make_url("postgresql+psycopg://nobody@127.0.0.1:1/none"))
