"""The service's front door, around every request: whose address, how large, how many at a time, counted, headers."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from typing import Final
from urllib.parse import urlsplit

import structlog
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from agentrob.errors import ServiceError
from agentrob.forums.protocol import TRACE_ID
from agentrob.service.metrics import Figures
from agentrob.service.problem import problem

MAX_BODY: Final = 64 * 1024
MAX_HOOK: Final = 1024 * 1024
#: So many requests that look, and that ask for something, are worked on at a time, the others wait at the door: the
#: agent shares the event loop with them, and must renew its lease and hear of stops whatever comes. No stop waits.
MOST_LOOKS: Final = 4
MOST_ASKS: Final = 16
_LOOPBACK: Final = frozenset({"127.0.0.1", "::1", "localhost"})
_TRACE_ID: Final = re.compile(r"[A-Za-z0-9_-]{8,64}")
_METHODS: Final = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
_HEADERS: Final = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


_log = structlog.get_logger()


class Gate:
    """ASGI around the app. `hosts` are the names by which it may be called: a page of another site whose name was made
    to point here could otherwise talk to a service on loopback."""

    def __init__(self, app: ASGIApp, hosts: Collection[str], figures: Figures) -> None:
        self.app = app
        self.hosts = {host.lower() for host in hosts} | _LOOPBACK
        self.figures = figures
        self._looks, self._asks = asyncio.Semaphore(MOST_LOOKS), asyncio.Semaphore(MOST_ASKS)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        scope.setdefault("state", {})["received_s"] = time.monotonic()
        place = scope["state"]["place"] = self._place(scope)
        counted = self._counted(scope, send, place)
        most = MAX_HOOK if scope["path"].startswith("/api/v1/hooks/") else MAX_BODY
        try:
            self._check(Headers(scope=scope), most)
            whole = await _whole(receive, most)
        except ServiceError as e:
            await problem(e)(scope, receive, counted)
            return
        try:
            await place.take()
            await self.app(scope, whole, counted)
        finally:
            place.leave()

    def _counted(self, scope: Scope, send: Send, place: Place) -> Send:
        """Sends the answer, counted and with its headers; from its beginning on it has no place."""
        method = scope["method"] if scope["method"] in _METHODS else "other"
        trace_id = Headers(scope=scope).get("x-trace-id", "")
        traced = _TRACE_ID.fullmatch(trace_id) is not None
        TRACE_ID.set(trace_id if traced else "")

        async def counted(message: Message) -> None:
            if message["type"] == "http.response.start":
                place.leave()
                status = message["status"]
                self.figures.count(self.figures.requests, method, str(status))
                if traced and status != 401:  # whoever traces a request finds it in this log too, and in the forum's
                    asked = {"method": method, "path": scope["path"], "status": status}
                    _log.info("service.traced", **asked, trace_id=trace_id)
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        return counted

    def _place(self, scope: Scope) -> Place:
        if scope["path"].endswith("/stop"):
            return Place(None)
        return Place(self._looks if scope["method"] in ("GET", "HEAD") else self._asks)

    def _check(self, headers: Headers, most: int) -> None:
        try:
            name = urlsplit(f"//{headers.get('host', '')}").hostname
        except ValueError:
            name = None
        if name not in self.hosts:
            raise ServiceError(421, "unknown_host", "this service has another address", "set service.hosts")
        length = headers.get("content-length", "0")
        if not length.isascii() or not length.isdigit() or int(length[:12]) > most:
            raise ServiceError(413, "too_large", "the body is too large", f"at most {most} bytes")


class Place:
    """A request's place among those that are worked on; None: it needs none."""

    def __init__(self, places: asyncio.Semaphore | None) -> None:
        self._places = places
        self._taken = False

    async def take(self) -> None:
        if self._places is not None and not self._taken:
            await self._places.acquire()
            self._taken = True

    def leave(self) -> None:
        if self._places is not None and self._taken:
            self._taken = False
            self._places.release()

    @asynccontextmanager
    async def aside(self) -> AsyncIterator[None]:
        """Whoever waits for something within this holds up nobody else."""
        self.leave()
        try:
            yield
        finally:
            await self.take()


async def _whole(receive: Receive, limit: int) -> Receive:
    """The body when all of it is there: who sends slowly has no place meanwhile."""
    messages: list[Message] = []
    got, more = 0, True
    while more:
        message = await receive()
        messages.append(message)
        got += len(message.get("body", b""))
        if got > limit:
            raise ServiceError(413, "too_large", "the body is too large", f"at most {limit} bytes")
        more = message["type"] == "http.request" and message.get("more_body", False)
    messages.reverse()

    async def replayed() -> Message:
        return messages.pop() if messages else await receive()

    return replayed
