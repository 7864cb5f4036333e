"""The service's front door, around every request: whose address, how large, counted, and headers."""

from __future__ import annotations

import time
from collections.abc import Collection
from typing import Final
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from agentrob.errors import ServiceError
from agentrob.service.figures import Figures
from agentrob.service.problem import problem

MAX_BODY: Final = 64 * 1024
MAX_HOOK: Final = 1024 * 1024
_LOOPBACK: Final = frozenset({"127.0.0.1", "::1", "localhost"})
_METHODS: Final = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
_HEADERS: Final = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


class Gate:
    """ASGI around the app. `hosts` are the names by which it may be called: a page of another site whose name was made
    to point here could otherwise talk to a service on loopback."""

    def __init__(self, app: ASGIApp, hosts: Collection[str], figures: Figures) -> None:
        self.app = app
        self.hosts = {host.lower() for host in hosts} | _LOOPBACK
        self.figures = figures

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        scope.setdefault("state", {})["received_s"] = time.monotonic()
        method = scope["method"] if scope["method"] in _METHODS else "other"

        async def counted(message: Message) -> None:
            if message["type"] == "http.response.start":
                self.figures.count(self.figures.requests, method, str(message["status"]))
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        most = MAX_HOOK if scope["path"].startswith("/api/v1/hooks/") else MAX_BODY
        try:
            self._check(Headers(scope=scope), most)
        except ServiceError as e:
            await problem(e)(scope, receive, counted)
            return
        await self.app(scope, _limited(receive, most), counted)

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


def _limited(receive: Receive, limit: int) -> Receive:
    got = 0

    async def limited() -> Message:
        nonlocal got
        message = await receive()
        got += len(message.get("body", b""))
        if got > limit:
            raise HTTPException(413, f"the body is larger than {limit} bytes")
        return message

    return limited
