"""Publish the shape of the robot for the forum's 3D view, once it is wanted."""

from __future__ import annotations

import asyncio

import httpx2
import structlog

from agentrob.errors import ForumError
from agentrob.forums.protocol import PosePages
from agentrob.process.tls import tls

#: The demo's robots have 250 to 350 kB.
MOST_BYTES = 4 * 2**20
_log = structlog.get_logger()


class Geometry:
    """The geometry of one robot. `url` is where it comes from (`[robots.NAME.map] geometry`), empty if there is none.

    `name` is the forum's name for it, empty until it is published.
    """

    def __init__(self, pages: PosePages | None, robot: str, url: str) -> None:
        self._pages, self._robot, self._url = pages, robot, url
        self._publishing = asyncio.Lock()
        self.name = ""

    async def publish(self) -> str:
        """Publish it unless it is published, and return its name; empty if that fails, which is tried again."""
        if self._pages is None or not self._url:
            return ""
        async with self._publishing:
            if not self.name:
                try:
                    self.name = await self._pages.publish_geometry(self._robot, await self._fetch())
                except (httpx2.HTTPError, httpx2.InvalidURL, ForumError) as e:
                    _log.info("geometry not published", robot=self._robot, error=str(e) or type(e).__name__)
        return self.name

    async def _fetch(self) -> bytes:
        async with httpx2.AsyncClient(timeout=20.0, trust_env=False, verify=tls()) as http:
            answer = await http.get(self._url)
            answer.raise_for_status()
        if len(answer.content) > MOST_BYTES:
            raise ForumError(f"the geometry has {len(answer.content)} bytes; at most {MOST_BYTES}")
        return answer.content
