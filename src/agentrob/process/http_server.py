"""The uvicorn server that every HTTP server of AgentRob runs: the board, an agent's service and the MCP servers."""

from __future__ import annotations

import contextlib
import signal
import socket
from collections.abc import Awaitable, Callable, Iterator
from types import FrameType
from typing import TYPE_CHECKING, Any

import uvicorn

if TYPE_CHECKING:
    from starlette.types import ASGIApp

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


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
