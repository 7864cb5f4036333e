"""The camera of the room, live on the robot's page: while somebody watches or the robot moves, and never else.

What it shows is also told to whoever records a command, so that nothing is looked at twice.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

import httpx2
import structlog

from agentrob.errors import ForumError
from agentrob.forums.protocol import RobotPages
from agentrob.process.tls import tls

FPS = 10.0
#: The picture goes on for a moment after the last motion, so that the end is seen.
LINGER_S = 1.0
_MAX_BYTES = 4 * 2**20
_log = structlog.get_logger()


async def snapshot(http: httpx2.AsyncClient, url: str) -> bytes:
    """One picture. Raises httpx2's errors, and `ForumError` for one that is too large."""
    answer = await http.get(url)
    answer.raise_for_status()
    if len(answer.content) > _MAX_BYTES:
        raise ForumError(f"the camera's picture has {len(answer.content)} bytes; at most {_MAX_BYTES}")
    return answer.content


class Camera:
    """Fetches snapshots from `url` and publishes them as `robot`'s live picture."""

    def __init__(
        self,
        pages: RobotPages,
        robot: str,
        url: str,
        moving: Callable[[], bool],
        seen: Callable[[bytes], None] = lambda _: None,
    ) -> None:
        self._pages = pages
        self._robot = robot
        self._url = url
        self._moving = moving
        self._seen = seen
        self._wanted = asyncio.Event()

    def wake(self) -> None:
        """Somebody watches, or the robot is about to move."""
        self._wanted.set()

    async def run(self) -> None:
        """For ever; a camera or a forum that fails is tried again with the next wake."""
        async with httpx2.AsyncClient(timeout=3.0, trust_env=False, verify=tls()) as http:
            while True:
                await self._wanted.wait()
                self._wanted.clear()
                try:
                    await self._show(http)
                except (httpx2.HTTPError, httpx2.InvalidURL, ForumError) as e:
                    _log.info("live picture ended", robot=self._robot, error=str(e) or type(e).__name__)
                    await asyncio.sleep(1.0)

    async def _show(self, http: httpx2.AsyncClient) -> None:
        moved_s = time.monotonic()
        while True:
            begun_s = time.monotonic()
            jpeg = await snapshot(http, self._url)
            self._seen(jpeg)
            viewers = await self._pages.publish_frame(self._robot, jpeg)
            if self._moving():
                moved_s = time.monotonic()
            if viewers == 0 and time.monotonic() - moved_s > LINGER_S:
                return
            await asyncio.sleep(max(0.0, 1.0 / FPS - (time.monotonic() - begun_s)))
