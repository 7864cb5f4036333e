"""NodeBB's push channel (Engine.IO 4 over a WebSocket), used only as a signal that something changed.

Its messages carry HTML and miss everything that happens while it is disconnected, so posts are always read again over
HTTP. It needs a session: the cookie, and the CSRF token in the address.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from typing import Any

import structlog
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidHandshake, WebSocketException

from agentrob.errors import ForumError
from agentrob.forums.http import USER_AGENT
from agentrob.forums.nodebb.http import NodeBBClient
from agentrob.process.tls import tls

_BACKOFF_S = (0.5, 30.0)
_NEWS = frozenset(
    {"event:new_post", "event:new_topic", "event:new_notification", "event:post_edited", "event:post_deleted"}
)
_log = structlog.get_logger()


class Push:
    """Keeps the socket open in the background while entered; `news` is set whenever something happened."""

    def __init__(self, client: NodeBBClient) -> None:
        self.news = asyncio.Event()
        self.connected = asyncio.Event()
        self._client = client
        self._task: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Push:
        self._task = asyncio.create_task(self._keep_open())
        return self

    async def __aexit__(self, *_: object) -> None:
        assert self._task is not None
        self._task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await self._task

    async def wait(self, seconds: float) -> bool:
        """Wait until something happens, or for this long."""
        try:
            async with asyncio.timeout(seconds):
                await self.news.wait()
        except TimeoutError:
            return False
        finally:
            self.news.clear()
        return True

    async def _keep_open(self) -> None:
        wait_s, longest_s = _BACKOFF_S
        while True:
            try:
                await self._client.check()
                async with connect(self._address(), **self._options()) as socket:
                    await self._listen(socket)
            except (ForumError, OSError, TimeoutError, InvalidHandshake, WebSocketException, ValueError) as e:
                _log.info("the forum's socket is cut; asking instead", after_s=wait_s, error=str(e))
            if self.connected.is_set():
                wait_s = _BACKOFF_S[0]
            self.connected.clear()
            await asyncio.sleep(wait_s)
            wait_s = min(longest_s, wait_s * 2)

    def _address(self) -> str:
        home = self._client.url
        return f"ws{home.removeprefix('http')}/socket.io/?EIO=4&transport=websocket&_csrf={self._client.csrf}"

    def _options(self) -> dict[str, Any]:
        return {
            "additional_headers": {"Cookie": self._client.cookie},
            "user_agent_header": USER_AGENT,
            "origin": self._client.url,
            "proxy": None,
            "ssl": tls() if self._client.url.startswith("https:") else None,
            "open_timeout": 5,
            "close_timeout": 1,
            "ping_interval": None,  # Engine.IO has pings of its own
        }

    async def _listen(self, socket: ClientConnection) -> None:
        """Read packets: `0` open, `2` ping, `40` joined, `42[event, …]`. Without pings the server is gone."""
        silence_s = 20.0
        while True:
            async with asyncio.timeout(silence_s):
                packet = await socket.recv(decode=True)
            match packet[:2]:
                case "0{":
                    opened = json.loads(packet[1:])
                    silence_s = (float(opened["pingInterval"]) + float(opened["pingTimeout"])) / 1000 + 5
                    await socket.send("40")
                case "2" | "2\n":
                    await socket.send("3")
                case "40":
                    self.connected.set()
                    self.news.set()
                case "42" if json.loads(packet[2:])[0] in _NEWS:
                    self.news.set()
                case "41" | "44":
                    raise ValueError(f"the forum closed the socket: {packet[:100]}")
