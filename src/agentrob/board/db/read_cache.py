"""Keep what was read from the database until it may have changed, by whatever process."""

from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

from sqlalchemy import Connection
from sqlalchemy.exc import SQLAlchemyError

T = TypeVar("T")
#: Entries of the cache, which every change clears.
MAX_KEPT = 2000
_MARK = "SELECT mark FROM access_version"


class ReadCache:
    """Results of reads on one connection, from one thread at a time.

    Whether something has changed is asked before each use, so that a request never sees less than was committed before
    it. SQLite tells of every commit of other connections. PostgreSQL does not; there a mark changes together with
    accounts, sessions, tokens, boards and robots' rights (`access_version`), and only these are kept. The mark is asked
    for once in each run of the event loop, in which nothing else is read.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._sqlite = connection.dialect.name == "sqlite"
        self._kept: dict[Hashable, Any] = {}
        self._kept_at: Hashable = None
        self._mark: str | None = None
        self._mark_read = False

    def kept(self, key: Hashable, read: Callable[[], T], *, access: bool) -> T:
        """The result of `read`. `access`: it changes only with accounts, sessions, tokens, boards or robots' rights."""
        newest: Hashable = self.commits() if self._sqlite else self._access_mark() if access else None
        if newest is None:
            return read()
        if newest != self._kept_at or len(self._kept) >= MAX_KEPT:
            self._kept, self._kept_at = {}, newest
        if key not in self._kept:
            self._kept[key] = read()
        found: T = self._kept[key]
        return found

    def commits(self) -> int | None:
        """A number that changes with every commit of another connection; None if the database has none."""
        if not self._sqlite:
            return None
        raw: Any = self._connection.connection.dbapi_connection
        try:
            return int(raw.execute("PRAGMA data_version").fetchone()[0])
        except sqlite3.Error:
            return None

    def _access_mark(self) -> str | None:
        """The mark; None if it cannot be read. A read then says why."""
        if self._mark_read:
            return self._mark
        self._mark = self._read_mark()
        try:
            asyncio.get_running_loop().call_soon(self._forget_mark)
        except RuntimeError:  # no event loop
            return self._mark
        self._mark_read = True
        return self._mark

    def _forget_mark(self) -> None:
        self._mark_read = False

    def _read_mark(self) -> str | None:
        errors = self._connection.dialect.loaded_dbapi.Error
        try:
            raw: Any = self._connection.connection.dbapi_connection
            if not raw.autocommit:
                return None
            row = raw.execute(
                _MARK
            ).fetchone()  # each request does this: a third of the time of a statement of SQLAlchemy
        except (errors, SQLAlchemyError):
            return None
        return str(row[0]) if row else None
