"""Send the other processes that serve the same PostgreSQL database what they cannot read from its tables.

These are stops that could not be written, which go first; robots' cards, live pictures and poses; and the number of
viewers of each camera and map here. Only the newest card, picture and pose are sent. A picture stays in the database
only while it is live.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections import deque
from collections.abc import Awaitable, Callable
from datetime import timedelta
from typing import TYPE_CHECKING, Any

from agentrob.board.db.database import CHANNEL
from agentrob.board.db.records import StoredEvent, from_us
from agentrob.board.events.hub import Hub
from agentrob.board.events.presence import LIVE_FOR, PresenceTracker
from agentrob.errors import BoardError
from agentrob.model import EventKind

if TYPE_CHECKING:
    from psycopg import AsyncConnection

#: The database's clock, in SQL; ages are measured by it, because the clocks of hosts differ.
NOW_US = "(extract(epoch FROM clock_timestamp()) * 1000000)::bigint"
#: How often the number of viewers is sent, and how long it is valid.
RENEW_S, HOLDS_S = 1.0, 3.0
#: How often a picture without viewers on other processes is sent, for viewers to come.
IDLE_FRAME_S = 1.0
#: A stop that could not be sent for this long had the effect of silence (law 16).
TOO_LATE_S = 2.0
AGAIN_S = 0.25
#: The time limit of the database for a picture.
PATIENCE_S = 2.0
_SECONDS = 1_000_000
_CARD = (
    f"INSERT INTO stage (robot, card, seen_us) VALUES (%s, %s::json, {NOW_US}) "
    "ON CONFLICT (robot) DO UPDATE SET card = excluded.card, seen_us = excluded.seen_us"
)
_FRAME = (
    f"INSERT INTO stage (robot, card, seen_us, frame, shown_us) VALUES (%s, '{{}}', {NOW_US}, %s, {NOW_US}) "
    "ON CONFLICT (robot) DO UPDATE SET frame = excluded.frame, shown_us = excluded.shown_us, seen_us = excluded.seen_us"
)
_LOOKING = (
    f"INSERT INTO stage_viewers (process, robot, viewers, poses, until_us) VALUES (%s, %s, %s, %s, {NOW_US} + %s) "
    "ON CONFLICT (process, robot) DO UPDATE SET viewers = excluded.viewers, poses = excluded.poses, "
    "until_us = excluded.until_us"
)
_NOT_LIVE = f"UPDATE stage SET frame = NULL, shown_us = NULL WHERE frame IS NOT NULL AND shown_us < {NOW_US} - %s"
_GONE = f"DELETE FROM stage_viewers WHERE until_us < {NOW_US}"


_ANNOUNCED = (EventKind.ROBOT_STOP, EventKind.ROBOT_ESTOP, EventKind.ROBOT_WATCH, EventKind.ROBOT_POSES)


class ClusterMessenger:
    """Queues messages without blocking; `run` sends them."""

    def __init__(
        self, me: str, presence: PresenceTracker, connect: Callable[[], Awaitable[AsyncConnection[Any]]]
    ) -> None:
        self.me, self._presence, self._connect = me, presence, connect
        self._events: deque[tuple[float, str]] = deque(maxlen=1000)
        self._cards: set[str] = set()
        self._frames: set[str] = set()
        self._poses: set[str] = set()
        self._framed_s: dict[str, float] = {}
        self._looking: dict[str, tuple[int, int]] = {}
        self._renewed_s = 0.0
        self._wake = asyncio.Event()

    def announce(self, event: StoredEvent) -> None:
        """Send an event that could not be written."""
        self._events.append((time.monotonic(), event_to_json(event)))
        self._wake.set()

    def changed(self, robot: str, what: str) -> None:
        """Note that a robot's `card`, `frame`, `pose` or `viewers` changed here."""
        if what == "frame":
            rare = time.monotonic() - self._framed_s.get(robot, 0.0) < IDLE_FRAME_S
            if rare and not self._presence.robot(robot).elsewhere:
                return
            self._frames.add(robot)
        elif what == "card":
            self._cards.add(robot)
        elif what == "pose":
            self._poses.add(robot)
        self._wake.set()

    async def run(self) -> None:
        """Send until cancelled, even if the database fails meanwhile."""
        import psycopg

        while True:
            try:
                async with await self._connect() as connection:
                    while True:
                        async with asyncio.timeout(PATIENCE_S):
                            await self._send(connection)
                        await self._woken()
            except (psycopg.Error, OSError):
                pass  # `Cluster` reports that the database is gone
            await asyncio.sleep(AGAIN_S)

    async def _woken(self) -> None:
        try:
            async with asyncio.timeout(RENEW_S):
                await self._wake.wait()
        except TimeoutError:
            return  # time to renew the number of viewers
        self._wake.clear()

    async def _send(self, connection: AsyncConnection[Any]) -> None:
        await self._send_events(connection)
        while self._cards:
            robot = self._cards.pop()
            await connection.execute(_CARD, [robot, json.dumps(dict(self._presence.robot(robot).card))])
            await self._notify(connection, f"card {robot}")
            await self._send_events(connection)
        while self._frames:
            robot = self._frames.pop()
            self._framed_s[robot] = time.monotonic()
            await connection.execute(_FRAME, [robot, self._presence.robot(robot).frame])
            await self._notify(connection, f"frame {robot}")
            await self._send_events(connection)
        while self._poses:
            robot = self._poses.pop()
            await self._notify(connection, f"pose {robot} {self._presence.poses.shared(robot)}")
            await self._send_events(connection)
        await self._send_viewers(connection)

    async def _send_events(self, connection: AsyncConnection[Any]) -> None:
        while self._events:
            at_s, words = self._events[0]
            if time.monotonic() - at_s < TOO_LATE_S:
                await self._notify(connection, f"event {words}")
            self._events.popleft()

    async def _send_viewers(self, connection: AsyncConnection[Any]) -> None:
        """Share the number of viewers repeatedly, and once more when it becomes zero."""
        looking = {robot.name: (robot.viewers, 0) for robot in self._presence.robots() if robot.viewers}
        for watched in self._presence.poses.robots():
            if watched.viewers:
                looking[watched.name] = (looking.get(watched.name, (0, 0))[0], watched.viewers)
        if looking == self._looking and time.monotonic() - self._renewed_s < RENEW_S:
            return
        for robot in looking.keys() | self._looking.keys():
            holds_us = int(HOLDS_S * _SECONDS) if robot in looking else -1
            await connection.execute(_LOOKING, [self.me, robot, *looking.get(robot, (0, 0)), holds_us])
        if looking != self._looking:
            await self._notify(connection, "viewers")
        self._looking, self._renewed_s = looking, time.monotonic()
        await connection.execute(_NOT_LIVE, [int(LIVE_FOR / timedelta(microseconds=1))])
        await connection.execute(_GONE)

    async def _notify(self, connection: AsyncConnection[Any], said: str) -> None:
        await connection.execute("SELECT pg_notify(%s, %s)", [CHANNEL, f"{self.me} {said}"])


# -------------------------------------------------------------------- serialization
def event_to_json(event: StoredEvent) -> str:
    """Serialize a robot event, without its id: an unwritten event has none."""
    at_us = round(event.at.timestamp() * _SECONDS)
    return json.dumps([str(event.kind), at_us, event.robot, event.account.name if event.account else None])


def event_from_json(words: str, hub: Hub) -> StoredEvent:
    """Parse an event from another process. Raises `ValueError` for kinds that are never sent."""
    kind, at_us, robot, name = json.loads(words)
    if kind not in _ANNOUNCED or not isinstance(robot, str):
        raise ValueError("no event that is announced")
    account = None
    if name is not None and hub.reader is not None:
        try:
            account = hub.reader.account(str(name))
        except BoardError:  # the account is unknown, but the press still counts
            account = None
    return StoredEvent(hub.last_id, EventKind(kind), from_us(at_us), robot=robot, account=account)
