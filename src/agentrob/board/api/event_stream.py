"""Events as server-sent events that can be resumed, with heartbeats."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from datetime import UTC, datetime

from fastapi.sse import format_sse_event
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from agentrob.board.api.models import EventOut, Serializer, time_out
from agentrob.board.db.reader import event_number
from agentrob.board.db.records import StoredEvent
from agentrob.board.events import streams
from agentrob.board.events.hub import EncodedEvent, Hub, Listener
from agentrob.model import Account, EventKind


def encode(base_url: str, event: StoredEvent, written: bool) -> EncodedEvent:
    """Encode an event for everybody and for the author of its post."""
    author = event.post.author if event.post and event.post.key is not None else None
    for_all = _frame(Serializer(base_url).event(event))
    for_author = _frame(Serializer(base_url, author).event(event)) if author else for_all
    return EncodedEvent(event, event_number(event.id), for_all, for_author, written)


def _frame(event: EventOut) -> bytes:
    return format_sse_event(id=event.id, event=event.kind, data_str=event.model_dump_json())


class EventStream(Response):
    """Server-sent events after `after`: first those in the database, then new ones, with heartbeats in between."""

    media_type = "text/event-stream"

    def __init__(
        self,
        hub: Hub,
        listener: Listener,
        viewer: Account | None,
        after: int,
        heartbeat_s: float,
        allowed: Callable[[], bool],
    ) -> None:
        super().__init__(headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})
        del self.headers["content-length"]
        self._hub, self._listener, self._viewer = hub, listener, viewer
        self._after, self._heartbeat_s, self._allowed = after, heartbeat_s, allowed
        self._early: deque[tuple[EventKind, str | None, datetime]] = deque(maxlen=100)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await streams.run(self._send(send), receive, send, self._allowed, self._listener.ended)
        finally:
            self._listener.close()
            self._hub.leave(self._listener)

    async def _send(self, send: Send) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})
        await streams.part(send, format_sse_event(retry=1000))
        await self._replay(send)
        await self._live(send)

    async def _replay(self, send: Send) -> None:
        assert self._hub.reader is not None
        while not self._listener.closed:
            boards = self._hub.boards_of(self._listener)
            events = self._hub.reader.events(self._after, 100, self._listener.topic_id, boards)
            if not events:
                return
            for event in events:
                encoded = self._hub.encode(event, True)
                await streams.part(send, self._bytes(encoded))
                self._after = encoded.number

    async def _live(self, send: Send) -> None:
        while not self._listener.closed:
            encoded = await self._listener.next(self._heartbeat_s)
            if encoded is not None:
                if self._sent_early(encoded):
                    self._after = max(self._after, encoded.number)
                elif encoded.number > self._after or not encoded.written:
                    await streams.part(send, self._bytes(encoded))
                    self._after = max(self._after, encoded.number)
            elif not self._listener.closed and self._hub.delivers_stops:
                await streams.part(send, _heartbeat())

    def _sent_early(self, encoded: EncodedEvent) -> bool:
        """Whether this event was sent here before it was written, so that it is not sent twice."""
        event = encoded.event
        if not encoded.written:
            self._early.append((event.kind, event.robot, event.at))
            return False
        return event.robot is not None and (event.kind, event.robot, event.at) in self._early

    def _bytes(self, encoded: EncodedEvent) -> bytes:
        post = encoded.event.post
        mine = post is not None and self._viewer is not None and post.author.id == self._viewer.id
        return encoded.frame_for_author if mine else encoded.frame


def _heartbeat() -> bytes:
    at = time_out(datetime.now(UTC))
    # No id line: the listener's last id stays what it was.
    return format_sse_event(event=EventKind.HEARTBEAT, data_str=f'{{"id":"","kind":"heartbeat","at":"{at}"}}')
