"""Waits for events of a forum: by its event stream if it has one, else by polling as often as it allows.

A client that asks again from where it left off continues its open stream; from another event it gets a new one.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from datetime import datetime

from agentrob.errors import ForumUnreachable
from agentrob.forums.protocol import Event, Forum
from agentrob.model import EventKind

#: Open streams whose client has not asked again yet; beyond, the oldest are closed.
MAX_OPEN = 16
#: Polling interval for a forum that names none.
POLL_S = 1.0


class EventTail:
    """The events of one forum as one account sees them."""

    def __init__(self, forum: Forum) -> None:
        self._forum = forum
        self._open: dict[tuple[str, float], _OpenStream] = {}

    async def wait(self, after: str, heartbeat_s: float) -> tuple[tuple[Event, ...], datetime | None]:
        """The events after `after` as soon as there are any; at a heartbeat, no events and the forum's time."""
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
    """An open event stream that is read one event at a time."""

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
    """The events of a forum, streamed or polled, with heartbeats while it answers."""
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
