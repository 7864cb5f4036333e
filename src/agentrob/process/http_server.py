"""The uvicorn server of the board, of an agent's service and of the MCP servers, and the checks of their requests."""

from __future__ import annotations

import contextlib
import re
import signal
import socket
from collections.abc import Awaitable, Callable, Iterator
from types import FrameType
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

import uvicorn

from agentrob.errors import HttpError

if TYPE_CHECKING:
    from starlette.datastructures import Headers
    from starlette.types import ASGIApp

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
#: Host names that reach a server on loopback.
LOOPBACK_HOSTS: Final = frozenset({"127.0.0.1", "::1", "localhost"})
_TRACE_ID: Final = re.compile(r"[A-Za-z0-9_-]{8,64}")


class HttpServer(uvicorn.Server):
    """Serves an ASGI app on sockets that are open already.

    `on_ready` is called when requests are accepted; `on_shutdown` before open connections are waited for, to end
    streams that would keep the server from ending. SIGINT and SIGTERM end it in order, and it returns, where uvicorn's
    own server would then die of the signal; a second one ends it at once. With `handle_signals` False, or outside the
    main thread, signals are left to the caller, who sets `should_exit`. `settings` are those of `uvicorn.Config`.
    """

    def __init__(
        self,
        app: ASGIApp,
        *,
        on_ready: Callable[[], None] | None = None,
        on_shutdown: Callable[[], Awaitable[None]] | None = None,
        handle_signals: bool = True,
        **settings: Any,
    ) -> None:
        defaults: dict[str, Any] = {
            "lifespan": "on", "log_config": None, "access_log": False, "server_header": False, "proxy_headers": False,
            "timeout_keep_alive": 30, "timeout_graceful_shutdown": 1,
        }  # fmt: skip
        super().__init__(uvicorn.Config(app, **(defaults | settings)))
        self._on_ready, self._on_shutdown = on_ready, on_shutdown
        self._handle_signals = handle_signals

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self._on_ready is not None:
            self._on_ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        if self._on_shutdown is not None:
            await self._on_shutdown()
        await super().shutdown(sockets)

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        before: dict[signal.Signals, Any] = {}
        if self._handle_signals:
            with contextlib.suppress(ValueError):  # not in the main thread
                before = {number: signal.signal(number, self.handle_exit) for number in _SIGNALS}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self.force_exit = self.should_exit
        self.should_exit = True


def host_name(headers: Headers) -> str | None:
    """The host that a request names; None if the header is missing or malformed."""
    try:
        parts = urlsplit(f"//{headers.get('host', '')}")
        return parts.hostname if parts.port != 0 else None
    except ValueError:
        return None


def check_length(headers: Headers, limit: int) -> None:
    """Raise 413 if the request announces a body of more than `limit` bytes."""
    length = headers.get("content-length", "0")
    if not length.isascii() or not length.isdigit() or int(length[:12]) > limit:
        raise HttpError(413, "too_large", "the body is too large", f"at most {limit} bytes")


def trace_id(headers: Headers) -> str:
    """The id under which a client traces its request; empty without a valid one."""
    found = headers.get("x-trace-id", "")
    return found if _TRACE_ID.fullmatch(found) else ""
