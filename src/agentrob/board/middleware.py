"""ASGI middleware that checks host, origin and size of every request, and adds security headers to every response."""

from __future__ import annotations

from typing import Final
from urllib.parse import urlsplit

import structlog
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from agentrob.board.content import images
from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError, HttpError
from agentrob.process.http_server import LOOPBACK_HOSTS, check_length, host_name, trace_id
from agentrob.process.problem import problem_response

#: JSON writes CJK text with up to six bytes a character, so a post of 64 KiB may come in a larger body.
MAX_BODY: Final = 512 * 1024
_MULTIPART_ROOM: Final = 64 * 1024
#: The API's uploads, and forms of pages for writing.
_WITH_PICTURES: Final = ("/images", "/reply", "/new", "/edit", "/command", "/geometry")
_SAFE: Final = frozenset({"GET", "HEAD", "OPTIONS", "TRACE"})
_HEADERS: Final = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "font-src 'self'; connect-src 'self'; manifest-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
}


log = structlog.get_logger(__name__)


class SecurityMiddleware:
    """Refuses requests that name another host, come from another site or are too large."""

    def __init__(self, app: ASGIApp, settings: BoardSettings) -> None:
        self.app = app
        parts = urlsplit(settings.base_url)
        self.origin, self.secure = settings.base_url, settings.secure
        self.hosts = {parts.hostname or "", settings.host} | LOOPBACK_HOSTS
        self.any_host = bool(self.hosts & {"0.0.0.0", "::"})
        self.headers = dict(_HEADERS)
        if settings.secure:
            self.headers["Strict-Transport-Security"] = "max-age=31536000"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        traced = trace_id(Headers(scope=scope))

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                if traced:  # lets a client find its request in this log
                    asked = {"method": scope["method"], "path": scope["path"], "status": message["status"]}
                    log.info("board.traced", **asked, trace_id=traced)
                headers = MutableHeaders(scope=message)
                for name, value in self.headers.items():
                    headers.setdefault(name, value)
            await send(message)

        try:
            self._check(scope)
        except HttpError as e:
            await problem_response(e)(scope, receive, send_with_headers)
            return
        await self.app(scope, _limited(receive, max_body(scope["path"])), send_with_headers)

    def _check(self, scope: Scope) -> None:
        headers = Headers(scope=scope)
        if scope["path"] == "/healthz":
            return  # probes use the IP address, and the response reveals nothing
        host = headers.get("host", "")
        name = host_name(headers)
        if name not in self.hosts and not (self.any_host and name):
            # DNS rebinding: a page of another site could otherwise reach a forum on loopback.
            raise BoardError(421, "unknown_host", f"this is not {host[:64]!r}", f"open {self.origin}")
        if scope["method"] not in _SAFE and "authorization" not in headers:
            self._check_origin(headers, host)
        check_length(headers, max_body(scope["path"]))

    def _check_origin(self, headers: Headers, host: str) -> None:
        ours = {None, self.origin} if self.secure else {None, self.origin, f"http://{host}"}
        if headers.get("origin") not in ours or headers.get("sec-fetch-site") in ("cross-site", "same-site"):
            raise BoardError(403, "foreign_origin", "the request comes from another site", f"open {self.origin}")


def max_body(path: str) -> int:
    """The largest body of a request to this path, in bytes."""
    if path.endswith(_WITH_PICTURES):
        return images.MAX_BYTES + _MULTIPART_ROOM
    return images.MAX_FRAME_BYTES if path.endswith("/frame") else MAX_BODY


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
