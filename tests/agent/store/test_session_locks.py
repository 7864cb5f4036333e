"""Session locks on a real PostgreSQL: who holds a robot, until when, and what a question that fails costs."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from sqlalchemy import create_engine, make_url, text

from agentrob.agent.store.journals import PostgresJournals
from agentrob.agent.store.session_locks import SessionLocks
from agentrob.errors import JournalError, JournalHeld
from tests.board.running_board import database_for

REX, MAX = "rex", "max"


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


def execute(url: str, query: str) -> None:
    engine = create_engine(url, isolation_level="AUTOCOMMIT")
    with engine.connect() as db:
        db.execute(text(query))
    engine.dispose()


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
        async with locks_of(tables) as a:
            lock = await a.take(REX)
            assert (a.lost, lock.lost.is_set()) == (False, False)
        assert (a.lost, lock.lost.is_set()) == (True, True)
        with pytest.raises(JournalError, match="lost"):
            await a.free([REX])
        await b.take(REX)
        assert not b.lost


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


async def test_a_database_that_is_not_there_is_an_error() -> None:
    with pytest.raises(JournalError, match="cannot be reached"):
        await SessionLocks.connect(make_url("postgresql+psycopg://nobody@127.0.0.1:1/none"))
