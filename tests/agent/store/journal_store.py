"""Where the agents of a test keep their journal: a SQLite file in their folder, or a database on the PostgreSQL server
that `AGENTROB_TEST_JOURNAL` names. What a test does to it from outside is the same for both."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, create_engine, event, inspect, text
from sqlalchemy.exc import OperationalError

from agentrob.agent.store.journal import Journal
from agentrob.agent.store.journals import make_journals
from agentrob.agent.store.schema import METADATA
from tests.board.running_board import database_for
from tests.databases import JOURNAL_SERVER


def database_of(folder: Path) -> str:
    """Return the URL of the PostgreSQL database for a data folder; empty for SQLite."""
    server = os.environ.get(JOURNAL_SERVER)
    return database_for(server, folder) if server else ""


async def open_journal(folder: Path, robot: str) -> Journal:
    """Open a journal whose `close` ends everything that was opened for it."""
    journals = make_journals(database_of(folder), folder)
    try:
        journal = await journals.open(robot)
    except BaseException:
        await journals.close()
        raise
    close = journal.close

    async def close_all() -> None:
        await close()
        await journals.close()

    journal.close = close_all  # type: ignore[method-assign]
    return journal


def fail_disk(journal: Journal) -> None:
    """Let everything that an open SQLite journal reads or writes fail from now on."""

    def fails(*_: object) -> None:
        raise OperationalError("", {}, sqlite3.OperationalError("disk I/O error"))

    with journal._rows.reading() as db:
        event.listen(db.engine, "before_cursor_execute", fails)


class JournalStore:
    """The journal of one robot, as a test sees it from outside. A copy can be put back while no agent runs."""

    def __init__(self, folder: Path, robot: str, url: str | None = None) -> None:
        """`url` is that of the database, by default `database_of` the folder."""
        self._path = folder / "agents" / robot / "journal.sqlite"
        self._url = database_of(folder) if url is None else url

    @contextmanager
    def _connected(self) -> Iterator[Connection]:
        engine = create_engine(
            self._url or f"sqlite:///{self._path}", connect_args={} if self._url else {"timeout": 10}
        )
        try:
            with engine.begin() as db:
                yield db
        finally:
            engine.dispose()

    def rows(self, query: str, **values: Any) -> list[Any]:
        """Return the rows of a query; none before the journal was first opened."""
        with self._connected() as db:
            return list(db.execute(text(query), values)) if inspect(db).has_table("claim") else []

    def change(self, query: str, **values: Any) -> None:
        with self._connected() as db:
            assert db.execute(text(query), values).rowcount

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Hold up all others that write motions."""
        query = "LOCK TABLE motion IN EXCLUSIVE MODE" if self._url else "UPDATE claim SET boot = boot"
        with self._connected() as db:
            db.execute(text(query))
            yield

    def copy(self) -> dict[str, list[dict[str, Any]]]:
        """Return all rows."""
        with self._connected() as db:
            return {t.name: [dict(row) for row in db.execute(t.select()).mappings()] for t in METADATA.sorted_tables}

    def restore(self, copy: dict[str, list[dict[str, Any]]]) -> None:
        self.delete()
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._connected() as db:
            METADATA.create_all(db)
            for table in METADATA.sorted_tables:
                if copy[table.name]:
                    db.execute(table.insert(), copy[table.name])

    def delete(self) -> None:
        if self._url:
            with self._connected() as db:
                METADATA.drop_all(db)
            return
        for file in self._path.parent.glob("journal.sqlite*"):
            file.unlink()
