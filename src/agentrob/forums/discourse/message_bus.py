"""Discourse's message bus: a long poll that delivers messages at once, and short polls that prove it works."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Iterable
from typing import Any
from uuid import uuid4

from agentrob.forums.discourse.events import ChangeTracker
from agentrob.forums.discourse.http import DiscourseClient
from agentrob.forums.protocol import Event

_LATEST = "/latest"
_BETWEEN = "\r\n|\r\n"
_AT_ONCE = 100


class MessageBusClient:
    """The position in each channel, and whether there was a message. Messages only trigger a look."""

    def __init__(self, client: DiscourseClient) -> None:
        self.rang = asyncio.Event()
        self._client = client
        self._client_id = uuid4().hex
        self._places: dict[str, int] = {_LATEST: -1}
        self._hints: set[int] = set()
        self._number = 0

    def listen_to(self, topics: Iterable[str]) -> bool:
        """Subscribe to these threads too, since edits and deletions are sent only there; return whether any is new."""
        new = {f"/topic/{t}": -1 for t in topics if f"/topic/{t}" not in self._places}
        self._places |= new
        for channel in [c for c in self._places if c != _LATEST][: max(0, len(self._places) - 101)]:
            del self._places[channel]
        return bool(new)

    def hints(self) -> set[int]:
        """Return the posts named by messages since the last call."""
        hints, self._hints = self._hints, set()
        return hints

    async def probe(self) -> None:
        """Poll without waiting (`dlp=t`); the answer proves that the channel works."""
        self._take(await self._client.ask("POST", f"{self._path}?dlp=t", json=self._asked()))

    async def hold(self) -> None:
        """Keep a long poll open and process its messages, for ever; where long polls end at once, wait."""
        while True:
            loop = asyncio.get_running_loop()
            began = loop.time()
            async with self._client.stream(self._path, self._asked()) as pieces:
                rest = ""
                async for piece in pieces:
                    *whole, rest = (rest + piece).split(_BETWEEN)
                    for chunk in whole:
                        self._take(json.loads(chunk.replace("\r\n||\r\n", _BETWEEN)))
                if rest.strip():  # a message that is not in pieces
                    self._take(json.loads(rest))
            if loop.time() - began < 1.0:
                await asyncio.sleep(1.0)

    @property
    def _path(self) -> str:
        return f"/message-bus/{self._client_id}/poll"

    def _asked(self) -> dict[str, int]:
        self._number += 1
        return {**self._places, "__seq": self._number}

    def _take(self, messages: list[dict[str, Any]]) -> None:
        for message in messages:
            channel, data = message["channel"], message["data"]
            if channel == "/__status":
                known = {c: int(n) for c, n in data.items() if c in self._places}
                # The position moved past messages that are not for us; perhaps our key is refused.
                if any(0 <= self._places[c] < n for c, n in known.items()):
                    self.rang.set()
                self._places |= known
                continue
            if channel not in self._places or int(message["message_id"]) <= self._places[channel]:
                continue
            self._places[channel] = int(message["message_id"])
            if channel != _LATEST and isinstance(data, dict) and isinstance(data.get("id"), int):
                self._hints.add(data["id"])
            self.rang.set()


async def listen(watch: ChangeTracker, client: DiscourseClient, after: str, beat_s: float) -> AsyncIterator[Event]:
    """Yield events as they happen, and a heartbeat whenever the channel was proven alive without news."""
    bus = MessageBusClient(client)
    await watch.changes(after, 1)
    bus.listen_to(watch.topics())
    await bus.probe()
    held = asyncio.create_task(bus.hold())
    try:
        while True:
            bus.rang.clear()
            events = await watch.changes(after, _AT_ONCE, bus.hints())
            for event in events:
                after = event.id
                yield event
            if bus.listen_to(watch.topics()):  # look once more for changes from before the subscription
                await bus.probe()
                held = await _anew(held, bus)
                continue
            if not events:
                yield watch.heartbeat()
            while len(events) < _AT_ONCE and not await _within(bus.rang, beat_s):
                if held.done():
                    held.result()
                await bus.probe()
                if not bus.rang.is_set():
                    yield watch.heartbeat()
    finally:
        await _end(held)


async def _anew(held: asyncio.Task[None], bus: MessageBusClient) -> asyncio.Task[None]:
    if held.done():
        held.result()
    await _end(held)
    return asyncio.create_task(bus.hold())


async def _end(task: asyncio.Task[None]) -> None:
    task.cancel()
    await asyncio.wait({task})
    if not task.cancelled():
        task.exception()


async def _within(event: asyncio.Event, seconds: float) -> bool:
    try:
        async with asyncio.timeout(seconds):
            await event.wait()
    except TimeoutError:
        return False
    return True
