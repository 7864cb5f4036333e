"""Publish the shape of the robot for the forum's 3D view, once it is wanted.

It comes from a simulated world, or it is made from the installed models of the robot, in a process of its own.
"""

from __future__ import annotations

import asyncio
import sys

import httpx2
import structlog

from agentrob.errors import ForumError, SimError
from agentrob.forums.protocol import PosePages
from agentrob.process.run import run_process
from agentrob.process.tls import tls

#: The demo's robots have 250 to 350 kB.
MOST_BYTES = 4 * 2**20
#: The robots whose models the extra `sim` installs.
MODELS = ("go2", "g1")
#: How long a shape may take to be made.
MAKE_S = 60.0
_GZIP = b"\x1f\x8b"
_log = structlog.get_logger()


class Geometry:
    """The geometry of one robot of a `kind`. `source` is a URL, `auto` (from the installed models) or `none`
    (`[robots.NAME.map] geometry`).

    `name` is the forum's name for it, empty until it is published. `missing` is why there is none, if that is known.
    """

    def __init__(self, pages: PosePages | None, robot: str, kind: str, source: str) -> None:
        self._pages, self._robot, self._kind, self._source = pages, robot, kind, source
        self._publishing = asyncio.Lock()
        self.name = ""
        self.missing = ""
        if source == "none":
            self.missing = "the robot's owner shows its map only"
        elif source == "auto" and kind not in MODELS:
            self.missing = f"no 3D model of a {kind} is known"

    async def publish(self) -> str:
        """Publish it unless it is published, and return its name; empty if that fails, which is tried again unless it
        is `missing`."""
        if self._pages is None or self.missing:
            return ""
        async with self._publishing:
            if not self.name and not self.missing:
                try:
                    shape = await (self._made() if self._source == "auto" else self._fetched())
                    self.name = await self._pages.publish_geometry(self._robot, shape)
                except SimError as e:
                    self.missing = str(e)
                    _log.info("no geometry, so there is no 3D view", robot=self._robot, reason=self.missing)
                except (httpx2.HTTPError, httpx2.InvalidURL, ForumError, OSError) as e:
                    _log.info("geometry not published", robot=self._robot, error=str(e) or type(e).__name__)
        return self.name

    async def _fetched(self) -> bytes:
        async with httpx2.AsyncClient(timeout=20.0, trust_env=False, verify=tls()) as http:
            answer = await http.get(self._source)
            answer.raise_for_status()
        if len(answer.content) > MOST_BYTES:
            raise ForumError(f"the geometry has {len(answer.content)} bytes; at most {MOST_BYTES}")
        return answer.content

    async def _made(self) -> bytes:
        """Make it from the installed models. Raises `SimError` if they are not installed."""
        try:
            done = await run_process((sys.executable, "-m", "agentrob.sim.shape", self._kind), limit_s=MAKE_S)
        except TimeoutError:
            raise ForumError(f"the shape was not made within {MAKE_S:g} s") from None
        if done.returncode or not done.stdout.startswith(_GZIP) or len(done.stdout) > MOST_BYTES:
            raise SimError(done.last_error_line[:300] or "the shape could not be made")
        return done.stdout
