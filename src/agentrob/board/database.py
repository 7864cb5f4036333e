"""Opening the forum's database: SQLite in WAL by default, anything else that SQLAlchemy speaks by URL; migrations."""

from __future__ import annotations

import sqlite3
import time
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.exc import DBAPIError, OperationalError

from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError

#: How long is waited for somebody who makes the same database.
LOCKED_S = 5.0


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


def migrate(settings: BoardSettings) -> None:
    """Bring the tables to this version's shape; does nothing when they are. Two processes may try at once."""
    from alembic import command
    from alembic.config import Config

    engine = open_engine(settings, writes=True)
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    try:
        with engine.begin() as connection:
            config.attributes["connection"] = connection
            command.upgrade(config, "head")
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()


def unavailable(error: DBAPIError) -> BoardError:
    """What a database that cannot be used now means for whoever asked: 503, try again."""
    text = str(error.orig)
    if isinstance(error, OperationalError) and ("locked" in text or "busy" in text):
        return BoardError(503, "busy", "the database is busy; nothing was written", "try again", retry_after_s=1.0)
    if "full" in text:
        return BoardError(
            503, "storage_full", "the disk is full; nothing was written", "make room, then try again", 30.0
        )
    return BoardError(503, "storage", f"the database cannot be used: {text}", "see the server's log", 5.0)
