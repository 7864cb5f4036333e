"""What the robots' agents show of their robots: a card and the last live picture, in memory only, and who looks."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from starlette.responses import Response
from starlette.types import Receive, Scope, Send

BOUNDARY = b"frame"


@dataclass(slots=True)
class RobotNow:
    """One robot as its agent last told. `seen_at` is None before it did."""

    name: str
    card: Mapping[str, Any] = field(default_factory=dict)
    seen_at: datetime | None = None
    frame: bytes | None = None
    frames: int = 0
    viewers: int = 0
    waiters: set[asyncio.Future[None]] = field(default_factory=set)


class Stage:
    """All robots that were told of since the server started. Lives on the event loop."""

    def __init__(self) -> None:
        self.closed = False
        self._robots: dict[str, RobotNow] = {}

    def robot(self, name: str) -> RobotNow:
        """The robot of this name; whether there is such an account is for the caller to know."""
        return self._robots.setdefault(name, RobotNow(name))

    def publish(self, name: str, card: Mapping[str, Any]) -> RobotNow:
        robot = self.robot(name)
        robot.card, robot.seen_at = card, datetime.now(UTC)
        return robot

    def show(self, name: str, jpeg: bytes) -> int:
        """A new picture for those who look; returns how many do."""
        robot = self.robot(name)
        robot.frame, robot.seen_at = jpeg, datetime.now(UTC)
        robot.frames += 1
        _wake(robot)
        return robot.viewers

    def close(self) -> None:
        """End all live pictures now."""
        self.closed = True
        for robot in self._robots.values():
            _wake(robot)

    async def frames(self, name: str) -> AsyncIterator[bytes]:
        """The newest picture, each once; those that come too fast for the viewer are left out."""
        robot, seen = self.robot(name), 0
        while not self.closed:
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


def _wake(robot: RobotNow) -> None:
    for waiter in robot.waiters:
        if not waiter.done():
            waiter.set_result(None)


class CameraStream(Response):
    """A robot's pictures as they come, as browsers show them in an `img` (multipart/x-mixed-replace)."""

    media_type = "multipart/x-mixed-replace; boundary=" + BOUNDARY.decode()

    def __init__(self, stage: Stage, name: str) -> None:
        super().__init__(headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})
        del self.headers["content-length"]
        self._stage, self._name = stage, name

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        robot = self._stage.robot(self._name)
        robot.viewers += 1
        sending = asyncio.ensure_future(self._send(send))
        gone = asyncio.ensure_future(_gone(receive))
        try:
            await asyncio.wait((sending, gone), return_when=asyncio.FIRST_COMPLETED)
        finally:
            robot.viewers -= 1
            for task in (sending, gone):
                task.cancel()
            await asyncio.gather(sending, gone, return_exceptions=True)

    async def _send(self, send: Send) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})
        await _part(send, b"--" + BOUNDARY + b"\r\n")
        async for jpeg in self._stage.frames(self._name):
            head = b"Content-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg)
            # The boundary right after the picture: a browser shows a part when it sees the next one begin.
            await _part(send, head + jpeg + b"\r\n--" + BOUNDARY + b"\r\n")
        await send({"type": "http.response.body", "body": b"", "more_body": False})


async def _part(send: Send, body: bytes) -> None:
    await send({"type": "http.response.body", "body": body, "more_body": True})


async def _gone(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
