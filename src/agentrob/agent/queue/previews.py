"""Make and show the preview of a command, from where the robots stand now. The driver is only read."""

from __future__ import annotations

import asyncio
import math
import time
import zlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from functools import partial

import structlog

from agentrob.agent.media.geometry import Geometry
from agentrob.agent.media.plot import preview_plot
from agentrob.agent.media.replay import encoded, preview_log
from agentrob.agent.media.room_map import RoomMap
from agentrob.agent.queue.queue import QueuedCommand
from agentrob.agent.reporting.command_page import TRIES
from agentrob.agent.reporting.status_post import retry_until_answered
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumError
from agentrob.forums.protocol import Fleet, Forum, PosePages
from agentrob.model import Capabilities, Command, Plan, Pose
from agentrob.rehearsal.client import rehearse
from agentrob.rehearsal.preview import OtherRobot, Preview, PreviewRequest
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.safety.guard import PREPARE_S

#: A robot that stands further from where its approved preview begins would do something else than what was approved.
PLACE_M, PLACE_RAD = 0.3, math.radians(20.0)
#: How long to wait for the home of a simulated robot, as its guard does before a step, and how often to look.
LOOK_S = 0.1
_log = structlog.get_logger()


@dataclass
class Previews:
    """The previews of one robot. `rehearse` makes them."""

    name: str
    settings: RobotConfig
    forum: Forum
    driver: DriverClient
    room: RoomMap
    geometry: Geometry
    rehearse: Callable[[PreviewRequest, Capabilities], Awaitable[Preview]] = rehearse
    _turn: asyncio.Lock = field(default_factory=asyncio.Lock)  # one at a time: each takes seconds of a processor

    async def make(self, command: Command, plan: Plan) -> Preview:
        """Return what a plan is expected to do from here, once earlier previews of this robot are made. Raises
        `RobotError` if the driver does not answer."""
        async with self._turn:
            return await self._made(command, plan)

    async def _made(self, command: Command, plan: Plan) -> Preview:
        capabilities, state, asked_s = await self.driver.capabilities(), await self.driver.state(), time.monotonic()
        while self.settings.homes_itself and not state.homed and time.monotonic() - asked_s < PREPARE_S:
            await asyncio.sleep(LOOK_S)  # its driver just began
            state = await self.driver.state()
        posture = await self.driver.posture(joints=False) if state.homed else None
        stands = posture.pose if posture is not None else None
        others = await self._others()
        halted = (state.lock.why if state.lock is not None else "") or "The robot is locked"
        request = PreviewRequest(
            self.name,
            self.settings,
            plan,
            start=self.room.in_room(stands) if stands is not None else None,
            home=self.room.in_room(Pose(0.0, 0.0, 0.0)),
            mode=state.mode,
            battery_percent=state.battery_percent,
            halted=halted if state.halted else "",
            others=others or (),
            others_known=others is not None,
            seed=zlib.crc32(command.content_hash.encode()),
        )
        return await self.rehearse(request, capabilities)

    async def unless_ended(self, job: QueuedCommand, plan: Plan) -> Preview | None:
        """Return the preview of a command; None if the command is ended first. Its process has ended then."""
        making = asyncio.ensure_future(self.make(job.command, plan))

        async def made() -> Preview:
            return await making

        try:
            return await job.unless_ended(made())
        finally:
            making.cancel()
            await asyncio.wait({making})

    def draw(self, preview: Preview) -> bytes | None:
        """Return its paths in the room as PNG; None without a path. Takes about 0.1 s: call it in a thread."""
        return preview_plot(preview, self.room.as_data())

    async def publish(self, preview: Preview, page: str) -> None:
        """Publish one of its runs as the replay of a command, if the forum replays commands. `page` is the post with
        the command's page."""
        if not isinstance(self.forum, PosePages) or not page:
            return
        head = {"robot": self.name, "map": self.room.as_data(), "geometry": await self.geometry.publish()}
        if replay := await asyncio.to_thread(lambda: encoded(preview_log(preview), simulated=True, **head)):
            await retry_until_answered(partial(self.forum.publish_replay, page, replay), TRIES)

    async def moved_since(self, start: Pose) -> float | None:
        """Return how far the robot stands from where an approved preview begins, in metres, if that is another place.
        Raises `RobotError` if the driver does not answer."""
        posture = await self.driver.posture(joints=False)
        if posture.pose is None:
            return None  # without a home the guard moves nothing
        now = self.room.in_room(posture.pose)
        metres = math.hypot(now.x_m - start.x_m, now.y_m - start.y_m)
        turned = abs(math.remainder(now.yaw_rad - start.yaw_rad, math.tau))
        return metres if metres > PLACE_M or turned > PLACE_RAD else None

    async def _others(self) -> tuple[OtherRobot, ...] | None:
        """The other robots of this room, as their agents last published them; None if the forum does not say."""
        if not isinstance(self.forum, Fleet):
            return None
        try:
            fleet = await self.forum.fleet()
        except ForumError as e:
            _log.info("other robots not known", robot=self.name, error=str(e))
            return None
        return tuple(
            OtherRobot(robot.name, robot.model, robot.pose)
            for robot in fleet
            if robot.name != self.name and robot.pose is not None and robot.room == self.room.name
        )
