"""Let a part of a post wait for the parts before it, and find out which robot does a part that one of several may do.

The wait is in the journal, so that it continues after a restart. What ends it is on the forum (`evidence`). After it,
rights, text, screen and limits are asked again like before every motion (laws 4 and 7); freshness counts from its end
(law 5).
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import structlog

from agentrob.agent.joint import evidence
from agentrob.agent.joint.evidence import Bidding, Ended, LeftTo, Released, Turn, Waiting
from agentrob.agent.joint.texts import bid_text, ended_because, left_because, takes_text, waits_text
from agentrob.agent.joint.thread import PartThreads
from agentrob.agent.media.room_map import RoomMap
from agentrob.agent.queue.queue import CommandQueue, QueuedCommand
from agentrob.agent.reporting.status_post import Shown, retry_until_answered
from agentrob.agent.store.journal import Journal
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumError, RobotError
from agentrob.forums.protocol import Forum
from agentrob.language.joint.parts import Choice, JointPart
from agentrob.language.messages.catalog import say
from agentrob.model import CommandState, EndReason, Post, StatusCard
from agentrob.model.estimate import seconds_of
from agentrob.robots.driver.client import DriverClient

#: How often the thread is read again, in case an event was missed.
READ_AGAIN_S = 5.0
#: How long after a robot took a part the thread is read, for a forum that shows posts of the same moment in turn.
SETTLE_S = 0.5
#: What a command takes whose time is not known, and how often a write is tried.
UNKNOWN_S, TRIES = 60.0, 9
_log = structlog.get_logger()


@dataclass
class PartWaits:
    """The waits of one robot's parts. `now` is the forum's clock, `poll_s` how often the forum is read where it sends
    no events, else 0."""

    name: str
    settings: RobotConfig
    forum: Forum
    driver: DriverClient
    journal: Journal
    queue: CommandQueue
    threads: PartThreads
    room: RoomMap
    now: Callable[[], datetime]
    poll_s: float = 0.0
    _bids: dict[str, StatusCard] = field(default_factory=dict)

    def part_of(self, job: QueuedCommand) -> JointPart:
        assert job.joint is not None
        return job.joint.part(job.command.part)

    # ---------------------------------------------------------------- for others
    async def wait(self, job: QueuedCommand) -> None:
        """Wait until the parts before this one are done, and then, for a part of one of several robots, until it is
        this one's turn. Ends the command if that does not come."""
        if job.ended is not None or job.begun:
            return
        job.waits_for_others = True
        try:
            if self.part_of(job).after:
                await self._wait_for_parts(job)
            if job.ended is None and self.part_of(job).choice is not Choice.NAMED:
                await self._bid(job)
        finally:
            job.waits_for_others = False
            if job.ended is not None:
                self._bids.pop(job.command.key, None)

    async def _wait_for_parts(self, job: QueuedCommand) -> None:
        assert job.joint is not None
        command, joint = job.command, job.joint
        kept = await self.journal.begin_wait(command.key, self.now())
        released_at, shown = kept.released_at, None
        while job.ended is None and released_at is None:
            heard = self.threads.heard
            posts = await self.threads.read_or_known(command)
            statuses = {n: evidence.status_of(joint.part(n), posts) for n in joint.part(command.part).after}
            match evidence.look_at(joint, command.part, statuses, command.posted_at, self.now()):
                case Released(at):
                    released_at = min(at, self.now()) if at is not None else self.now()
                    await self.journal.end_wait(command.key, released_at)
                case Ended(part, state):
                    await self._end(job, EndReason.DEPENDENCY, ended_because(joint.part(part), state, command.language))
                case Waiting(parts, until) as waiting:
                    waits_s = (until - self.now()).total_seconds()
                    if waiting != shown:  # not because time passed: some forums count edits
                        text = waits_text([joint.part(n) for n in parts], waits_s, command.language)
                        self._show(job, text, until=until.isoformat())
                        shown = waiting
                    await self._hold(job, heard, waits_s)
        if released_at is not None:
            age_s = max(0.0, (self.now() - released_at).total_seconds())
            job.fresh_s = time.monotonic() - age_s
            if job.ended is None and age_s > self.settings.max_post_age_s:
                await self._end(job, EndReason.EXPIRED)

    async def _hold(self, job: QueuedCommand, heard: int, seconds: float) -> None:
        """Let other commands pass until a robot shows something, or for this long, at most until the next reading."""
        wait_s = max(0.05, min(READ_AGAIN_S, seconds + 0.05))
        await self.queue.hold(job, wait_s, until=lambda: self.threads.heard != heard)

    async def _end(self, job: QueuedCommand, why: EndReason, because: str = "") -> None:
        if job.ended is None:
            job.because = because
            job.end(why)
            await self.journal.end([job.command.key], why)

    def _show(self, job: QueuedCommand, text: str, **more: Any) -> None:
        job.status.show(Shown(text, job.command.card(CommandState.QUEUED, **more)))

    # ---------------------------------------------------------------- one of several
    async def _bid(self, job: QueuedCommand) -> None:
        """Bid for a part, and wait until it is this robot's turn to take it, or until another took it."""
        part, command = self.part_of(job), job.command
        own = self._bids[command.key] = await self._bid_of(job)
        job.status.show(Shown(bid_text(part, own, command.language), own))
        since = self.now()
        window_s = evidence.BID_S + 2 * self.poll_s
        while job.ended is None:
            heard = self.threads.heard
            posts = await self.threads.read_or_known(command)
            match evidence.look_at_bids(part, own, posts, since, self.now(), window_s):
                case Turn():
                    return
                case LeftTo(robot):
                    await self.leave(job, robot, posts)
                case Ended():
                    await self._end(job, EndReason.DEPENDENCY, say("joint.because.nobody", command.language))
                case Bidding(until):
                    await self._hold(job, heard, (until - self.now()).total_seconds())

    async def _bid_of(self, job: QueuedCommand) -> StatusCard:
        """How soon this robot would be done with a part, how far it walks, its battery, and what it does before."""
        plan, ahead = self.part_of(job).plan, [other for other in self.queue if other is not job and other.ready]
        before_s = sum(UNKNOWN_S if other.left_s is None else other.left_s for other in ahead)
        battery, near_m = 0, None
        try:
            before_s += seconds_of(plan, await self.driver.capabilities())
            if (percent := (await self.driver.state()).battery_percent) is not None:
                battery = max(1, min(100, round(percent)))
            near_m = await self._metres_to(self.part_of(job).near)
        except RobotError as e:
            _log.info("bid without the robot's state", robot=self.name, error=str(e))
            before_s += UNKNOWN_S
        return job.command.card(
            CommandState.QUEUED, bid_s=max(1, math.ceil(before_s)), bid_cm=round(plan.distance_m * 100),
            near_cm=max(1, round(near_m * 100)) if near_m is not None else 0,
            room=self.room.name if near_m is not None else "", battery=battery, ahead=len(ahead),
        )  # fmt: skip

    async def _metres_to(self, thing: str) -> float | None:
        """How far the robot stands from a thing of its room's map, in metres; None if it does not know. Only robots of
        a room with a name have a frame in common."""
        if not thing or not self.settings.map.room or self.room.thing(thing) is None:
            return None
        posture = await self.driver.posture(joints=False)
        return self.room.metres_to(thing, posture.pose) if posture.pose is not None else None

    async def take(self, job: QueuedCommand) -> bool:
        """Take a part that one of several robots may do, now that it is this one's turn to move. Only the first robot
        whose post is in the thread does the part. Other parts are one's own already."""
        part, command = self.part_of(job), job.command
        if part.choice is Choice.NAMED:
            return True
        posts = await self.threads.read_or_known(command)
        if (taker := evidence.taker_of(part, posts)) and taker != self.name:  # while it waited for its turn
            await self.leave(job, taker, posts)
            return False
        bid = self._bids.get(command.key) or await self._bid_of(job)
        # In a final state: nothing waits in this post, so that no page offers to stop it.
        facts = {"bid_s": bid.bid_s, "bid_cm": bid.bid_cm, "near_cm": bid.near_cm, "battery": bid.battery}
        card = command.card(CommandState.ANSWERED, takes=1, room=bid.room, **facts)
        text = takes_text(part, bid, [bid, *evidence.bids_of(part, posts).values()], command.language)
        try:
            await retry_until_answered(
                lambda: self.forum.reply(
                    command.topic_id, text, key=f"take:{command.key}", reply_to=command.post_id, card=card
                ),
                TRIES,
            )
            await asyncio.sleep(SETTLE_S)
            posts = await retry_until_answered(lambda: self.threads.read(command), TRIES)
        except ForumError as e:
            _log.warning("part not taken", robot=self.name, post=command.post_id, error=str(e))
            await self._end(job, EndReason.DEPENDENCY, say("joint.because.not_taken", command.language))
            return False
        taker = evidence.taker_of(part, posts)
        if not taker:
            _log.warning("own post not found in its thread", robot=self.name, post=command.post_id)
            await self._end(job, EndReason.DEPENDENCY, say("joint.because.not_taken", command.language))
        elif taker != self.name:
            await self.leave(job, taker, posts)
        return job.ended is None

    async def leave(self, job: QueuedCommand, robot: str, posts: list[Post]) -> None:
        """Leave a part to the robot that took it first."""
        part = self.part_of(job)
        theirs, own = evidence.bids_of(part, posts).get(robot), self._bids.get(job.command.key)
        because = left_because(part, robot, theirs, own, job.command.language)
        job.left_to = robot
        await self._end(job, EndReason.LEFT, because)
