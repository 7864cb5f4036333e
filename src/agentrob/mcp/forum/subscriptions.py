"""Pushes updates of resources to subscribed clients, in both eras of the protocol, from one event stream per identity.

Clients of 2026-07-28 listen on a stream (`subscriptions/listen`); older ones subscribe to addresses
(`resources/subscribe`).
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import structlog
from mcp.server.context import ServerRequestContext
from mcp.server.subscriptions import InMemorySubscriptionBus, ListenHandler, ResourceUpdated

from agentrob.errors import ForumError, ForumNotFound
from agentrob.forums.protocol import Event
from agentrob.mcp.forum.event_tail import follow

if TYPE_CHECKING:
    from mcp.server.session import ServerSession

    from agentrob.mcp.forum.identity import Identity

log = structlog.get_logger(__name__)
#: Between two attempts to reach a forum that does not answer; doubles from the first to the longest.
FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.5, 15.0
MAX_SUBSCRIPTIONS = 200
#: Sessions (one for each client before 2026) that an identity may have; beyond, the oldest is dropped.
MAX_SESSIONS = 64
SESSION_HEADER = "mcp-session-id"


@dataclass
class _Subscriber:
    """A client before 2026. `session` is that of its latest request; each reaches the same connection."""

    session: ServerSession
    uris: set[str] = field(default_factory=set)


class Subscriptions:
    """The subscriptions of one identity. The forum's events are followed only while a client is subscribed."""

    def __init__(self, identity: Identity) -> None:
        self._identity = identity
        self._bus = InMemorySubscriptionBus()
        self.listen = ListenHandler(self._bus)
        self._subscribers: dict[str, _Subscriber] = {}  # by session id
        self._listening = 0
        self._following: asyncio.Task[None] | None = None

    # ---------------------------------------------------------------- who is subscribed
    @asynccontextmanager
    async def held(self) -> AsyncIterator[None]:
        """Follow the forum's events while this is open."""
        self._listening += 1
        self._start()
        try:
            yield
        finally:
            self._listening -= 1
            self._stop_if_unused()

    def subscribe(self, ctx: ServerRequestContext[Any, Any], uri: str) -> bool:
        """Push updates of an address to a client before 2026; False when it has too many subscriptions."""
        key = _session_id(ctx)
        subscriber = self._subscribers.pop(key, None) or _Subscriber(ctx.session)
        self._subscribers[key] = subscriber  # the newest is last
        if len(subscriber.uris) >= MAX_SUBSCRIPTIONS and uri not in subscriber.uris:
            return False
        subscriber.session = ctx.session
        subscriber.uris.add(uri)
        while len(self._subscribers) > MAX_SESSIONS:
            del self._subscribers[next(iter(self._subscribers))]
        self._start()
        return True

    def unsubscribe(self, ctx: ServerRequestContext[Any, Any], uri: str) -> None:
        key = _session_id(ctx)
        if (subscriber := self._subscribers.get(key)) is not None:
            subscriber.uris.discard(uri)
            if not subscriber.uris:
                self.drop(key)

    def drop(self, session_id: str) -> None:
        """Forget a session that has ended."""
        self._subscribers.pop(session_id, None)
        self._stop_if_unused()

    async def close(self) -> None:
        self.listen.close()
        if self._following is not None:
            self._following.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._following

    # ---------------------------------------------------------------- following the forum
    def _start(self) -> None:
        if self._following is None or self._following.done():
            self._following = asyncio.create_task(self._follow())

    def _stop_if_unused(self) -> None:
        if self._following and not self._listening and not self._subscribers:
            self._following.cancel()

    async def _follow(self) -> None:
        """Follow the forum's events from now on; after an interruption, from the last event, so that none is missed."""
        pause_s, after = FIRST_PAUSE_S, ""
        while True:
            try:
                after = after or (await self._identity.forum.now())[0]
                async for event in follow(self._identity.forum, after, 5.0):
                    pause_s = FIRST_PAUSE_S
                    if event.id:
                        after = event.id
                        await self._publish(event)
            except ForumNotFound:  # the forum was replaced: start at its newest event
                after = ""
            except ForumError as e:
                log.warning("mcp.event_stream_broken", account=self._identity.name, error=str(e)[:200])
            await asyncio.sleep(pause_s)
            pause_s = min(2 * pause_s, LONGEST_PAUSE_S)

    async def _publish(self, event: Event) -> None:
        if event.post is None:
            return
        post = event.post
        for uri in (f"forum://topic/{post.topic_id}", f"forum://board/{post.board_id}", f"forum://post/{post.id}"):
            await self._updated(uri)

    async def _updated(self, uri: str) -> None:
        await self._bus.publish(ResourceUpdated(uri=uri))
        for key, subscriber in [(k, s) for k, s in self._subscribers.items() if uri in s.uris]:
            try:
                async with asyncio.timeout(5):
                    await subscriber.session.send_resource_updated(uri)
            except Exception as e:  # a client that is gone, or that stopped reading
                log.info("mcp.subscriber_lost", error=type(e).__name__)
                self._subscribers.pop(key, None)


def _session_id(ctx: ServerRequestContext[Any, Any]) -> str:
    """The HTTP session of a request; empty over stdio, where there is one client."""
    return str(ctx.request.headers.get(SESSION_HEADER, "")) if ctx.request is not None else ""
