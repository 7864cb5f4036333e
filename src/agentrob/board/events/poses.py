"""Where robots are, in memory, for the viewers of live maps: each pose is encoded once and sent to all of them.

A viewer that reads slowly misses poses, since newer ones follow; nothing is queued for it. The planned path of a
command comes once, so each viewer gets it with the next message that it reads.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from agentrob.board.events import streams
from agentrob.errors import BoardError

#: Seconds between two messages to a viewer of the map, whose page moves the robot smoothly, and of the 3D view.
MAP_EVERY_S, BODY_EVERY_S = 0.2, 0.12
#: A robot whose agent sent no pose for this many seconds must be notified of its viewers.
SHOWING_S = 1.0
#: A limit for each account, and for all.
MOST_STREAMS, MOST_PER_ACCOUNT = 500, 100
#: Points of the measured path that are kept, and the distance between two of them.
MOST_TRAIL, TRAIL_M = 500, 0.03
#: PostgreSQL delivers notifications of at most 8000 bytes.
MOST_SHARED = 7000

Point = Sequence[float]


@dataclass(slots=True)
class RobotPoses:
    """The newest pose of one robot, the planned path of its command and the measured one so far.

    `called_s` (monotonic) is when its agent was last notified of viewers, `call` the timer of the next time. `viewers`
    are those of this process, `elsewhere` those of other processes.
    """

    name: str
    poses: int = 0
    paths: int = 0
    pose_s: float = 0.0
    frame: Mapping[str, Any] = field(default_factory=dict)
    plan: Sequence[Point] = ()
    trail: list[Point] = field(default_factory=list)
    paths_shared: int = 0
    message: bytes = b""
    with_body: bytes = b""
    viewers: int = 0
    elsewhere: int = 0
    called_s: float = -1.0
    call: asyncio.TimerHandle | None = None

    @property
    def watched(self) -> int:
        """The number of viewers on all processes."""
        return self.viewers + self.elsewhere

    @property
    def kept_waiting(self) -> bool:
        """Whether it has viewers but its agent sends no poses."""
        return self.watched > 0 and time.monotonic() - self.pose_s > SHOWING_S

    def take(self, frame: Mapping[str, Any], at_s: float) -> None:
        """Store a pose: `pose`, `body`, and with a new command its `plan` and `trail`."""
        if "plan" in frame:
            self.plan, self.trail = frame["plan"], list(frame.get("trail", ()))
            self.paths += 1
        x, y = frame["pose"][:2]
        last = self.trail[-1] if self.trail else None
        if last is None or abs(x - last[0]) + abs(y - last[1]) > TRAIL_M:
            self.trail.append((x, y))
            del self.trail[:-MOST_TRAIL]
        self.frame, self.pose_s = frame, at_s
        self.poses += 1
        facts = {"robot": self.name, "t": round(1000 * at_s), "pose": frame["pose"]}
        self.message = _message(facts)
        self.with_body = _message(facts | {"body": frame["body"]}) if frame.get("body") else self.message

    @property
    def path(self) -> dict[str, Any]:
        """The planned path and the measured one so far."""
        return {"plan": list(self.plan), "trail": self.trail}


class _Channel:
    """The viewers that watch the same robots in the same detail. One task composes each message for all of them."""

    def __init__(self, robots: Sequence[RobotPoses], body: bool) -> None:
        self.robots, self.body = robots, body
        self.waiters: set[asyncio.Future[bytes]] = set()
        self.viewers = 0
        self.changed = asyncio.Event()
        self.task: asyncio.Task[None] | None = None

    def now(self) -> bytes:
        """The poses that are not old, for a new viewer."""
        fresh_s = time.monotonic() - SHOWING_S
        return b"".join(self._pose(robot) for robot in self.robots if robot.pose_s > fresh_s)

    def paths(self, seen: dict[str, int]) -> bytes:
        """The paths that a viewer has not got yet; `seen` counts those that it got, by robot, and is updated."""
        new = [robot for robot in self.robots if robot.poses and robot.paths != seen.get(robot.name)]
        seen.update((robot.name, robot.paths) for robot in new)
        return b"".join(_message({"robot": robot.name, **robot.path}) for robot in new)

    def _pose(self, robot: RobotPoses) -> bytes:
        return robot.with_body if self.body else robot.message

    async def run(self) -> None:
        seen = [robot.poses for robot in self.robots]
        while True:
            await self.changed.wait()
            self.changed.clear()
            new = [robot for robot, poses in zip(self.robots, seen, strict=True) if robot.poses != poses]
            seen = [robot.poses for robot in self.robots]
            if message := b"".join(map(self._pose, new)):
                waiters, self.waiters = self.waiters, set()
                for waiter in waiters:
                    if not waiter.done():
                        waiter.set_result(message)
            await asyncio.sleep(BODY_EVERY_S if self.body else MAP_EVERY_S)


class PoseTracker:
    """The poses of all robots. Use it on the event loop only.

    `changed` is called with a robot's name and `pose` or `viewers`, to share the change with other processes.
    """

    def __init__(self) -> None:
        self.changed: Callable[[str, str], None] = lambda robot, what: None
        self._robots: dict[str, RobotPoses] = {}
        self._channels: dict[tuple[tuple[str, ...], bool], _Channel] = {}
        self._accounts: dict[str | None, int] = {}

    def robots(self) -> tuple[RobotPoses, ...]:
        return tuple(self._robots.values())

    def robot(self, name: str) -> RobotPoses:
        """The robot of this name. The caller checks that there is such an account."""
        return self._robots.setdefault(name, RobotPoses(name))

    def show(self, name: str, frame: Mapping[str, Any]) -> tuple[int, bool]:
        """Store a new pose for its viewers; return their number, and whether some see the 3D view."""
        robot = self._take(name, frame, time.monotonic())
        if robot.elsewhere:
            self.changed(name, "pose")
        body = robot.elsewhere > 0 or any(c.body and robot in c.robots for c in self._channels.values())
        return robot.watched, body

    def receive(self, name: str, text: str) -> None:
        """Store a pose that another process received. Raises `ValueError` for anything else."""
        frame = json.loads(text)
        if not isinstance(frame, dict) or not isinstance(frame.get("pose"), list):
            raise ValueError("not a pose")
        self._take(name, frame, time.monotonic())

    def shared(self, name: str) -> str:
        """The newest pose for other processes, short enough for a notification."""
        robot = self.robot(name)
        frame = {key: part for key, part in robot.frame.items() if key not in ("plan", "trail")}
        if robot.paths != robot.paths_shared:  # it may have come with an older pose
            robot.paths_shared = robot.paths
            frame |= robot.path
        text = json.dumps(frame, separators=(",", ":"))
        if len(text) > MOST_SHARED:
            text = json.dumps({**frame, "plan": [], "trail": []}, separators=(",", ":"))
        return text

    def receive_viewers(self, elsewhere: Mapping[str, int]) -> None:
        """Set the number of viewers on other processes, by robot."""
        for name in elsewhere.keys() | self._robots.keys():
            self.robot(name).elsewhere = elsewhere.get(name, 0)

    def _take(self, name: str, frame: Mapping[str, Any], at_s: float) -> RobotPoses:
        robot = self.robot(name)
        robot.take(frame, at_s)
        for channel in self._channels.values():
            if robot in channel.robots:
                channel.changed.set()
        return robot

    # ---------------------------------------------------------------- viewers
    def check(self, account: str | None) -> None:
        """503 if there are too many viewers, 429 if this account has too many."""
        if sum(self._accounts.values()) >= MOST_STREAMS:
            raise BoardError(503, "no_more_streams", "too many live maps are open", "close one of them", 5.0)
        if self._accounts.get(account, 0) >= MOST_PER_ACCOUNT:
            hint = f"at most {MOST_PER_ACCOUNT}: close one of them"
            raise BoardError(429, "too_many_streams", "this account has too many live maps open", hint, 5.0)

    def enter(self, names: Sequence[str], body: bool, account: str | None) -> _Channel:
        """Add a viewer of these robots; end it with `leave`."""
        key = tuple(names), body
        channel = self._channels.get(key)
        if channel is None:
            channel = self._channels[key] = _Channel([self.robot(name) for name in names], body)
            channel.task = asyncio.create_task(channel.run())
        channel.viewers += 1
        self._accounts[account] = self._accounts.get(account, 0) + 1
        self._look(channel, 1)
        return channel

    def leave(self, channel: _Channel, account: str | None) -> None:
        channel.viewers -= 1
        self._accounts[account] -= 1
        if not self._accounts[account]:
            del self._accounts[account]
        self._look(channel, -1)
        if not channel.viewers:
            del self._channels[tuple(robot.name for robot in channel.robots), channel.body]
            if channel.task is not None:
                channel.task.cancel()

    def _look(self, channel: _Channel, viewers: int) -> None:
        for robot in channel.robots:
            robot.viewers += viewers
            self.changed(robot.name, "viewers")


class PoseStream(Response):
    """The poses of some robots as server-sent events, until the viewer leaves or may no longer see them."""

    media_type = "text/event-stream"

    def __init__(
        self,
        tracker: PoseTracker,
        names: Sequence[str],
        body: bool,
        account: str | None,
        allowed: Callable[[], bool],
        ended: asyncio.Event,
    ) -> None:
        super().__init__(headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})
        del self.headers["content-length"]
        self._tracker, self._account, self._allowed, self._ended = tracker, account, allowed, ended
        self._names, self._body = names, body

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        channel = self._tracker.enter(self._names, self._body, self._account)
        try:
            await streams.run(self._send(send, channel), receive, send, self._allowed, self._ended)
        finally:
            self._tracker.leave(channel, self._account)

    async def _send(self, send: Send, channel: _Channel) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})
        seen: dict[str, int] = {}
        await streams.part(send, b"retry: 2000\n\n" + channel.paths(seen) + channel.now())
        loop = asyncio.get_running_loop()
        while True:
            waiter: asyncio.Future[bytes] = loop.create_future()
            channel.waiters.add(waiter)
            try:
                message = await waiter
            finally:
                channel.waiters.discard(waiter)
            await streams.part(send, channel.paths(seen) + message)


def _message(data: Mapping[str, Any]) -> bytes:
    return b"data: " + json.dumps(data, separators=(",", ":")).encode() + b"\n\n"
