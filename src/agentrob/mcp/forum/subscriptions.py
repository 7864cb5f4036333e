"""Pushes updates of resources to whoever subscribed, in both eras of the protocol, from one watch of the forum each.

Clients of 2026 listen on a stream (`subscriptions/listen`), those before subscribe to addresses
(`resources/subscribe`).
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import structlog

from agentrob.errors import ForumError, ForumNotFound
from agentrob.forums.protocol import Event
from agentrob.mcp.forum.event_tail import follow

if TYPE_CHECKING:
    from mcp.server.session import ServerSession

    from agentrob.mcp.forum.identity import Identity

log = structlog.get_logger(__name__)
#: Between two tries to reach a forum that does not answer, doubling up to the second figure.
FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.5, 15.0
MAX_SUBSCRIPTIONS = 200


class Watch:
    """The watch of one identity; it runs only while somebody listens."""

    def __init__(self, identity: Identity) -> None:
        from mcp.server.subscriptions import InMemorySubscriptionBus, ListenHandler

        self._identity = identity
        self._bus = InMemorySubscriptionBus()
        self.listen = ListenHandler(self._bus)
        # By connection: each message of a client comes with a session object of its own.
        self._legacy: WeakKeyDictionary[Any, set[str]] = WeakKeyDictionary()
        self._reasons: Counter[str] = Counter()
        self._running: asyncio.Task[None] | None = None

    # ---------------------------------------------------------------- who listens
    @asynccontextmanager
    async def held(self) -> AsyncIterator[None]:
        """The forum is watched as long as this is open."""
        self._reasons["listen"] += 1
        self._start()
        try:
            yield
        finally:
            self._reasons["listen"] -= 1
            self._maybe_end()

    def subscribe(self, session: ServerSession, uri: str) -> bool:
        """Push updates of an address to a client of before 2026; False when it has too many."""
        wanted = self._legacy.setdefault(session._connection, set())
        if len(wanted) >= MAX_SUBSCRIPTIONS and uri not in wanted:
            return False
        wanted.add(uri)
        self._start()
        return True

    def unsubscribe(self, session: ServerSession, uri: str) -> None:
        self._legacy.get(session._connection, set()).discard(uri)
        self._maybe_end()

    async def close(self) -> None:
        self.listen.close()
        if self._running is not None:
            self._running.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._running

    # ---------------------------------------------------------------- the watch
    def _start(self) -> None:
        if self._running is None or self._running.done():
            self._running = asyncio.create_task(self._run())

    def _maybe_end(self) -> None:
        if self._running and not self._reasons["listen"] and not any(self._legacy.values()):
            self._running.cancel()

    async def _run(self) -> None:
        """Follows the forum from now on; after a break from where it was, so that nothing is missed."""
        pause_s, after = FIRST_PAUSE_S, ""
        while True:
            try:
                after = after or (await self._identity.forum.now())[0]
                async for event in follow(self._identity.forum, after, 5.0):
                    pause_s = FIRST_PAUSE_S
                    if event.id:
                        after = event.id
                        await self._tell(event)
            except ForumNotFound:  # another forum by now: from here on
                after = ""
            except ForumError as e:
                log.warning("mcp.watch_broken", account=self._identity.name, error=str(e)[:200])
            await asyncio.sleep(pause_s)
            pause_s = min(2 * pause_s, LONGEST_PAUSE_S)

    async def _tell(self, event: Event) -> None:
        if event.post is None:
            return
        post = event.post
        for uri in (f"forum://topic/{post.topic_id}", f"forum://board/{post.board_id}", f"forum://post/{post.id}"):
            await self._updated(uri)

    async def _updated(self, uri: str) -> None:
        from mcp.server.subscriptions import ResourceUpdated

        await self._bus.publish(ResourceUpdated(uri=uri))
        for connection in [c for c, wanted in self._legacy.items() if uri in wanted]:
            try:
                async with asyncio.timeout(5):
                    await connection.send_resource_updated(uri)
            except Exception as e:  # a client that is gone, or that stopped reading
                log.info("mcp.subscriber_lost", error=type(e).__name__)
                self._legacy.pop(connection, None)
