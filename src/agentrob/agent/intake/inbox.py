"""Accept events in order: claim commands in the journal, queue them, and end those whose post changed."""

from __future__ import annotations

import asyncio
import math
import time
import traceback
from dataclasses import replace
from datetime import datetime
from typing import Protocol
from uuid import uuid4

import structlog

from agentrob.agent.intake.triage import NOT_OBEYED, Route, TriagedPost
from agentrob.agent.queue.queue import CommandQueue, QueuedCommand
from agentrob.agent.store.journal import Journal
from agentrob.errors import JournalError
from agentrob.forums.protocol import Event
from agentrob.language.joint.parts import JointCommand
from agentrob.language.joint.reading import joint_command
from agentrob.mcp.metadata import split_tag
from agentrob.model import Command, EndReason, EventKind, Post

_TO_TAKE = frozenset({Route.READ, Route.STALE})
#: How often the journal notes the newest event while none concerns this robot; a restart receives those since then
#: again.
SAVE_S = 10.0
_log = structlog.get_logger()


class PostHandler(Protocol):
    """Carries out what the posts of an inbox ask for; the robot's agent implements it."""

    @property
    def journal(self) -> Journal:
        """The robot's journal. Raises `JournalError` before it was opened."""

    def why_stopped(self, posted_at: datetime) -> EndReason | None:
        """Return why a post of that time may not move the robot, if a stop came after it; None if it may."""

    async def settle(self, post: Post, triaged: TriagedPost) -> TriagedPost:
        """Wait until the forum's clock is known; return how the post is triaged then."""

    def enqueue(self, job: QueuedCommand) -> None:
        """Start a command."""

    def decline(self, command: Command) -> None:
        """Report that a command could not be recorded."""

    async def decide(self, post: Post, triaged: TriagedPost) -> None:
        """Handle a post that approves or denies a command."""

    async def cancel(self, post: Post) -> None:
        """Handle a post that cancels the schedules of its thread."""

    async def renew(self, post: Post, triaged: TriagedPost) -> None:
        """Handle a post that renews the schedules of its thread."""

    async def amend(self, post: Post) -> None:
        """Update or end the schedule of a post that was edited or removed, if it has one."""


