"""Waiting for what happens on a forum: by its event stream where it has one, else by asking as often as it allows.

A client that asks again and again where it left off keeps one open stream; who comes with another place gets another.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from datetime import datetime

from agentrob.errors import ForumUnreachable
from agentrob.forums.protocol import Event, Forum
from agentrob.model import EventKind

#: Streams that wait for their reader to come back; beyond, the oldest are closed.
MAX_OPEN = 16
#: Of a forum that can only be polled, when it names no interval itself.
POLL_S = 1.0


class EventTail:
    """The events of one forum as one account sees them."""

    def __init__(self, forum: Forum) -> None:
        self._forum = forum
        self._open: dict[tuple[str, float], _OpenStream] = {}

    async def wait(self, after: str, heartbeat_s: float) -> tuple[tuple[Event, ...], datetime | None]:
        """Events after one as soon as there are any; else, at the forum's heartbeat, nothing and the forum's clock."""
        tail = self._open.pop((after, heartbeat_s), None) or _OpenStream(self._forum, after, heartbeat_s)
        try:
            events, at = await tail.next()
        except BaseException:
            await tail.close()
            raise
        last = events[-1].id if events else after
        if old := self._open.pop((last, heartbeat_s), None):
            await old.close()
        self._open[last, heartbeat_s] = tail
        while len(self._open) > MAX_OPEN:
            await self._open.pop(next(iter(self._open))).close()
        return events, at

    async def close(self) -> None:
        while self._open:
            await self._open.popitem()[1].close()


class _OpenStream:
    """A stream that is read in bites."""

    def __init__(self, forum: Forum, after: str, heartbeat_s: float) -> None:
        self._events: AsyncIterator[Event] = follow(forum, after, heartbeat_s)

    async def next(self) -> tuple[tuple[Event, ...], datetime | None]:
        try:
            event = await anext(self._events)
        except StopAsyncIteration:
            raise ForumUnreachable("the forum ended the event stream") from None
        return ((), event.at) if event.kind is EventKind.HEARTBEAT else ((event,), None)

    async def close(self) -> None:
        with contextlib.suppress(Exception):
            await self._events.aclose()  # type: ignore[attr-defined]


async def follow(forum: Forum, after: str, heartbeat_s: float) -> AsyncIterator[Event]:
    """The events of any forum, live or polled, with heartbeats that prove that it still answers."""
    if forum.live:
        stream = forum.stream(after, heartbeat_s)
        try:
            async for event in stream:
                yield event
        finally:
            await stream.aclose()  # type: ignore[attr-defined]
        return
    pause_s = max(forum.fastest_poll_s, min(POLL_S, heartbeat_s))
    while True:
        events = await forum.changes(after)
        for event in events:
            after = event.id
            yield event
        if not events:
            await asyncio.sleep(pause_s)
            _, at = await forum.now()
            yield Event("", EventKind.HEARTBEAT, at)
