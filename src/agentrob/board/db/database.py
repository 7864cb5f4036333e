"""Open the forum's database (SQLite in WAL mode, PostgreSQL, or another SQLAlchemy URL) and migrate it."""

from __future__ import annotations

import hashlib
import sqlite3
import time
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from alembic.migration import MigrationContext
from sqlalchemy import Connection, Engine, create_engine, event, func, make_url, select
from sqlalchemy.exc import DBAPIError, OperationalError

from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError, RobotBusy
from agentrob.process.host_lock import HostLock

#: Seconds to wait for another process that creates the same database.
LOCKED_S = 5.0
#: Seconds to wait, on PostgreSQL, for another process that migrates the tables.
MIGRATING_S = 60.0
#: Advisory locks of a PostgreSQL database: of the writer, of the serving processes, and of the one with the duties.
WRITING_LOCK, SERVING_LOCK, LEADING_LOCK = 4_107_002, 4_107_003, 4_107_004
#: A post's age (law 5) depends on the clock of the process that accepted it, so all clocks must be close.
MAX_SKEW_S = 2.0
#: The PostgreSQL channel on which each commit is announced as `<process> commit`.
CHANNEL = "agentrob_board"
#: Seconds after which PostgreSQL ends an idle transaction, as of a writer whose host died.
SILENT_S = 10
#: Options of libpq that detect a lost server within seconds.
_NOTICED = {
    "connect_timeout": "3", "keepalives_idle": "2", "keepalives_interval": "1", "keepalives_count": "3",
    "tcp_user_timeout": "3000",
}  # fmt: skip


def open_engine(settings: BoardSettings, *, writes: bool, process: str = "", patience_s: float | None = None) -> Engine:
    """An engine for the one writer (each transaction takes the write lock at once) or for reading.

    Reading goes statement by statement, so that every read sees the newest commit. On PostgreSQL others are notified of
    each commit by the name of this `process`, and a statement that takes longer than `patience_s` is given up.
    """
    if path := settings.database_path:
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as e:
            raise BoardError(503, "storage", f"cannot make the folder {path.parent}: {e.strerror}") from None
    # Set explicitly, whatever the database's default: each statement sees what others have committed (`_one_writer`).
    # A writer checks its connection before use, so that a restart of the database server loses no stop.
    options: dict[str, Any] = {"isolation_level": "READ COMMITTED", "pool_pre_ping": writes} if settings.shared else {}
    engine = create_engine(settings.database, connect_args=connect_args(settings), **options)
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _set_up_sqlite)
        if writes:
            event.listen(engine, "begin", _begin_immediate)
    elif engine.dialect.name == "postgresql":
        _set_up_postgresql(engine, settings, writes, process, patience_s)
    return engine if writes else engine.execution_options(isolation_level="AUTOCOMMIT")


def connect_args(settings: BoardSettings) -> dict[str, Any]:
    """Return connection options of the driver: wait for other writers, but not for a lost server."""
    if settings.database.startswith("sqlite"):
        return {"check_same_thread": False, "timeout": settings.busy_timeout_s}
    if settings.shared:
        given = make_url(settings.database).query
        return {name: value for name, value in _NOTICED.items() if name not in given}
    return {}


def connection_words(settings: BoardSettings) -> dict[str, Any]:
    """Return the arguments with which `psycopg` connects to the same PostgreSQL database."""
    url = make_url(settings.database)
    words = url.get_dialect()().create_connect_args(url)[1]
    return connect_args(settings) | {k: v for k, v in words.items() if k != "context"}


def _set_up_sqlite(connection: Any, _record: object) -> None:
    connection.isolation_level = None  # transactions are begun by `_begin_immediate`, not by the driver
    # In WAL mode, NORMAL never corrupts the database; only a power failure can lose the last commits. The robot's own
    # journal also prevents repeated motions.
    _patiently(connection, "PRAGMA journal_mode=WAL")
    for pragma in ("synchronous=NORMAL", "foreign_keys=ON", "cache_size=-16000"):
        connection.execute("PRAGMA " + pragma)


def _patiently(connection: Any, statement: str) -> None:
    """Retry a statement for which SQLite does not wait itself, for example when two processes create a database."""
    until_s = time.monotonic() + LOCKED_S
    while True:
        try:
            connection.execute(statement)
            return
        except sqlite3.OperationalError as e:
            if "locked" not in str(e) or time.monotonic() > until_s:
                raise
            time.sleep(0.02)


