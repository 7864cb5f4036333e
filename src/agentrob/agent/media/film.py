"""The pictures of one command for its recording: taken while it runs, or asked for afterwards.

A camera that keeps the past (`[robots.NAME.recording] camera`, such as a simulated room's) is asked after the motion:
then no picture of a quick gesture is missing, and taking them costs nothing while the robot moves.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import httpx2
import structlog

from agentrob.agent.media.camera import snapshot
from agentrob.errors import ForumError
from agentrob.process.tls import tls

#: The initial interval between pictures. Beyond `MANY` pictures or `MOST_BYTES`, every second one is dropped and the
#: interval doubles.
FIRST_EVERY_S, MANY, MOST_BYTES = 0.04, 96, 24 * 2**20
#: How long pictures of the past may take; those that are left out then are spread evenly.
FETCH_S = 15.0
#: How often it is checked whether the robot still moves.
REST_S = 0.2
#: After this many consecutive failures, a camera is not asked until the next command.
TRIES = 4
_MAX_FRAME = 2**20
_log = structlog.get_logger()


@dataclass
class Film:
    """The pictures of one command, at even intervals however long it takes: (monotonic seconds, JPEG). `follows`:
    whether the camera follows the robot, so that its pictures are shown whole."""

    frames: list[tuple[float, bytes]] = field(default_factory=list)
    every_s: float = FIRST_EVERY_S
    follows: bool = False

    def add(self, jpeg: bytes) -> None:
        now_s = time.monotonic()
        if len(jpeg) > _MAX_FRAME or (self.frames and now_s - self.frames[-1][0] < self.every_s):
            return
        self.frames.append((now_s, jpeg))
        if len(self.frames) > MANY or sum(len(picture) for _, picture in self.frames) > MOST_BYTES:
            self.frames, self.every_s = self.frames[::2], self.every_s * 2


async def past(url: str, begin_s: float, end_s: float, count: int, moving: Callable[[], bool] = lambda: False) -> Film:
    """Ask a camera that keeps the past for `count` pictures between two monotonic times. Never raises.

    While the robot is `moving` again it is not asked: rendering would take time from the next command and its stop.
    """
    film, left, until_s = Film(follows=True), TRIES, time.monotonic() + FETCH_S
    if count < 2:
        return film
    async with httpx2.AsyncClient(timeout=5.0, trust_env=False, verify=tls()) as http:
        for n in coarse_first(count):
            at_s = begin_s + (end_s - begin_s) * n / (count - 1)
            while moving():
                await asyncio.sleep(REST_S)
                until_s += REST_S
            if time.monotonic() > until_s or not left:
                break
            try:
                jpeg = await snapshot(http, f"{url}?ago_s={time.monotonic() - at_s:.3f}")
                left = TRIES
                if len(jpeg) <= _MAX_FRAME:
                    film.frames.append((at_s, jpeg))
            except (httpx2.HTTPError, httpx2.InvalidURL, ForumError) as e:
                left -= 1
                _log.info("no picture for the recording", error=str(e) or type(e).__name__)
    film.frames.sort(key=lambda frame: frame[0])
    return film


def coarse_first(count: int) -> list[int]:
    """The numbers below `count`: a few that are spread evenly, then those in the middle between two, and so on."""
    return sorted(range(count), key=lambda n: f"{n:016b}"[::-1])
