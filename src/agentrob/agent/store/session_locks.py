"""Robots that one worker holds on PostgreSQL: session locks on one connection of their own.

The server frees them when the connection ends, and ends it when the worker's process or host has been silent for
`SILENT_S`. The worker asks it every `BEAT_S`; without an answer within `ANSWER_S` all its robots are lost, which is
before the server gives them to others.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import socket
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import structlog
from sqlalchemy import URL

from agentrob.agent.store import versions
from agentrob.agent.store.transactions import RobotLock
from agentrob.errors import JournalError, JournalHeld
from agentrob.model import FencingToken

if TYPE_CHECKING:
    from psycopg import AsyncConnection

BEAT_S, ANSWER_S, SILENT_S = 2.0, 2.5, 8
#: libpq's options by which a client notices within seconds that the server is gone.
_CLIENT = {
    "connect_timeout": "3", "keepalives_idle": "2", "keepalives_interval": "1", "keepalives_count": "3",
    "tcp_user_timeout": "3000",
}  # fmt: skip
#: The server's settings for each session: it notices within `SILENT_S` that a worker is gone, also in a transaction.
_SERVER = {
    "tcp_keepalives_idle": "3", "tcp_keepalives_interval": "2", "tcp_keepalives_count": "2",
    "tcp_user_timeout": f"{SILENT_S}s", "idle_in_transaction_session_timeout": "5s", "lock_timeout": "8s",
}  # fmt: skip
#: The number grows, and is never one that was given before, even if the database is restored from a backup.
_NEXT = "(extract(epoch FROM clock_timestamp()) * 1000)::bigint"
#: Lock a robot and give it a number, in one statement so that nobody takes it in between. No row: another holds it.
_TAKE = (
    "WITH lock AS MATERIALIZED (SELECT pg_try_advisory_lock(%s) AS taken) "
    f"INSERT INTO holder AS h (robot, number) SELECT %s, {_NEXT} FROM lock WHERE taken "
    f"ON CONFLICT (robot) DO UPDATE SET number = greatest(h.number + 1, {_NEXT}) RETURNING number"
)
#: The advisory locks that anybody holds in this database, each with the number that was given for it.
_HELD = """
SELECT coalesce(array_agg((classid::bigint << 32) | objid::bigint), '{}') FROM pg_locks
WHERE locktype = 'advisory' AND objsubid = 1
AND database = (SELECT oid FROM pg_database WHERE datname = current_database())
"""
_USE = "SELECT pg_advisory_lock_shared(%s, %s)"
_UNLOCK = "SELECT pg_advisory_unlock(%s)"
log = structlog.get_logger()


def connect_options(url: URL) -> dict[str, str]:
    """Arguments for each connection to this database, beside those that the URL gives."""
    server = " ".join(f"-c {name}={value}" for name, value in _SERVER.items())
    given = str(url.query.get("options", ""))
    return {name: value for name, value in _CLIENT.items() if name not in url.query} | {"options": f"{server} {given}"}


class SessionLocks:
    """Take robots with `take`, until `lost`. One object for one connection. `store` is the id of the database, by which
    drivers know whose fencing numbers they compare."""

    def __init__(self, connection: AsyncConnection[Any]) -> None:
        self._connection, self.store = connection, ""
        self._held: dict[str, RobotLock | None] = {}
        #: Queries run one at a time, so that `ANSWER_S` does not include waiting for the connection.
        self._turn = asyncio.Lock()
        self.lost = False
        self._beating = asyncio.create_task(self._beat())

    @classmethod
    async def connect(cls, url: URL) -> SessionLocks:
        """Connect, and say which version of the tables this worker uses. Raises `JournalError`."""
        import psycopg

        arguments = url.get_dialect()().create_connect_args(url)[1]
        words = {name: value for name, value in arguments.items() if name != "context"} | connect_options(url)
        try:
            connection = await psycopg.AsyncConnection.connect(**words, autocommit=True)
            await connection.execute(f"SET idle_session_timeout = '{SILENT_S}s'; SET lock_timeout = '1s'")
            await connection.execute(_USE, (versions.VERSION_LOCK, versions.VERSION))
        except (psycopg.Error, OSError) as e:
            raise JournalError(f"the journal's database cannot be reached: {e}") from None
        return cls(connection)

    async def take(self, robot: str) -> RobotLock:
        """Hold a robot, under a larger number than any holder before. Raises `JournalHeld`, `JournalError`."""
        if robot in self._held:
            raise JournalHeld(f"this process already runs an agent for {robot}")
        self._held[robot] = None
        try:
            number = await self._ask(_TAKE, _key(robot), robot)
        except BaseException:
            await asyncio.shield(self.release(robot))
            raise
        if number is None:
            del self._held[robot]
            raise JournalHeld(f"another worker already runs an agent for {robot}")
        self._held[robot] = lock = RobotLock(robot, FencingToken(self.store, number))
        return lock

    async def free(self, robots: Sequence[str]) -> frozenset[str]:
        """Those that nobody holds now. Raises `JournalError`."""
        held = set(await self._ask(_HELD))
        return frozenset(robot for robot in robots if _key(robot) not in held)

    async def release(self, robot: str) -> None:
        """Let others take a robot."""
        with contextlib.suppress(JournalError):
            await self._ask(_UNLOCK, _key(robot))
        self._held.pop(robot, None)

    async def close(self) -> None:
        """End the connection, and with it all locks."""
        self._beating.cancel()
        await asyncio.gather(self._beating, return_exceptions=True)
        self._lose()
        await self._connection.close()

    async def _beat(self) -> None:
        try:
            while True:
                await asyncio.sleep(BEAT_S)
                await self._ask("SELECT 1")
        except JournalError as e:
            self._lose(str(e))

    async def _ask(self, query: str, *values: object) -> Any:
        """The first value of the answer. All robots are lost if there is none in time."""
        async with self._turn:
            return await self._ask_now(query, *values)

    async def _ask_now(self, query: str, *values: object) -> Any:
        import psycopg

        if self.lost:
            raise JournalError("the connection to the journal's database is lost")
        asking = asyncio.ensure_future(self._connection.execute(query, values or None))
        done, _ = await asyncio.wait({asking}, timeout=ANSWER_S)
        if not done:  # this process may have been busy itself, and an answer be there
            done, _ = await asyncio.wait({asking}, timeout=0.2)
        if not done:
            asking.add_done_callback(lambda task: task.cancelled() or task.exception())
            self._lose(f"no answer within {ANSWER_S:g} s")
            raise JournalError("the journal's database does not answer")
        try:
            row = await asking.result().fetchone()
        except psycopg.errors.LockNotAvailable:  # a transaction of the last holder is not ended yet
            raise JournalHeld("another worker's transaction is not ended yet") from None
        except (psycopg.Error, OSError) as e:
            if self._connection.closed:
                self._lose(str(e))
            raise JournalError(f"the journal's database cannot be used: {e}") from None
        return row[0] if row else None

    def _lose(self, error: str = "") -> None:
        if self.lost:
            return
        self.lost = True
        held = [lock for lock in self._held.values() if lock is not None]
        for lock in held:
            lock.lost.set()
        if held and error:
            log.error("robots lost", robots=[lock.robot for lock in held], error=error)
        if not self._connection.closed:  # a server that does not answer now must not keep the locks later
            with contextlib.suppress(OSError), socket.socket(fileno=os.dup(self._connection.fileno())) as link:
                link.shutdown(socket.SHUT_RDWR)


def _key(robot: str) -> int:
    digest = hashlib.sha256(f"agentrob journal {robot}".encode()).digest()
    return int.from_bytes(digest[:8], signed=True)
