"""Stream the room camera to the robot's page, only while somebody watches or the robot moves.

Each picture also goes to the recorder, so that the camera is not polled twice.
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
#: The stream continues this long after the last motion, so that viewers see how it ended.
LINGER_S = 1.0
_MAX_BYTES = 4 * 2**20
_log = structlog.get_logger()


async def snapshot(http: httpx2.AsyncClient, url: str) -> bytes:
    """Fetch one picture. Raises httpx2's errors, and `ForumError` if it is too large."""
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
        """Start streaming: somebody watches, or the robot is about to move."""
        self._wanted.set()

    async def run(self) -> None:
        """Stream until cancelled. After an error of the camera or the forum, the next `wake` starts again."""
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