def _begin_immediate(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN IMMEDIATE")


def _set_up_postgresql(
    engine: Engine, settings: BoardSettings, writes: bool, process: str, patience_s: float | None
) -> None:
    if patience_s is not None:
        event.listen(engine, "connect", partial(_set_timeout, patience_s))
    if writes:
        event.listen(engine, "begin", partial(_one_writer, settings.busy_timeout_s))
        event.listen(engine, "commit", partial(_notify_commit, process))


def _set_timeout(patience_s: float, connection: Any, _record: object) -> None:
    with connection.cursor() as cursor:
        cursor.execute(f"SET statement_timeout = {int(patience_s * 1000)}")
    connection.commit()


def _one_writer(patience_s: float, connection: Connection) -> None:
    """Let writers wait for each other, as in SQLite. So events become visible in the order of their ids, followers miss
    none, and checks of keys, limits and counts still hold when the row is written, across processes."""
    connection.exec_driver_sql(
        f"SET LOCAL lock_timeout = '{int(patience_s * 1000)}ms'; "
        f"SET LOCAL idle_in_transaction_session_timeout = '{SILENT_S}s'; "
        f"SELECT pg_advisory_xact_lock({WRITING_LOCK})"
    )


def _notify_commit(process: str, connection: Connection) -> None:
    """Announce the commit; PostgreSQL delivers it only if the transaction is committed."""
    connection.exec_driver_sql(f"NOTIFY {CHANNEL}, '{process} commit'")


def migrate(settings: BoardSettings, to: str = "head", *, alone: bool = False) -> None:
    """Migrate the tables to this version, if needed. Two processes may do so at the same time.

    `to` is a revision, possibly an earlier one, to go back to an earlier version of AgentRob. Unless the caller is
    `alone`, tables that a process of another version serves are not changed: 409.
    """
    from alembic import command
    from alembic.util import CommandError

    patience_s = MIGRATING_S if settings.shared else settings.busy_timeout_s
    engine = open_engine(replace(settings, busy_timeout_s=patience_s), writes=True)
    config, known = _revisions()
    try:
        with ExitStack() as until_done, engine.begin() as connection:
            config.attributes["connection"] = connection
            current = MigrationContext.configure(connection).get_current_revision()
            to = known[0] if to == "head" else to
            if to not in known:
                raise BoardError(404, "no_such_revision", f"there is no revision {to!r}", ", ".join(known))
            if not alone and current not in (None, to):
                if settings.shared:
                    _nobody_serves(connection)
                else:
                    until_done.enter_context(_nobody_serves_here(settings))
            down = current in known and known.index(to) > known.index(str(current))
            (command.downgrade if down else command.upgrade)(config, to)
    except CommandError as e:
        raise BoardError(409, "other_version", f"the tables cannot be brought there: {e}", "update AgentRob") from e
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()


def check_version(settings: BoardSettings) -> bool:
    """Return whether there are tables, without changing anything. 409 if they are of another version."""
    if settings.database_path is not None and not settings.database_path.exists():
        return False  # connecting would create an empty file
    engine = open_engine(settings, writes=False)
    try:
        with engine.connect() as connection:
            current = MigrationContext.configure(connection).get_current_revision()
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()
    newest = _revisions()[1][0]
    if current not in (None, newest):
        what = f"the tables of {settings.database_shown} are at {current}, and this version of AgentRob needs {newest}"
        raise BoardError(409, "other_version", what, "end the forum, then run: agentrob board migrate")
    return current is not None


def _revisions() -> tuple[Any, list[str]]:
    """The configuration of alembic, and all revisions, newest first."""
    from alembic.config import Config
    from alembic.script import ScriptDirectory

    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    return config, [r.revision for r in ScriptDirectory.from_config(config).walk_revisions()]


def serving_lock(settings: BoardSettings) -> HostLock:
    """The lock of the process that serves a database on this host. Raises `RobotBusy` if another one has it."""
    path = settings.database_path
    key = str(path.resolve()) if path else settings.database_shown
    return HostLock("board/" + hashlib.sha256(key.encode()).hexdigest()[:16], f"the database {key}")


def _nobody_serves(connection: Connection) -> None:
    """Take the serving lock until the end of the transaction; 409 if a process serves the database."""
    if not connection.execute(select(func.pg_try_advisory_xact_lock(SERVING_LOCK))).scalar_one():
        raise _older_version_serves()


def _nobody_serves_here(settings: BoardSettings) -> HostLock:
    try:
        return serving_lock(settings)
    except RobotBusy:
        raise _older_version_serves() from None


def _older_version_serves() -> BoardError:
    what = "the tables must change for this version, but another process serves the forum: end all of them first"
    return BoardError(409, "older_version_serves", what)


def check_clock(before: float, there: float, after: float) -> None:
    """503 if the database's clock, read between two readings of ours, differs by more than `MAX_SKEW_S`."""
    ahead_s, behind_s = before - there, there - after
    if (skew_s := max(ahead_s, behind_s)) > MAX_SKEW_S:
        how = "ahead of" if skew_s == ahead_s else "behind"
        what = f"this host's clock is {skew_s:.1f} s {how} the database's, more than {MAX_SKEW_S:g} s"
        raise BoardError(503, "clock_skew", f"{what}: let both follow a time server")


def being_changed(settings: BoardSettings) -> BoardError:
    what = f"{settings.database_shown} is being restored or migrated now"
    return BoardError(503, "being_changed", what, "try again when that is done", 10.0)


def unavailable(error: DBAPIError) -> BoardError:
    """The error for a database that cannot be used now: 503, try again."""
    text = str(error.orig)
    if isinstance(error, OperationalError) and any(w in text for w in ("locked", "busy", "lock timeout")):
        return BoardError(503, "busy", "the database is busy; nothing was written", "try again", retry_after_s=1.0)
    if "full" in text:
        return BoardError(
            503, "storage_full", "the disk is full; nothing was written", "make room, then try again", 30.0
        )
    return BoardError(503, "storage", f"the database cannot be used: {text}", "see the server's log", 5.0)
