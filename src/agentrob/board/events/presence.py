"""Robots that are online: their cards, last live pictures and viewers, kept in memory.

Where several processes serve one database, each shares its state with the others (`ClusterMessenger`), so that every
process shows the same page.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any

from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from agentrob.board.events import streams

BOUNDARY = b"frame"
#: An agent renews its card at least every 5 s; three missed ones in a row mean that it is gone.
LIVE_FOR = timedelta(seconds=15)
#: A picture of another process is old after this, where nobody looks at it.
WANTED_S = 0.5
#: A robot's agent is told at most so often that somebody looks.
WATCH_EVERY_S = 1.0
#: Agents show ten pictures a second; one that has shown none for so long has to be told that somebody looks.
SHOWING_S = 1.0


@dataclass(slots=True)
class RobotPresence:
    """One robot as its agent last told. `seen_at` is None before it did; `card_s`, `frame_s` and `called_s`, when its
    agent was last told that somebody looks, are monotonic. `call` is when it will be told again.

    `viewers` look here, `elsewhere` on other processes.
    """

    name: str
    card: Mapping[str, Any] = field(default_factory=dict)
    card_s: float = 0.0
    seen_at: datetime | None = None
    frame: bytes | None = None
    frame_s: float = 0.0
    frames: int = 0
    viewers: int = 0
    elsewhere: int = 0
    called_s: float = -WATCH_EVERY_S
    call: asyncio.TimerHandle | None = None
    waiters: set[asyncio.Future[None]] = field(default_factory=set)

    @property
    def watched(self) -> int:
        """How many look, wherever."""
        return self.viewers + self.elsewhere

    @property
    def kept_waiting(self) -> bool:
        """Whether somebody looks and its agent shows nothing."""
        return self.watched > 0 and time.monotonic() - self.frame_s > SHOWING_S


class PresenceTracker:
    """All robots that were told of since the server started. Lives on the event loop.

    `changed` hears what is to be told to other processes: a robot's name, and `card`, `frame` or `viewers`.
    """

    def __init__(self) -> None:
        self.closed = asyncio.Event()
        self.changed: Callable[[str, str], None] = lambda robot, what: None
        self._robots: dict[str, RobotPresence] = {}

    def robots(self) -> tuple[RobotPresence, ...]:
        return tuple(self._robots.values())

    def robot(self, name: str) -> RobotPresence:
        """The robot of this name; whether there is such an account is for the caller to know."""
        return self._robots.setdefault(name, RobotPresence(name))

    def publish(self, name: str, card: Mapping[str, Any]) -> RobotPresence:
        robot = self.robot(name)
        robot.card, robot.card_s, robot.seen_at = card, time.monotonic(), datetime.now(UTC)
        self.changed(name, "card")
        return robot

    def show(self, name: str, jpeg: bytes) -> int:
        """A new picture for those who look; returns how many do."""
        robot = self.robot(name)
        robot.frame, robot.frame_s, robot.seen_at = jpeg, time.monotonic(), datetime.now(UTC)
        robot.frames += 1
        _wake(robot)
        self.changed(name, "frame")
        return robot.watched

    # ---------------------------------------------------------------- from other processes
    def receive_card(self, name: str, card: Mapping[str, Any], age_s: float) -> None:
        """A card that another process was told so long ago, unless this one has a newer one."""
        robot, at_s = self.robot(name), time.monotonic() - age_s
        if at_s > robot.card_s:
            robot.card, robot.card_s = card, at_s
        self._seen(robot, age_s)

    def receive_frame(self, name: str, jpeg: bytes, age_s: float) -> None:
        """A picture that another process was shown so long ago."""
        robot, at_s = self.robot(name), time.monotonic() - age_s
        if at_s > robot.frame_s:
            robot.frame, robot.frame_s = jpeg, at_s
            robot.frames += 1
            _wake(robot)
        self._seen(robot, age_s)

    def wants(self, name: str) -> bool:
        """Whether a picture that another process was shown is of use: somebody looks here, or the last is old."""
        robot = self.robot(name)
        return robot.viewers > 0 or time.monotonic() - robot.frame_s > WANTED_S

    def receive_viewers(self, elsewhere: Mapping[str, int]) -> None:
        """How many look on other processes, by robot."""
        for robot in self._robots.values():
            robot.elsewhere = elsewhere.get(robot.name, 0)

    def _seen(self, robot: RobotPresence, age_s: float) -> None:
        at = datetime.now(UTC) - timedelta(seconds=age_s)
        robot.seen_at = max(robot.seen_at or at, at)

    def look(self, name: str, viewers: int) -> None:
        """So many more look here, or fewer."""
        self.robot(name).viewers += viewers
        self.changed(name, "viewers")

    def close(self) -> None:
        """End all live pictures now."""
        self.closed.set()

    def live_frame(self, name: str) -> bytes | None:
        """The last picture while it is live: what a camera saw long ago is nobody's to see."""
        robot = self.robot(name)
        return robot.frame if time.monotonic() - robot.frame_s < LIVE_FOR.total_seconds() else None

    async def frames(self, name: str, seen: int) -> AsyncIterator[bytes]:
        """The newest picture after the first `seen` ones, each once, without end; those that come too fast for the
        viewer are left out."""
        robot = self.robot(name)
        while True:
            if robot.frame is not None and robot.frames != seen:
                seen = robot.frames
                yield robot.frame
                continue
            waiter: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            robot.waiters.add(waiter)
            try:
                await waiter
            finally:
                robot.waiters.discard(waiter)


def _wake(robot: RobotPresence) -> None:
    for waiter in robot.waiters:
        if not waiter.done():
            waiter.set_result(None)


class CameraStream(Response):
    """A robot's pictures as they come, as browsers show them in an `img` (multipart/x-mixed-replace)."""

    media_type = "multipart/x-mixed-replace; boundary=" + BOUNDARY.decode()

    def __init__(self, presence: PresenceTracker, name: str, allowed: Callable[[], bool]) -> None:
        super().__init__(headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})
        del self.headers["content-length"]
        self._presence, self._name, self._allowed = presence, name, allowed

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        robot = self._presence.robot(self._name)
        self._presence.look(self._name, 1)
        try:
            # Only what comes after the viewer: the last picture may be from hours ago.
            await streams.run(self._send(send, robot.frames), receive, send, self._allowed, self._presence.closed)
        finally:
            self._presence.look(self._name, -1)

    async def _send(self, send: Send, seen: int) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})
        await streams.part(send, b"--" + BOUNDARY + b"\r\n")
        async for jpeg in self._presence.frames(self._name, seen):
            head = b"Content-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg)
            # The boundary right after the picture: a browser shows a part when it sees the next one begin.
            await streams.part(send, head + jpeg + b"\r\n--" + BOUNDARY + b"\r\n")
