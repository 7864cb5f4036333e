"""Stay in sync with the other processes that serve the same PostgreSQL database, and know whether the link works.

One connection listens for notifications: every commit, robots' cards and pictures shown by other processes, and stops
that could not be written (`ClusterMessenger`). Every `PROOF_S` a query proves that the connection works; while it
does not, the hub sends no heartbeats (law 16). The connection holds two advisory locks that PostgreSQL frees when the
process dies: the shared serving lock, and, in one process, the lock for duties that only one process performs.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import structlog

from agentrob.board.db.database import CHANNEL, LEADING_LOCK, SERVING_LOCK, being_changed, check_clock, connection_words
from agentrob.board.events.cluster_messages import NOW_US, ClusterMessenger, event_from_json
from agentrob.board.events.hub import Hub
from agentrob.board.events.presence import PresenceTracker
from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError

if TYPE_CHECKING:
    from psycopg import AsyncConnection

#: The interval of proofs that other processes are heard, when they send nothing.
PROOF_S = 0.25
#: A connection that does not answer for this long is replaced; heartbeats have paused before.
PATIENCE_S = 2.0
CONNECT_S = 5.0
AGAIN_S = 0.25
#: The database ends a connection that is silent for this long, because its process hangs or its host is lost; this
#: frees its locks for other processes.
GONE_S = 5
_PROOF = (
    "SELECT (SELECT coalesce(max(id), 0) FROM events), extract(epoch FROM clock_timestamp())::float8, "
    f"CASE WHEN %(leads)s THEN true ELSE pg_try_advisory_lock({LEADING_LOCK}) END, "
    "(SELECT coalesce(json_object_agg(robot, json_build_array(n, m)), '{}') FROM "
    "(SELECT robot, sum(viewers)::int AS n, sum(poses)::int AS m FROM stage_viewers "
    f"WHERE process <> %(me)s AND until_us > {NOW_US} GROUP BY robot) AS looking)"
)
_CARDS = f"SELECT robot, card, {NOW_US} - seen_us FROM stage"
_FRAMES = f"SELECT robot, frame, {NOW_US} - shown_us FROM stage WHERE frame IS NOT NULL"

log = structlog.get_logger(__name__)


class Cluster:
    """This process's link to the others. `duties` runs in one process only; its argument is whether another process may
    have run it before."""

    def __init__(
        self,
        settings: BoardSettings,
        me: str,
        hub: Hub,
        presence: PresenceTracker,
        duties: Callable[[bool], Coroutine[Any, Any, None]],
    ) -> None:
        self.settings, self.me, self._hub, self._presence, self._duties = settings, me, hub, presence, duties
        self._words = connection_words(settings)
        self._connection: AsyncConnection[Any] | None = None
        self._duty: asyncio.Task[None] | None = None
        self._asked_to_lead = False
        self._proven_s = 0.0
        self._cut_off = False
        self._messenger = ClusterMessenger(me, presence, self._connect)
        hub.announce_elsewhere = self._messenger.announce
        presence.changed = presence.poses.changed = self._messenger.changed

    @property
    def cut_off(self) -> bool:
        """Whether the database is unreachable or must not be served."""
        return self._cut_off

    @property
    def leads(self) -> bool:
        """Whether this process currently holds the leader lock."""
        return self._duty is not None

    async def begin(self) -> None:
        """Connect. Raises `BoardError` if this process must not serve the database, or cannot."""
        import psycopg

        try:
            self._connection = await self._listening()
        except (psycopg.Error, OSError) as e:  # TimeoutError is one
            raise BoardError(503, "storage", f"the database cannot be used: {e or 'no answer'}") from e

    async def run(self) -> None:
        """Listen and send until cancelled; reconnects after failures."""
        telling = asyncio.create_task(self._messenger.run())
        try:
            await self._listen()
        finally:
            telling.cancel()
            await asyncio.gather(telling, return_exceptions=True)

    # ---------------------------------------------------------------- connections
    async def _connect(self) -> AsyncConnection[Any]:
        import psycopg

        async with asyncio.timeout(CONNECT_S):
            return await psycopg.AsyncConnection.connect(**self._words, autocommit=True)

    async def _listening(self) -> AsyncConnection[Any]:
        connection = await self._connect()
        try:
            async with asyncio.timeout(CONNECT_S):
                await connection.execute(f"SET idle_session_timeout = '{GONE_S}s'")
                await connection.execute(f"LISTEN {CHANNEL}")
                free = await connection.execute(f"SELECT pg_try_advisory_lock_shared({SERVING_LOCK})")
                if not (await free.fetchone() or [False])[0]:
                    raise being_changed(self.settings)
                await self._refresh(connection)
            await self._prove(connection)
        except BaseException:
            await connection.close()
            raise
        return connection

    async def _listen(self) -> None:
        import psycopg

        while True:
            try:
                if self._connection is None:
                    self._connection = await self._again()
                await self._follow(self._connection)
            except (psycopg.Error, OSError, BoardError) as e:
                if not self._cut_off:
                    log.warning("board.not_heard", error=str(e) or "no answer from the database")
            finally:
                await self._release()
            await asyncio.sleep(AGAIN_S)

    async def _again(self) -> AsyncConnection[Any]:
        """Open another connection."""
        try:
            connection = await self._listening()
        except Exception as e:
            if not self._cut_off:
                log.error("board.cut_off", error=str(e) or "no answer from the database")
            self._cut_off = True
            raise
        if self._cut_off:
            log.info("board.heard_again")
        self._cut_off = False
        return connection

    async def _release(self) -> None:
        """End the duties, and then release their lock."""
        duty, self._duty = self._duty, None
        if duty is not None:
            duty.cancel()
            await asyncio.gather(duty, return_exceptions=True)
        connection, self._connection = self._connection, None
        if connection is not None:
            with suppress(Exception):
                await connection.close()

    # ---------------------------------------------------------------- hearing
    async def _follow(self, connection: AsyncConnection[Any]) -> None:
        while True:
            heard = [notice.payload async for notice in connection.notifies(timeout=PROOF_S, stop_after=1)]
            parts = (payload.partition(" ") for payload in heard)
            others = dict.fromkeys(what for by, _, what in parts if by != self.me)
            if others or time.monotonic() - self._proven_s >= PROOF_S:  # our own commits prove nothing
                await self._prove(connection)
            for what in others:
                await self._receive(connection, what)

    async def _prove(self, connection: AsyncConnection[Any]) -> None:
        """Check for new events, for clock skew, and that some process runs the duties."""
        before = time.time()
        async with asyncio.timeout(PATIENCE_S):
            asked = await connection.execute(_PROOF, {"leads": self.leads, "me": self.me})
            newest, clock, leads, viewers = await asked.fetchone() or (0, before, False, {})
        check_clock(before, clock, time.time())
        self._proven_s = time.monotonic()
        self._presence.receive_viewers({robot: cameras for robot, (cameras, _) in viewers.items()})
        self._presence.poses.receive_viewers({robot: maps for robot, (_, maps) in viewers.items()})
        self._hub.proven(newest)
        if leads and self._duty is None:
            log.info("board.has_the_duties", taken_over=self._asked_to_lead)
            self._duty = asyncio.create_task(self._duties(self._asked_to_lead))
        self._asked_to_lead = True

    async def _receive(self, connection: AsyncConnection[Any], payload: str) -> None:
        what, _, more = payload.partition(" ")
        try:
            if what == "card" or (what == "frame" and self._presence.wants(more)):
                async with asyncio.timeout(PATIENCE_S):
                    await self._refresh(connection, what, more)
            elif what == "pose":
                robot, _, frame = more.partition(" ")
                self._presence.poses.receive(robot, frame)
            elif what == "event":
                self._hub.receive_unwritten(event_from_json(more, self._hub))
        except (ValueError, KeyError, TypeError) as e:
            log.warning("board.not_understood", payload=payload[:200], error=str(e))

    async def _refresh(self, connection: AsyncConnection[Any], what: str = "", robot: str = "") -> None:
        """Load the state that other processes shared, of one robot or of all."""
        which = " WHERE robot = %s" if robot else ""
        words = [robot] if robot else []
        if what != "frame":
            async for name, card, age_us in await connection.execute(_CARDS + which, words):
                self._presence.receive_card(name, card, age_us / 1_000_000)
        if what != "card":
            async for name, frame, age_us in await connection.execute(_FRAMES + which.replace("WHERE", "AND"), words):
                self._presence.receive_frame(name, frame, age_us / 1_000_000)
