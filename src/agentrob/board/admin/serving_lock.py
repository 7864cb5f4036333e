"""Lock the database for serving or for maintenance.

One process serves a SQLite file. Several may serve one PostgreSQL database: each holds a shared advisory lock while
it serves (`Cluster`), so that nobody can restore a backup or migrate tables at the same time.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import Connection, create_engine, extract, func, select
from sqlalchemy.exc import DBAPIError

from agentrob.board.admin import local_admin
from agentrob.board.db.database import (
    SERVING_LOCK,
    being_changed,
    check_clock,
    connect_args,
    serving_lock,
    unavailable,
)
from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError, RobotBusy


@contextmanager
def serve_database(settings: BoardSettings) -> Iterator[None]:
    """Migrate the database and hold the right to serve it. Raises `BoardError` if another process prevents that."""
    if settings.shared:
        local_admin.bootstrap(settings)
        with _lock(settings, together=True):
            pass  # `Cluster` holds it while the app runs
        yield
        return
    with _on_this_host(settings):
        local_admin.bootstrap(settings, alone=True)
        yield


@contextmanager
def exclusive_access(settings: BoardSettings) -> Iterator[None]:
    """Hold the database exclusively. Raises 503 while any process serves it."""
    with _lock(settings, together=False) if settings.shared else _on_this_host(settings):
        yield


@contextmanager
def _on_this_host(settings: BoardSettings) -> Iterator[None]:
    try:
        lock = serving_lock(settings)
    except RobotBusy:
        key = settings.database_path or settings.database_shown
        what = f"another process serves {key} already; several can on PostgreSQL only (docs/forum/postgres.md)"
        raise BoardError(503, "already_served", what, "end it first") from None
    with lock:
        yield


@contextmanager
def _lock(settings: BoardSettings, together: bool) -> Iterator[None]:
    engine = create_engine(settings.database, isolation_level="AUTOCOMMIT", connect_args=connect_args(settings))
    try:
        with engine.connect() as connection:
            take = func.pg_try_advisory_lock_shared if together else func.pg_try_advisory_lock
            if not connection.execute(select(take(SERVING_LOCK))).scalar_one():
                if together:
                    raise being_changed(settings)
                what = f"{settings.database_shown} is served by other processes: end them first"
                raise BoardError(503, "already_served", what)
            if together:
                _check_clock(connection)
            yield
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()


def _check_clock(connection: Connection) -> None:
    before = time.time()
    there = float(connection.execute(select(extract("epoch", func.clock_timestamp()))).scalar_one())
    check_clock(before, there, time.time())