class Inbox:
    """Handles one robot's events in order."""

    def __init__(self, robot: str, queue: CommandQueue, handler: PostHandler) -> None:
        #: Posts of commands that have been received and are not queued yet.
        self.coming: dict[str, Post] = {}
        #: Commands that an earlier process claimed and that are not queued yet.
        self.left_open: frozenset[str] = frozenset()
        self._ended: dict[str, EndReason] = {}
        self._robot = robot
        self._queue = queue
        self._handler = handler
        self._waiting: asyncio.Queue[tuple[Event, TriagedPost]] = asyncio.Queue()

    @property
    def empty(self) -> bool:
        return self._waiting.empty() and not self.coming

    def put(self, event: Event, triaged: TriagedPost) -> None:
        """Queue an event for `take_all`. Never waits."""
        post = event.post
        if post is not None and event.kind is EventKind.POST_CREATED and triaged.route in _TO_TAKE:
            if post.id in self.left_open and post.id not in self.coming:  # heard anew, and so after those stops
                self._ended.pop(post.id, None)
            self.coming[post.id] = post
        self._waiting.put_nowait((event, triaged))

    def end_coming(self, why: EndReason = EndReason.STOP, until: datetime | None = None) -> None:
        """End what has been received and is not queued yet: all of it, or what was posted `until` then."""
        ended = [post.id for post in self.coming.values() if until is None or post.created_at <= until]
        ended += self.left_open if until is None else ()
        for post_id in ended:
            self._ended.setdefault(post_id, why)

    def clear_left_open(self) -> None:
        """Everything that an earlier process claimed is queued now."""
        self.left_open = frozenset()
        self._ended = {post_id: why for post_id, why in self._ended.items() if post_id in self.coming}

    def ended(self, post_id: str) -> EndReason | None:
        """Why a post that is not queued yet may not move, whatever its time; None if it may."""
        return self._ended.get(post_id)

    def clear(self) -> None:
        while not self._waiting.empty():
            self._waiting.get_nowait()
        self.coming.clear()
        self._ended.clear()

    async def take_all(self) -> None:
        """Handle events until cancelled."""
        saved_s = -math.inf
        while True:
            event, triaged = await self._waiting.get()
            save = triaged.route is not Route.NOTHING or time.monotonic() - saved_s > SAVE_S
            await self._take(event, triaged, save)
            saved_s = time.monotonic() if save else saved_s

    async def take_waiting(self) -> None:
        """Handle the events that have been received so far."""
        while not self._waiting.empty():
            await self._take(*self._waiting.get_nowait(), save=True)

    async def _take(self, event: Event, triaged: TriagedPost, save: bool) -> None:
        """Accept an event. `save`: a restart continues after it."""
        try:
            await self.accept(event, triaged)
            if save and event.id:
                await self._handler.journal.put_all(cursor=event.id, cursor_at=event.at.isoformat())
        except JournalError as e:
            _log.error("post not taken: nothing moves without the journal", robot=self._robot, error=str(e))
            self._not_taken(event, triaged)
        except Exception:  # no post ends the agent, which must hear the next stop
            _log.error("post not taken", robot=self._robot, trace=traceback.format_exc())
            self._not_taken(event, triaged)
        finally:
            if event.post is not None:
                self.coming.pop(event.post.id, None)
                self._ended.pop(event.post.id, None)

    def _not_taken(self, event: Event, triaged: TriagedPost) -> None:
        """Report that a command could not be accepted, unless it is already queued."""
        post = event.post
        if post is None or event.kind is not EventKind.POST_CREATED or triaged.route not in _TO_TAKE:
            return
        if self._queue.find(post.id) is None:
            self._handler.decline(self._command(post, triaged))

    async def accept(self, event: Event, triaged: TriagedPost) -> None:
        """Start a command, or carry out what else a post says; end a command whose post was edited or removed."""
        post = event.post
        if post is None:
            return
        if event.kind is not EventKind.POST_CREATED:
            if post.author.kind not in NOT_OBEYED:  # robots do not command; most edits of a fleet are its robots'
                await self._end_amended(post)
                await self._handler.amend(post)
            return
        if triaged.route not in (Route.CANCEL, Route.STOP, Route.HALT, Route.NOTHING):
            triaged = await self._handler.settle(post, triaged)
        match triaged.route:
            case Route.CANCEL:
                await self._handler.cancel(post)
            case Route.RENEW:
                await self._handler.renew(post, triaged)
            case Route.APPROVE | Route.DENY:
                await self._handler.decide(post, triaged)
            case Route.READ | Route.STALE:
                await self._take_command(post, triaged)

    async def _take_command(self, post: Post, triaged: TriagedPost) -> None:
        """Claim the post of a command, or each part that this robot has of it, and start it."""
        if triaged.route is Route.STALE or post.version > 1:
            ended: EndReason | None = EndReason.STALE if triaged.route is Route.STALE else EndReason.EDITED
        else:
            ended = self._why_stopped(post)
        for command in self._commands(post, triaged):
            await self._start(post, command, ended)

    async def _start(self, post: Post, command: Command, ended: EndReason | None) -> None:
        claim = await self._handler.journal.claim(command, ended)
        if not claim.new:
            return
        if (tag := split_tag(post.raw, post.author)[1]) is not None:  # an agent asked: its own trace finds this one
            _log.info("asked by an agent", post=post.id, trace_id=claim.command.trace_id, asked_in=tag.trace_id)
        job = QueuedCommand(claim.command, ended=ended)
        came = self._why_stopped(post) if ended is None else None  # while the claim was written
        if came is not None:
            job.end(came)
        self._handler.enqueue(job)
        if came is not None:
            await self._handler.journal.end([command.key], came)

    def _why_stopped(self, post: Post) -> EndReason | None:
        return self.ended(post.id) or self._handler.why_stopped(post.created_at)

    async def _end_amended(self, post: Post) -> None:
        """End the command of a post that was edited or removed."""
        for job in [job for job in self._queue if job.command.post_id == post.id]:
            if post.removed:
                why = EndReason.REMOVED
            elif not job.moving and post.content_hash != job.command.content_hash:
                why = EndReason.EDITED
            else:
                continue
            job.end(why)
            await self._handler.journal.end([job.command.key], why)

    def _commands(self, post: Post, triaged: TriagedPost) -> list[Command]:
        """The command of a post; of a post to several robots that wait for each other, one for each part of this
        robot."""
        command, joint = self._command(post, triaged), joint_command(triaged.text)
        mine = joint.of(self._robot) if isinstance(joint, JointCommand) else ()
        if not mine or not isinstance(joint, JointCommand):
            return [command]
        return [
            replace(command, part=part.number, parts=len(joint.parts), further=at > 0, trace_id=uuid4().hex[:12])
            for at, part in enumerate(mine)
        ]

    def _command(self, post: Post, triaged: TriagedPost) -> Command:
        return Command(
            post.id, post.topic_id, post.content_hash, post.author, self._robot, triaged.text, triaged.language,
            post.created_at, uuid4().hex[:12],
        )  # fmt: skip
