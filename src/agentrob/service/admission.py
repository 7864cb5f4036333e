"""ASGI middleware that checks host and body size, limits concurrent requests, counts them and sets headers."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from typing import Final

import structlog
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from agentrob.errors import HttpError, ServiceError
from agentrob.forums.protocol import TRACE_ID
from agentrob.process.http_server import LOOPBACK_HOSTS, check_length, host_name, trace_id
from agentrob.process.problem import problem_response
from agentrob.service.metrics import ServiceMetrics

MAX_BODY: Final = 64 * 1024
MAX_WEBHOOK_BODY: Final = 1024 * 1024
#: The number of reads and commands that run at a time; others wait. The agent shares the event loop with them, and must
#: renew its lease and receive stops under any load. A stop never waits.
MAX_READS: Final = 4
MAX_COMMANDS: Final = 16
_METHODS: Final = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
_HEADERS: Final = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


_log = structlog.get_logger()


class Admission:
    """The middleware. The Host header must be one of `hosts`, or a web page could use a service on loopback by DNS
    rebinding."""

    def __init__(self, app: ASGIApp, hosts: Collection[str], metrics: ServiceMetrics) -> None:
        self.app = app
        self.hosts = {host.lower() for host in hosts} | LOOPBACK_HOSTS
        self.metrics = metrics
        self._reads, self._commands = asyncio.Semaphore(MAX_READS), asyncio.Semaphore(MAX_COMMANDS)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        scope.setdefault("state", {})["received_s"] = time.monotonic()
        slot = scope["state"]["slot"] = self._slot(scope)
        counted = self._counted(scope, send, slot)
        most = MAX_WEBHOOK_BODY if scope["path"].startswith("/api/v1/hooks/") else MAX_BODY
        try:
            self._check(Headers(scope=scope), most)
            whole = await _whole(receive, most)
        except HttpError as e:
            await problem_response(e)(scope, receive, counted)
            return
        try:
            await slot.acquire()
            await self.app(scope, whole, counted)
        finally:
            slot.release()

    def _counted(self, scope: Scope, send: Send, slot: Slot) -> Send:
        """Return a `send` that counts the response, adds headers, and releases the slot when the response starts."""
        method = scope["method"] if scope["method"] in _METHODS else "other"
        traced = trace_id(Headers(scope=scope))
        TRACE_ID.set(traced)

        async def counted(message: Message) -> None:
            if message["type"] == "http.response.start":
                slot.release()
                status = message["status"]
                self.metrics.count(self.metrics.requests, method, str(status))
                if traced and status != 401:  # whoever traces a request finds it in this log too, and in the forum's
                    asked = {"method": method, "path": scope["path"], "status": status}
                    _log.info("service.traced", **asked, trace_id=traced)
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        return counted

    def _slot(self, scope: Scope) -> Slot:
        if scope["path"].endswith("/stop"):
            return Slot(None)
        return Slot(self._reads if scope["method"] in ("GET", "HEAD") else self._commands)

    def _check(self, headers: Headers, most: int) -> None:
        if host_name(headers) not in self.hosts:
            raise ServiceError(
                421, "unknown_host", "the Host header does not name this service", "add the name to service.hosts"
            )
        check_length(headers, most)


class Slot:
    """A request's slot in the concurrency limit; without a semaphore the request is not limited."""

    def __init__(self, semaphore: asyncio.Semaphore | None) -> None:
        self._semaphore = semaphore
        self._taken = False

    async def acquire(self) -> None:
        if self._semaphore is not None and not self._taken:
            await self._semaphore.acquire()
            self._taken = True

    def release(self) -> None:
        if self._semaphore is not None and self._taken:
            self._taken = False
            self._semaphore.release()

    @asynccontextmanager
    async def released(self) -> AsyncIterator[None]:
        """Release the slot during a wait, so that other requests can run."""
        self.release()
        try:
            yield
        finally:
            await self.acquire()


async def _whole(receive: Receive, limit: int) -> Receive:
    """Read the whole body first, so that a slow sender holds no slot."""
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
