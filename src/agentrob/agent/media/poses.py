"""Sample the robot's pose while somebody watches its map or while it carries out a command.

Watchers get the newest pose only, and only while there are any: a pose that the forum is too slow for is dropped. The
poses of a command are kept for its replay, also in a file, for a report after a restart. Neither delays a motion, a
stop or a reply.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import structlog

from agentrob.agent.media.pose_files import PoseFiles, PoseLines
from agentrob.agent.media.replay import PoseLog, PoseSample, encoded
from agentrob.agent.media.room_map import RoomMap
from agentrob.errors import ForumError, ForumUnoffered, RobotError
from agentrob.forums.protocol import PosePages
from agentrob.language.messages.plan_text import step_label
from agentrob.model import Pose, Primitive
from agentrob.robots.driver.client import DriverClient

#: How often the pose is sampled for the 3D view, for a map, and for the replay of a robot that has no shape, which its
#: page draws on the map only: a worker with many robots must not pay for more.
HZ, MAP_HZ, PLAIN_HZ = 10.0, 5.0, 2.5
#: An older posture is not shown: the robot may be anywhere.
OLD_S = 1.0
#: A pose is still sampled this long after a command, so that its replay shows the end.
LINGER_S = 0.6
AGAIN_S = 1.0
#: How often new poses of a command are written to its file, and how long the end of a motion waits for that.
WRITE_S, WRITTEN_S = 1.0, 0.5
#: A replay has at least so many poses.
FEWEST_POSES = 2
#: How many commands' poses wait for their reports.
LOGS = 4
#: Points of the measured path that a new watcher gets, and the distance between two of them.
MOST_TRAIL, TRAIL_M = 300, 0.03
_log = structlog.get_logger()


class PoseSampler:
    """Samples one robot's poses. `pages` is the forum, None if it shows no live poses: then nothing is sampled.
    `shaped`: whether the robot's shape may be known, so that replays need its joint angles. `files` keep the poses of
    commands until their replays are published."""

    def __init__(
        self,
        pages: PosePages | None,
        driver: DriverClient,
        robot: str,
        room: RoomMap,
        files: PoseFiles,
        *,
        shaped: Callable[[], bool],
    ) -> None:
        self._shaped, self._files = shaped, files
        self._unwritten: tuple[str, PoseLines] | None = None
        self._writing: asyncio.Task[None] | None = None
        self._written_s = -math.inf
        self._pages, self._driver, self._robot, self._room = pages, driver, robot, room
        self._watched = self._body = False
        self._watches = 0
        self._running: PoseLog | None = None
        self._until_s = -math.inf
        self._steps: Sequence[Primitive] = ()
        self._logs: dict[str, PoseLog] = {}
        self._newest: PoseSample | None = None
        self._sent: PoseLog | None = None
        self._wanted, self._fresh = asyncio.Event(), asyncio.Event()

    def watch(self) -> None:
        """Somebody watches: send poses until the forum says that nobody does."""
        self._watched = True
        self._watches += 1
        self._sent = None
        self._wanted.set()

    @contextlib.contextmanager
    def recording(self, post_id: str, steps: Sequence[Primitive]) -> Iterator[None]:
        """Keep the poses of a command until the context ends. Neither waits nor raises."""
        if self._pages is None:
            yield
            return
        self._running, self._steps = PoseLog(), steps
        self._logs[post_id] = self._running
        self._unwritten = post_id, PoseLines(self._running)
        while len(self._logs) > LOGS:  # of commands that never got a report
            del self._logs[next(iter(self._logs))]
        self._until_s = math.inf
        self._wanted.set()
        try:
            yield
        finally:
            self._until_s = time.monotonic() + LINGER_S

    def begin_step(self, step: Primitive) -> None:
        """Note that a step of the running command begins."""
        if self._running is not None:
            self._running.steps.append((time.monotonic(), step_label(step, "en")))

    async def written(self) -> None:
        """Write the poses of the running command to its file, before its end is recorded. Waits `WRITTEN_S` at most."""
        if self._writing is not None:
            await asyncio.wait({self._writing}, timeout=WRITTEN_S)
        if self._write():
            assert self._writing is not None
            await asyncio.wait({self._writing}, timeout=WRITTEN_S)

    def _write(self) -> bool:
        """Begin to write what is new, unless an earlier write still runs."""
        if self._unwritten is None or (self._writing is not None and not self._writing.done()):
            return False
        post_id, lines = self._unwritten
        self._written_s = time.monotonic()
        new = lines.take()
        if new:
            self._writing = asyncio.create_task(self._append(post_id, new))
        return bool(new)

    async def _append(self, post_id: str, lines: Sequence[str]) -> None:
        try:
            await asyncio.to_thread(self._files.append, post_id, lines)
        except OSError as e:  # only a restart would need it
            _log.info("poses not written", robot=self._robot, error=str(e))
            self._unwritten = None

    async def replay(self, post_id: str, geometry: str) -> bytes:
        """The gzipped replay of a command; nothing if no poses were known. The same until `forget`. After a very short
        command it waits for the poses that are still to come."""
        log = self._logs.get(post_id) or await asyncio.to_thread(self._files.read, post_id)
        if log is None:
            return b""
        if log is self._running and len(log.samples) < FEWEST_POSES and math.isfinite(self._until_s):
            await asyncio.sleep(max(0.0, self._until_s - time.monotonic()))
        room = self._room.as_data()
        head = {"robot": self._robot, "map": room, "geometry": geometry}
        return await asyncio.to_thread(encoded, log, **head)

    async def left(self) -> list[str]:
        """Commands of an earlier process whose replays were not published."""
        return await asyncio.to_thread(self._files.left)

    async def forget(self, post_id: str) -> None:
        """Drop the poses of a command whose replay is published or is not wanted."""
        self._logs.pop(post_id, None)
        if self._unwritten is not None and self._unwritten[0] == post_id:
            self._unwritten = None
        if self._writing is not None:
            await asyncio.wait({self._writing}, timeout=WRITTEN_S)
        await asyncio.to_thread(self._files.forget, post_id)

    # ------------------------------------------------------------------ sampling and sending
    async def run(self) -> None:
        """Sample and send until cancelled."""
        if self._pages is None:
            return
        sending = asyncio.create_task(self._send(self._pages))
        try:
            await self._sample()
        finally:
            sending.cancel()

    async def _sample(self) -> None:
        while True:
            if not self._watched and time.monotonic() > self._until_s:
                self._write()
                self._running, self._body = None, False
                self._wanted.clear()
                await self._wanted.wait()
            begun_s = time.monotonic()
            try:
                await self._take()
            except RobotError as e:
                _log.info("no pose", robot=self._robot, error=str(e))
                await asyncio.sleep(AGAIN_S)
            await asyncio.sleep(max(0.0, 1.0 / self._hz - (time.monotonic() - begun_s)))

    @property
    def _hz(self) -> float:
        if self._body or (self._running is not None and self._shaped()):
            return HZ
        return MAP_HZ if self._watched else PLAIN_HZ

    async def _take(self) -> None:
        posture = await self._driver.posture(joints=self._shaped() and (self._body or self._running is not None))
        if posture.pose is None or posture.age_s > OLD_S:
            return
        self._newest = sample = PoseSample(time.monotonic(), self._room.in_room(posture.pose), posture)
        if (log := self._running) is not None and sample.at_s <= self._until_s:
            if not log.samples:
                log.plan = self._room.planned(sample.pose, self._steps)
            log.add(sample)
            if sample.at_s - self._written_s > WRITE_S:
                self._write()
        self._fresh.set()

    async def _send(self, pages: PosePages) -> None:
        while True:
            await self._fresh.wait()
            self._fresh.clear()
            if not self._watched or self._newest is None:
                continue
            log, begun_s, watches = self._running, time.monotonic(), self._watches
            try:
                frame = self._frame(self._newest, log)
                seen = await pages.publish_pose(self._robot, frame)
                if watches == self._watches:  # else somebody came meanwhile, who needs the planned path too
                    self._watched, self._body = seen.viewers > 0, seen.viewers > 0 and seen.body
                    self._sent = log if "plan" in frame else self._sent  # a command that just began has no plan yet
                await asyncio.sleep(max(0.0, seen.every_s - (time.monotonic() - begun_s)))
            except ForumError as e:
                if not isinstance(e, ForumUnoffered):
                    _log.info("pose not sent", robot=self._robot, error=str(e))
                self._watched = False  # the forum says so again while somebody watches
            except Exception:
                self._watched = False
                raise

    def _frame(self, sample: PoseSample, log: PoseLog | None) -> dict[str, Any]:
        """A frame for the forum: pose, body, and with the first pose of a command its planned and measured path."""
        pose = [round(v, 3) for v in (sample.pose.x_m, sample.pose.y_m, sample.pose.yaw_rad)]
        frame: dict[str, Any] = {"pose": pose, "body": sample.body if self._body else []}
        if log is not None and log is not self._sent and log.samples:
            frame |= {"plan": log.plan, "trail": trail_of(log)}
        return frame


def trail_of(log: PoseLog) -> list[tuple[float, float]]:
    """The measured path, with a point every few centimetres."""
    trail: list[tuple[float, float]] = []
    for sample in log.samples:
        point = round(sample.pose.x_m, 3), round(sample.pose.y_m, 3)
        if not trail or math.dist(point, trail[-1]) >= TRAIL_M:
            trail.append(point)
    return trail[-MOST_TRAIL:]


def has_moved(before: Pose | None, now: Pose, far_m: float = 0.05, far_rad: float = 0.1) -> bool:
    """Whether a pose differs by more than a standing robot sways."""
    if before is None:
        return True
    turned_rad = abs(math.remainder(now.yaw_rad - before.yaw_rad, math.tau))
    return math.hypot(now.x_m - before.x_m, now.y_m - before.y_m) > far_m or turned_rad > far_rad
