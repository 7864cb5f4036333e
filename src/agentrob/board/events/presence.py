"""The state of robots, in memory: their cards, last live pictures and viewers.

Processes that serve one database share this state (`ClusterMessenger`), so that they show the same pages.
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
from agentrob.board.events.poses import PoseTracker

BOUNDARY = b"frame"
#: An agent renews its card at least every 5 s; after three missed ones in a row it counts as gone.
LIVE_FOR = timedelta(seconds=15)
#: Seconds after which a picture of another process is old, if it has no viewers here.
WANTED_S = 0.5
#: Seconds between two events that tell a robot's agent of viewers.
WATCH_EVERY_S = 1.0
#: Agents show ten pictures a second; one that has shown none for this many seconds must be notified of its viewers
#: again.
SHOWING_S = 1.0


@dataclass(slots=True)
class RobotPresence:
    """The state of one robot. `seen_at` is None until its agent publishes something; `card_s`, `frame_s` and
    `called_s`, when its agent was last notified of viewers, are monotonic. `call` is the timer that notifies it again.

    `viewers` are those of this process, `elsewhere` those of other processes.
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
        """The number of viewers on all processes."""
        return self.viewers + self.elsewhere

    @property
    def kept_waiting(self) -> bool:
        """Whether it has viewers but its agent sends no pictures."""
        return self.watched > 0 and time.monotonic() - self.frame_s > SHOWING_S


class PresenceTracker:
    """The state of all robots. Use it on the event loop only.

    `changed` is called with a robot's name and `card`, `frame` or `viewers`, to share the change with other processes.
    """

    def __init__(self) -> None:
        self.closed = asyncio.Event()
        self.changed: Callable[[str, str], None] = lambda robot, what: None
        self.poses = PoseTracker()
        self._robots: dict[str, RobotPresence] = {}

    def robots(self) -> tuple[RobotPresence, ...]:
        return tuple(self._robots.values())

    def robot(self, name: str) -> RobotPresence:
        """The robot of this name. The caller checks that there is such an account."""
        return self._robots.setdefault(name, RobotPresence(name))

    def publish(self, name: str, card: Mapping[str, Any]) -> RobotPresence:
        robot = self.robot(name)
        robot.card, robot.card_s, robot.seen_at = card, time.monotonic(), datetime.now(UTC)
        self.changed(name, "card")
        return robot

    def show(self, name: str, jpeg: bytes) -> int:
        """Store a new picture and wake its viewers; return their number."""
        robot = self.robot(name)
        robot.frame, robot.frame_s, robot.seen_at = jpeg, time.monotonic(), datetime.now(UTC)
        robot.frames += 1
        _wake(robot)
        self.changed(name, "frame")
        return robot.watched

    # ---------------------------------------------------------------- from other processes
    def receive_card(self, name: str, card: Mapping[str, Any], age_s: float) -> None:
        """Store a card that another process received `age_s` ago, unless this one has a newer one."""
        robot, at_s = self.robot(name), time.monotonic() - age_s
        if at_s > robot.card_s:
            robot.card, robot.card_s = card, at_s
        self._seen(robot, age_s)

    def receive_frame(self, name: str, jpeg: bytes, age_s: float) -> None:
        """Store a picture that another process received `age_s` ago, unless this one has a newer one."""
        robot, at_s = self.robot(name), time.monotonic() - age_s
        if at_s > robot.frame_s:
            robot.frame, robot.frame_s = jpeg, at_s
            robot.frames += 1
            _wake(robot)
        self._seen(robot, age_s)

    def wants(self, name: str) -> bool:
        """Whether this process needs a picture from another one: it has viewers, or the last picture is old."""
        robot = self.robot(name)
        return robot.viewers > 0 or time.monotonic() - robot.frame_s > WANTED_S

    def receive_viewers(self, elsewhere: Mapping[str, int]) -> None:
        """Set the number of viewers on other processes, by robot."""
        for robot in self._robots.values():
            robot.elsewhere = elsewhere.get(robot.name, 0)

    def _seen(self, robot: RobotPresence, age_s: float) -> None:
        at = datetime.now(UTC) - timedelta(seconds=age_s)
        robot.seen_at = max(robot.seen_at or at, at)

    def look(self, name: str, viewers: int) -> None:
        """Add to the number of viewers here."""
        self.robot(name).viewers += viewers
        self.changed(name, "viewers")

    def close(self) -> None:
        """End all streams of cameras and poses."""
        self.closed.set()

    def live_frame(self, name: str) -> bytes | None:
        """The last picture, or None if it is too old to count as live."""
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
    """The live pictures of a robot, as browsers show them in an `img` (multipart/x-mixed-replace)."""

    media_type = "multipart/x-mixed-replace; boundary=" + BOUNDARY.decode()

    def __init__(self, presence: PresenceTracker, name: str, allowed: Callable[[], bool]) -> None:
        super().__init__(headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})
        del self.headers["content-length"]
        self._presence, self._name, self._allowed = presence, name, allowed

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        robot = self._presence.robot(self._name)
        self._presence.look(self._name, 1)
        try:
            # Only new pictures: the last one may be hours old.
            await streams.run(self._send(send, robot.frames), receive, send, self._allowed, self._presence.closed)
        finally:
            self._presence.look(self._name, -1)

    async def _send(self, send: Send, seen: int) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})
        await streams.part(send, b"--" + BOUNDARY + b"\r\n")
        async for jpeg in self._presence.frames(self._name, seen):
            head = b"Content-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg)
            # The boundary follows the picture at once: a browser shows a part when the next one begins.
            await streams.part(send, head + jpeg + b"\r\n--" + BOUNDARY + b"\r\n")
