"""Journals of a newer version are refused, and none is changed while an older worker uses it."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from sqlalchemy import create_engine, inspect

from agentrob.agent.store import versions
from agentrob.agent.store.journals import Journals, make_journals
from agentrob.agent.store.old_journals import OLD_ENGINE, create_tables
from agentrob.agent.store.schema import METADATA
from agentrob.errors import JournalError
from agentrob.model import CommandState
from tests.agent.store.journal_store import JournalStore, database_of
from tests.agent.store.old_journal import write_old_journal
from tests.agent.store.test_journal import command, says

REX, MAX = "rex", "max"
OLD, NEW = versions.VERSION, versions.VERSION + 1
VERSION_ROW = "SELECT value FROM meta WHERE robot = '' AND key = 'schema'"


@asynccontextmanager
async def worker(folder: Path, monkeypatch: pytest.MonkeyPatch, version: int = OLD) -> AsyncIterator[Journals]:
    """The journals as a worker of this version opens them, from now on."""
    monkeypatch.setattr(versions, "VERSION", version)
    journals = make_journals(database_of(folder), folder)
    try:
        yield journals
    finally:
        await journals.close()


def stored(folder: Path) -> list[str]:
    return [row.value for row in JournalStore(folder, REX).rows(VERSION_ROW)]


@pytest.mark.usefixtures("database")
async def test_an_older_worker_refuses_a_newer_journal_and_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with worker(tmp_path, monkeypatch, NEW) as new:
        journal = await new.open(REX)
        await journal.claim(command("1"))
        await journal.close()
    before = JournalStore(tmp_path, REX).copy()
    assert stored(tmp_path) == [str(NEW)]
    async with worker(tmp_path, monkeypatch, OLD) as old:
        with pytest.raises(JournalError, match=f"has version {NEW}, and this AgentRob reads up to {OLD}; upgrade it"):
            await old.open(REX)
    assert JournalStore(tmp_path, REX).copy() == before
    async with worker(tmp_path, monkeypatch, NEW) as new:
        journal = await new.open(REX)
        assert await journal.claimed("1") is not None
        await journal.close()


@pytest.mark.usefixtures("database")
async def test_a_newer_worker_changes_nothing_while_an_older_one_serves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with worker(tmp_path, monkeypatch, OLD) as old:
        journal = await old.open(REX)
        async with worker(tmp_path, monkeypatch, NEW) as new:
            with pytest.raises(JournalError, match=r"agentrob agent drain|end it first"):
                await new.open(REX)
            assert stored(tmp_path) == [str(OLD)]
            assert await journal.move("1", says("moved")) == "moved", "the older one works on"
            await journal.close()
            await old.close()
            journal = await new.open(REX)
            assert stored(tmp_path) == [str(NEW)]
            assert await journal.move("1", says("again")) == "moved", "what moved is known"
            await journal.close()


@pytest.mark.slow
async def test_an_older_worker_without_a_robot_keeps_a_newer_one_from_changing_the_tables(
    postgres: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AGENTROB_TEST_JOURNAL", postgres)
    async with worker(tmp_path, monkeypatch, OLD) as old:
        assert await old.free([REX, MAX]) == {REX, MAX}
        async with worker(tmp_path, monkeypatch, NEW) as new:
            with pytest.raises(JournalError, match="a worker of the older version still uses it"):
                await new.free([REX])
            await old.close()
            assert await new.free([REX]) == {REX}
    async with worker(tmp_path, monkeypatch, OLD) as old:
        with pytest.raises(JournalError, match="upgrade it"):
            await old.free([REX])


@pytest.mark.usefixtures("database")
async def test_law_6_the_journal_of_version_0_1_gets_the_current_version(tmp_path: Path) -> None:
    write_old_journal(tmp_path, REX, command("1"), command("2"), begun=("1",))
    journals = make_journals(database_of(tmp_path), tmp_path)
    journal = await journals.open(REX)
    assert stored(tmp_path) == [str(versions.VERSION)]
    assert [claim.command.post_id for claim in await journal.open_claims()] == ["1", "2"], "in the order of its claims"
    assert await journal.move("1", says("again")) == CommandState.INTERRUPTED
    assert await journal.move("2", says("moved")) == "moved"
    await journal.close()
    await journals.close()


def test_the_tables_of_the_workflow_engine_of_version_0_1_are_dropped(tmp_path: Path) -> None:
    engine = create_engine(f"sqlite:///{write_old_journal(tmp_path, REX, command('1'))}")
    with engine.begin() as db:
        assert set(OLD_ENGINE) & set(inspect(db).get_table_names()), "it had some of them"
        create_tables(db, REX)
        assert set(inspect(db).get_table_names()) == set(METADATA.tables)
    engine.dispose()


@pytest.mark.slow
async def test_a_newer_file_is_not_imported(postgres: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async with worker(tmp_path, monkeypatch, NEW) as new:
        journal = await new.open(REX)
        await journal.claim(command("1"))
        await journal.close()
    monkeypatch.setenv("AGENTROB_TEST_JOURNAL", postgres)
    async with worker(tmp_path, monkeypatch, OLD) as old:
        with pytest.raises(JournalError, match="upgrade it here"):
            await old.open(REX)
    assert (tmp_path / "agents" / REX / "journal.sqlite").exists()


@pytest.mark.usefixtures("database")
async def test_tables_without_a_version_are_read(tmp_path: Path) -> None:
    """They were written before the version was."""
    for claimed in (None, "1"):
        journals = make_journals(database_of(tmp_path), tmp_path)
        journal = await journals.open(REX)
        assert (await journal.claimed("1") is not None) == (claimed is not None)
        await journal.claim(command("1"))
        await journal.close()
        await journals.close()
        assert stored(tmp_path) == [str(versions.VERSION)]
        JournalStore(tmp_path, REX).change("DELETE FROM meta WHERE robot = '' AND key = 'schema'")
