"""The double's message bus: channels of numbered messages, by polling or by long polling with chunks."""

from __future__ import annotations

import asyncio
import json
import time
from collections import defaultdict
from collections.abc import AsyncIterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

BETWEEN = "\r\n|\r\n"


@dataclass
class _Channel:
    last: int = 0
    messages: list[tuple[int, Any, int | None, tuple[int, ...]]] = field(default_factory=list)


class MessageBus:
    """Channels of messages; a message may be restricted to a group or to some users."""

    def __init__(self) -> None:
        self._channels: dict[str, _Channel] = defaultdict(_Channel)
        self._all = 0
        self._waiting: set[asyncio.Event] = set()

    def publish(self, channel: str, data: Any, group: int | None = None, users: tuple[int, ...] = ()) -> None:
        to = self._channels[channel]
        self._all += 1
        to.last += 1
        to.messages.append((to.last, data, group, users))
        del to.messages[:-1000]
        for waiting in self._waiting:
            waiting.set()

    def backlog(self, places: dict[str, int], user: int | None, groups: set[int] | None) -> list[dict[str, Any]]:
        """Return the messages after `places` and advance these; report the position of a channel if a place is -1 or
        ahead of it."""
        due, status = [], {}
        for channel, place in list(places.items()):
            at = self._channels[channel]
            if place < 0 or place > at.last:
                places[channel] = status[channel] = at.last
                continue
            for number, data, group, users in at.messages:
                if number <= place:
                    continue
                if (not users or user in users) and (group is None or groups is None or group in groups):
                    due.append({"global_id": self._all, "message_id": number, "channel": channel, "data": data})
                else:
                    status[channel] = at.last
            places[channel] = at.last
        if status:
            due.append({"global_id": -1, "message_id": -1, "channel": "/__status", "data": status})
        return due

    async def held(
        self, places: Mapping[str, int], user: int | None, groups: set[int] | None, seconds: float
    ) -> AsyncIterator[str]:
        """Yield the chunks of a long-polling request, the first at once, until it times out."""
        at, waiting = dict(places), asyncio.Event()
        self._waiting.add(waiting)
        try:
            yield _piece(self.backlog(at, user, groups))
            ends_s = time.monotonic() + seconds
            while (left_s := ends_s - time.monotonic()) > 0:
                with suppress(TimeoutError):
                    await asyncio.wait_for(waiting.wait(), left_s)
                waiting.clear()
                if due := self.backlog(at, user, groups):
                    yield _piece(due)
            yield _piece([])
        finally:
            self._waiting.discard(waiting)


def _piece(messages: list[dict[str, Any]]) -> str:
    return json.dumps(messages).replace(BETWEEN, "\r\n||\r\n") + BETWEEN
