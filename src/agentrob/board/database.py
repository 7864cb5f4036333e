"""Opening the forum's database: SQLite in WAL by default, anything else that SQLAlchemy speaks by URL; migrations."""

from __future__ import annotations

import sqlite3
import time
from functools import partial
from pathlib import Path
from typing import Any

from alembic.migration import MigrationContext
from sqlalchemy import Connection, Engine, create_engine, event, func, select
from sqlalchemy.exc import DBAPIError, OperationalError

from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError

#: How long is waited for somebody who makes the same database.
LOCKED_S = 5.0
#: Any numbers, the same for all who migrate and who write.
_MIGRATION_LOCK, _WRITER_LOCK = 4_107_001, 4_107_002


def open_engine(settings: BoardSettings, *, writes: bool) -> Engine:
    """An engine for the one writer (each transaction takes the write lock at once) or for reading.

    Reading goes statement by statement, so that every read sees the newest commit.
    """
    if path := settings.database_path:
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as e:
            raise BoardError(503, "storage", f"cannot make the folder {path.parent}: {e.strerror}") from None
    engine = create_engine(settings.database, connect_args=_connect_args(settings))
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _set_up_sqlite)
        if writes:
            event.listen(engine, "begin", _begin_immediate)
    elif writes and engine.dialect.name == "postgresql":
        event.listen(engine, "begin", partial(_one_writer, settings.busy_timeout_s))
    return engine if writes else engine.execution_options(isolation_level="AUTOCOMMIT")


def _connect_args(settings: BoardSettings) -> dict[str, Any]:
    if not settings.database.startswith("sqlite"):
        return {}
    return {"check_same_thread": False, "timeout": settings.busy_timeout_s}


def _set_up_sqlite(connection: Any, _record: object) -> None:
    connection.isolation_level = None  # transactions are begun by `_begin_immediate`, not by the driver
    # In WAL, NORMAL keeps the database whole in every case; only a power failure can lose the last commits. What must
    # not happen twice is held by the robot's own journal besides.
    _patiently(connection, "PRAGMA journal_mode=WAL")
    for pragma in ("synchronous=NORMAL", "foreign_keys=ON", "cache_size=-16000"):
        connection.execute("PRAGMA " + pragma)


def _patiently(connection: Any, statement: str) -> None:
    """Run what SQLite does not wait for by itself, as when two make a database at once."""
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


def _one_writer(patience_s: float, connection: Connection) -> None:
    """As in SQLite: who writes waits for who writes. So events become visible in the order of their ids, and nobody
    who follows them misses one that was committed late."""
    connection.exec_driver_sql(f"SET LOCAL lock_timeout = '{int(patience_s * 1000)}ms'")
    connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_WRITER_LOCK})")


def migrate(settings: BoardSettings, to: str = "head") -> None:
    """Bring the tables to this version's shape; does nothing when they are. Two processes may try at once.

    `to` is a revision, also an earlier one, for who goes back to an earlier version of AgentRob.
    """
    from alembic import command
    from alembic.config import Config
    from alembic.script import ScriptDirectory
    from alembic.util import CommandError

    engine = open_engine(settings, writes=True)
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    try:
        with engine.begin() as connection:
            if engine.dialect.name == "postgresql":
                connection.execute(select(func.pg_advisory_xact_lock(_MIGRATION_LOCK)))
            config.attributes["connection"] = connection
            if to == "head":
                command.upgrade(config, "head")
            else:
                known = [r.revision for r in ScriptDirectory.from_config(config).walk_revisions()]
                if to not in known:
                    raise BoardError(404, "no_such_revision", f"there is no revision {to!r}", ", ".join(known))
                current = MigrationContext.configure(connection).get_current_revision()
                down = current in known and known.index(to) >= known.index(str(current))
                (command.downgrade if down else command.upgrade)(config, to)
    except CommandError as e:
        raise BoardError(409, "other_version", f"the tables cannot be brought there: {e}", "update AgentRob") from e
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()


def unavailable(error: DBAPIError) -> BoardError:
    """What a database that cannot be used now means for whoever asked: 503, try again."""
    text = str(error.orig)
    if isinstance(error, OperationalError) and any(w in text for w in ("locked", "busy", "lock timeout")):
        return BoardError(503, "busy", "the database is busy; nothing was written", "try again", retry_after_s=1.0)
    if "full" in text:
        return BoardError(
            503, "storage_full", "the disk is full; nothing was written", "make room, then try again", 30.0
        )
    return BoardError(503, "storage", f"the database cannot be used: {text}", "see the server's log", 5.0)
