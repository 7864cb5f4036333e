"""Open the journals of robots: a SQLite file for each, or one PostgreSQL database for all robots and workers."""

from __future__ import annotations

import asyncio
import fcntl
import sqlite3
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from functools import partial
from pathlib import Path
from typing import Any, Protocol
from uuid import uuid4

from sqlalchemy import URL, Connection, create_engine, func, make_url, select
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.pool import NullPool

from agentrob.agent.store import old_journals, versions
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.queries import VALUE, insert_new
from agentrob.agent.store.schema import ALL, META, METADATA
from agentrob.agent.store.session_locks import SessionLocks, connect_options
from agentrob.agent.store.transactions import RobotLock, SerialExecutor, Transactions
from agentrob.errors import JournalError, JournalHeld

#: Threads, and connections to PostgreSQL, that all journals of a process share.
THREADS = 8
#: PostgreSQL's advisory lock for whoever creates the tables.
_CREATING_LOCK = 4_107_005


class Journals(Protocol):
    """Opens journals."""

    async def open(self, robot: str) -> Journal:
        """Hold a robot and open its journal. Raises `JournalHeld` while another agent holds it, and `JournalError`."""
        ...

    async def free(self, robots: Sequence[str]) -> frozenset[str]:
        """Those that nobody holds, as far as that is known without trying. Raises `JournalError`."""
        ...

    async def close(self) -> None:
        """After all journals were closed."""
        ...


def make_journals(url: str, data: Path) -> Journals:
    """The journals in the database of this SQLAlchemy URL; if it is empty, in the data folder."""
    return PostgresJournals(url, data) if url else SqliteJournals(data)


async def _opened(journal: Journal) -> Journal:
    try:
        await journal.begin()
    except BaseException:
        await asyncio.shield(journal.close())
        raise
    return journal


class SqliteJournals:
    """For robots of one machine: `agents/NAME/journal.sqlite` in the data folder. Who holds the robot has locked
    `journal.lock` beside it."""

    def __init__(self, data: Path) -> None:
        self._data = data
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="journal")

    async def open(self, robot: str) -> Journal:
        calls, files = SerialExecutor(self._threads), ExitStack()
        try:
            db = await calls.run(self._open, robot, files)
        except BaseException:
            await asyncio.shield(calls.run(files.close))
            raise
        rows = Transactions(lambda: nullcontext(db), partial(_immediate, db), calls, RobotLock(robot))
        return await _opened(Journal(rows, lambda: calls.run(files.close)))

    def _open(self, robot: str, files: ExitStack) -> Connection:
        folder = self._data / "agents" / robot
        _lock(folder, robot, files)
        db = _open_sqlite(folder / "journal.sqlite", files)
        try:
            with _immediate(db):
                old_journals.create_tables(db, robot)
        except (SQLAlchemyError, sqlite3.Error) as e:
            raise _cannot_open(folder / "journal.sqlite", e) from None
        return db

    async def free(self, robots: Sequence[str]) -> frozenset[str]:
        return frozenset(robots)

    async def close(self) -> None:
        self._threads.shutdown(wait=False)


class PostgresJournals:
    """For workers on any number of machines. A worker's robots are lost together when its `SessionLocks` are.

    A robot's SQLite file in the data folder, of the time before, is imported when the robot is first opened.
    """

    def __init__(self, url: str, data: Path) -> None:
        self._data = data
        self._url = make_url(url)
        try:
            self._engine = create_engine(
                self._url, pool_size=THREADS, max_overflow=0, pool_pre_ping=True, hide_parameters=True,
                isolation_level="READ COMMITTED", connect_args=connect_options(self._url),
            )  # fmt: skip
        except ImportError as e:
            raise JournalError(f"PostgreSQL needs the package agentrob[postgres]: {e}") from None
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="journal")
        self._connecting = asyncio.Lock()
        self._locks: SessionLocks | None = None

    async def open(self, robot: str) -> Journal:
        locks = await self._connected()
        lock = await locks.take(robot)
        # Reading without a transaction costs one round trip instead of three.
        reading = self._engine.execution_options(isolation_level="AUTOCOMMIT")
        rows = Transactions(reading.begin, self._engine.begin, SerialExecutor(self._threads), lock)
        journal = Journal(rows, lambda: locks.release(robot))
        try:
            await self._import(robot, rows)
        except BaseException:
            await asyncio.shield(journal.close())
            raise
        return await _opened(journal)

    async def free(self, robots: Sequence[str]) -> frozenset[str]:
        return await (await self._connected()).free(robots)

    async def close(self) -> None:
        if self._locks is not None:
            await self._locks.close()
        self._threads.shutdown(wait=False)
        self._engine.dispose()

    async def _connected(self) -> SessionLocks:
        async with self._connecting:
            if self._locks is None or self._locks.lost:
                if self._locks is not None:
                    await self._locks.close()
                self._locks = await self._connect()
            return self._locks

    async def _connect(self) -> SessionLocks:
        """The lock for our version comes first, so that nobody changes the tables after we have looked at them."""
        locks = await SessionLocks.connect(self._url)
        try:
            locks.store = await asyncio.get_running_loop().run_in_executor(self._threads, self._create_tables)
        except SQLAlchemyError as e:
            raise JournalError(f"the journal's database cannot be used: {getattr(e, 'orig', e)}") from None
        finally:
            if not locks.store:
                await asyncio.shield(locks.close())
        return locks

    def _create_tables(self) -> str:
        """Returns the id of this database. Several workers may try at once. Raises `JournalError` if the tables are of
        a newer version, or of an older one that is in use."""
        with self._engine.begin() as db:
            db.execute(select(func.pg_advisory_xact_lock(_CREATING_LOCK)))
            if versions.stored_version(db) not in (None, versions.VERSION):
                versions.refuse_while_older_serve(db)
            METADATA.create_all(db)
            versions.write_version(db)
            insert_new(db, META, robot=ALL, key="store", value=str(uuid4()))
            return str(db.execute(VALUE, {"this_robot": ALL, "this_key": "store"}).scalar_one())

    async def _import(self, robot: str, rows: Transactions) -> None:
        path = self._data / "agents" / robot / "journal.sqlite"
        if not path.exists():
            return
        with ExitStack() as files:
            _lock(path.parent, robot, files)  # an agent of the time before may still run
            found = await asyncio.to_thread(_read_file, path)
            await rows.write(lambda db: old_journals.add_rows(db, robot, found))
            old_journals.set_aside(path)


def _lock(folder: Path, robot: str, files: ExitStack) -> None:
    """Lock a robot's folder on this machine until `files` is closed."""
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        fcntl.flock(files.enter_context((folder / "journal.lock").open("w")), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise JournalHeld(
            f"an agent for {robot} already runs with {folder}; end it first, or use another data folder"
        ) from None
    except OSError as e:
        raise _cannot_open(folder / "journal.sqlite", e) from None


def _cannot_open(path: Path, error: Exception) -> JournalError:
    return JournalError(f"the journal {path} cannot be opened: {getattr(error, 'orig', error)}")


def _read_file(path: Path) -> old_journals.Rows:
    with ExitStack() as files:
        db = _open_sqlite(path, files)
        try:
            with _immediate(db):
                return old_journals.read_rows(db)
        except (SQLAlchemyError, sqlite3.Error) as e:
            raise _cannot_open(path, e) from None


def _open_sqlite(path: Path, files: ExitStack) -> Connection:
    """Connect to a file until `files` is closed. Committed rows are on disk."""
    engine = create_engine(
        URL.create("sqlite", database=str(path)), poolclass=NullPool, hide_parameters=True,
        isolation_level="AUTOCOMMIT", connect_args={"timeout": 30.0, "check_same_thread": False},
    )  # fmt: skip
    try:
        db = files.enter_context(engine.connect())
        db.exec_driver_sql("PRAGMA journal_mode=wal").close()  # an open cursor could keep a commit waiting
        db.exec_driver_sql("PRAGMA synchronous=FULL").close()
    except SQLAlchemyError as e:
        raise _cannot_open(path, e) from None
    return db


@contextmanager
def _immediate(db: Connection) -> Iterator[Connection]:
    """A transaction of SQLite that takes the write lock at once."""
    raw: Any = db.connection.driver_connection
    raw.execute("BEGIN IMMEDIATE")
    try:
        yield db
        raw.execute("COMMIT")
    except BaseException:
        with suppress(sqlite3.Error):  # the disk that failed the write may fail this too
            raw.execute("ROLLBACK")
        raise
