"""The agent of one robot: a post comes in, the robot moves, a reply goes out.

This module starts and ends the agent, receives events and accepts commands; `pipeline` carries out each command. Only
these two modules know all parts of the agent.
"""

from __future__ import annotations

import asyncio
import contextlib
import traceback
from collections.abc import Awaitable, Callable, Coroutine, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import structlog

from agentrob.agent.admission import Admission
from agentrob.agent.answers import Answers
from agentrob.agent.claims import Claims
from agentrob.agent.execution.room_entry import RoomEntry
from agentrob.agent.final_report import FinalReport
from agentrob.agent.intake.clock_check import ClockCheck
from agentrob.agent.intake.event_stream import EventStream
from agentrob.agent.intake.inbox import Inbox
from agentrob.agent.intake.rate_limit import RateLimiter
from agentrob.agent.intake.reconcile import close_unknown, gap_after, is_open, recent_posts
from agentrob.agent.intake.triage import Addressing, Route, TriagedPost, obeyed, triage
from agentrob.agent.joint.evidence import part_posts
from agentrob.agent.joint.summaries import PartSummaries
from agentrob.agent.joint.thread import PartThreads
from agentrob.agent.joint.waits import PartWaits
from agentrob.agent.live_view import LiveView
from agentrob.agent.media import plot
from agentrob.agent.media.image_store import ImageStore
from agentrob.agent.media.room_map import RoomMap
from agentrob.agent.motion import Motion
from agentrob.agent.outcomes import Outcomes
from agentrob.agent.pipeline import Pipeline
from agentrob.agent.progress import show_place
from agentrob.agent.queue.approvals import Approvals
from agentrob.agent.queue.previews import Previews
from agentrob.agent.queue.queue import CommandQueue, QueuedCommand
from agentrob.agent.queue.schedules import Schedules, lost_right
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting.activity import AgentActivity, process_name
from agentrob.agent.reporting.presence import reset_room
from agentrob.agent.reporting.room_text import on_card
from agentrob.agent.reporting.status_post import DeniedWrites, retry_until_answered
from agentrob.agent.stop.known_robots import KnownRobots
from agentrob.agent.stop.moderator_alert import ModeratorAlert
from agentrob.agent.stop.owner import OwnerActions
from agentrob.agent.stop.replies import StopReplies, StopReply
from agentrob.agent.stop.stop_handler import StopHandler
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.journals import SqliteJournals
from agentrob.agent.store.records import Records
from agentrob.agent.store.retention import keep_pruning, prune
from agentrob.agent.tasks import BackgroundTasks
from agentrob.agent.understanding import extract
from agentrob.agent.understanding.second_opinion import SecondOpinion
from agentrob.agent.understanding.surroundings import Surroundings
from agentrob.agent.understanding.understand import Assessor
from agentrob.config.robots import RobotConfig
from agentrob.errors import (
    ForumError,
    ForumNotFound,
    JournalError,
    RobotError,
    RobotUnreachable,
)
from agentrob.eyes.protocol import Detector
from agentrob.forums.protocol import BEFORE_ALL, Event, Events, Forum
from agentrob.language.messages.catalog import quote, say
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.protocol import ManagedMind, Mind
from agentrob.model import Account, Command, CommandState, Decision, EndReason, EventKind, Post, Report, StopResult
from agentrob.robots.driver.client import DriverClient
from agentrob.screening.rights import may
from agentrob.screening.screen import prepare as prepare_screen

#: How far back a first start looks: it replies to posts that they are too old, and closes claims that it does not know.
LOOK_BACK = timedelta(minutes=10)
#: How long a running command may take to post its end when the agent is ended.
SHUTDOWN_REPLY_S = 2.5
DRIVER_WAIT_S = 5.0
#: How long an agent that drains waits for final replies after the last motion.
REPLIES_S = 20.0
_log = structlog.get_logger()


class RobotAgent:
    """One robot's agent on one forum. `run()` until cancelled, or `once()`; then `close()`.

    `ready` is set when a post would be answered. `events` are the forum's events, if they are not read through `forum`
    itself. `open_journal` opens the robot's journal, by default in the folder `data`. Raises `JournalHeld` when another
    agent of this robot runs, `JournalError` when the robot was taken by another worker. `on_end` is called with each
    final report, `on_stop` with what each stop did, None if no driver was reached. `worker` names this process.
    `detector` finds things in the robot's pictures.
    """

    def __init__(
        self,
        name: str,
        settings: RobotConfig,
        forum: Forum,
        driver: DriverClient,
        mind: Mind,
        data: Path,
        store: ImageStore | None = None,
        on_end: Callable[[Report], None] = lambda _: None,
        listens: bool = True,
        opinion: SecondOpinion | None = None,
        events: Events | None = None,
        open_journal: Callable[[], Awaitable[Journal]] | None = None,
        on_stop: Callable[[StopResult | None], None] = lambda _: None,
        worker: str = "",
        detector: Detector | None = None,
    ) -> None:
        prepare_screen()  # not while it serves: stops would wait
        self.name = name
        self.settings = settings
        self.forum = forum
        self.driver = driver
        self.mind = mind
        self.opinion = opinion
        self.detector = detector
        self._store = store
        self.folder = data / "agents" / name
        self.ready = asyncio.Event()
        self._open_journal = open_journal or partial(SqliteJournals(data).open, name)
        self.tasks = BackgroundTasks(name)
        self.clock = ClockCheck(lambda: self.event_stream, self.tasks.spawn)
        self.event_stream = EventStream(events or forum, "", settings.poll_s, listens, self.clock.note)
        self._on_end = on_end
        self._on_stop = on_stop
        self.activity = AgentActivity(worker or process_name())
        self.records = Records(self.folder)
        self.queue = CommandQueue(self._queue_changed)
        self.threads = PartThreads(forum, self._parts_changed)
        self.inbox = Inbox(name, self.queue, self)
        self.moderator_alert = ModeratorAlert(forum, name, (*settings.moderators, settings.owner))
        self.stops = StopReplies(
            forum, driver, settings, self.event_stream.now, self._stop_reply, self.clock.settled, self._stopped
        )  # fmt: skip
        self.stop_handler = StopHandler(
            self.queue,
            self.inbox,
            self.stops,
            self.moderator_alert,
            lambda: self._journal,
            self.event_stream,
            self.tasks.spawn,
        )
        self.owner = OwnerActions(
            name, settings, forum, driver, self.stops, self.stop_handler, self.event_stream.now, self._queue_changed
        )  # fmt: skip
        self.writes = DeniedWrites()
        self.room = RoomEntry(driver, bool(settings.room), self._queue_changed)
        self.live_view = LiveView(
            name, settings, forum, driver, self.folder, self.queue, self.owner, self.activity,
            detector.things if detector else (), lambda: self._schedules.card if self._schedules is not None else {},
            lambda: on_card(self.room.awaited),
        )  # fmt: skip
        self._journal: Journal | None = None
        self._pipeline: Pipeline | None = None
        self._schedules: Schedules | None = None
        self._summaries: PartSummaries | None = None
        self._me: Account | None = None
        self._claimed_topics: frozenset[str] = frozenset()
        self.known_robots = KnownRobots(forum, self.tasks.spawn)
        self._accepting = True
        self._ending = False
        self._draining = asyncio.Event()

    # ------------------------------------------------------------------ life
    async def prepare(self) -> None:
        """Import everything whose import would delay stops later. Makes no requests."""
        plot.warm_up()
        await extract.prepare(self.mind)

    async def run(self, on_ready: Callable[[], None] = lambda: None) -> None:
        """Serve the forum until cancelled; then stop the robot and report a running command as interrupted. Returns
        after `drain`."""
        try:
            await self._start()
            self.activity.since = datetime.now(UTC)
            async with asyncio.TaskGroup() as group:
                pruning = keep_pruning(self.journal, self.records, self.settings.retention)
                works = (
                    self._listen(), self.inbox.take_all(), self.known_robots.list_later(), pruning,
                    self._watch_journal(), self.schedules.run(), self.pipeline.summaries.run(), *self._display_tasks(),
                )  # fmt: skip
                tasks = [group.create_task(work) for work in works]
                self.ready.set()
                on_ready()
                await self._until_drained()
                for task in tasks:
                    task.cancel()
        finally:
            await self._shut_down()

    async def once(self) -> None:
        """Handle everything new since the last run, then return. Stops are received meanwhile."""
        try:
            await self._start()
            self._accepting = False
            helpers = [asyncio.create_task(work) for work in (self._listen(), *self._display_tasks())]
            self.ready.set()
            try:
                await self.inbox.take_waiting()
                await self.schedules.step()
                # Commands that wait for an approval, another robot or the right to write continue to wait next time.
                while busy := self.tasks.running - self.queue.asking() - self.writes.tasks:
                    await asyncio.wait(busy, timeout=0.2)
                await self.pipeline.summaries.step()
                await prune(self.journal, self.records, self.settings.retention)
            finally:
                for helper in helpers:
                    helper.cancel()
        finally:
            await self._shut_down()

    def drain(self) -> None:
        """Finish the command that moves, begin no other, and end `run`. Stops are handled until then; commands that
        wait are continued by the next agent of this robot."""
        self._draining.set()

    async def _until_drained(self) -> None:
        await self._draining.wait()
        self.queue.close()
        if (job := self.queue.current) is not None and job.task is not None:
            await asyncio.wait({job.task})
        waiting = {task for job in self.queue for task in (job.task, job.asking)} | self.writes.tasks
        if replying := self.tasks.running - waiting:
            await asyncio.wait(replying, timeout=REPLIES_S)

    async def close(self) -> None:
        """Close journal, mind, forum and driver. Calling again does nothing."""
        if self._journal is not None:
            await self._journal.close()
            self._journal = None
        await self.forum.close()
        await self.driver.close()
        if isinstance(self.mind, ManagedMind):
            await self.mind.close()
        if self.opinion is not None:
            self.opinion.close()

    async def _start(self) -> None:
        if self.opinion is not None:
            self.tasks.spawn(self.opinion.warm())
        await self.prepare()
        self._journal = await self._open_journal()
        if self._journal.fence is not None:
            with contextlib.suppress(RobotUnreachable):  # the next lease tells the driver
                await self.driver.fence(self._journal.fence)
        self._me = await retry_until_answered(self.forum.me)
        if not self._me.speaks_for(self.name):
            _log.warning("this account is not the robot's own: its status cards do not count",
                         robot=self.name, account=self._me.name, kind=str(self._me.kind))  # fmt: skip
        await self.known_robots.list_robots()
        newest = await retry_until_answered(self.event_stream.set_clock)
        begun = await self.journal.get_time("watermark")
        if begun is None:
            at = (begun := self.event_stream.compared_at).isoformat()
            await self.journal.put_all(cursor=newest, cursor_at=at, watermark=at)
        self.clock.begin(begun)
        await self.stop_handler.remember(self.journal, begun)
        self.event_stream.cursor = await self.journal.get("cursor") or newest
        self._schedules = self._make_schedules()
        await self.schedules.load()
        self._pipeline = self._make_pipeline()
        await self._resume()
        if begun > self.event_stream.now() - LOOK_BACK and await self.journal.get("looked_back") is None:
            await self._look_back(self.event_stream.now() - LOOK_BACK, self.clock.watermark_at)
        self.tasks.spawn(self.pipeline.final_report.publish_left_replays())
        if isinstance(self.mind, ModelMind):
            self.tasks.spawn(self._warm(self.mind))

    async def _watch_journal(self) -> None:
        """End the agent when its journal is lost: another worker may hold the robot now."""
        await self.journal.until_lost()
        raise JournalError(f"this worker no longer holds the robot {self.name}")

    async def _warm(self, mind: ModelMind) -> None:
        """Let a local model server read the prompt before the first post."""
        with contextlib.suppress(RobotError):
            await mind.warm(await self.driver.capabilities())

    async def _resume(self) -> None:
        """Receive the events that were missed, above all stops, and then continue the open commands."""
        claims = await self.journal.open_claims()
        self._claimed_topics = frozenset(claim.command.topic_id for claim in claims)
        self.inbox.left_open = frozenset(claim.command.post_id for claim in claims)
        try:
            await self._catch_up()
        except ForumNotFound:
            if await self._recover_cursor():
                await self._catch_up()
        for claim in await self.journal.open_claims():
            begun = await self.journal.moved(claim.command.key)
            job = QueuedCommand(claim.command, known=True, begun=begun, admitted=begun, waited_s=claim.waited_s)
            job.asked = claim.asked
            limits = self.clock.watermark_at, self.stop_handler.stopped_at, self.settings.max_post_age_s
            why = self.inbox.ended(claim.command.post_id) or claim.why_not(self.event_stream.now(), *limits)
            if not begun and why:
                job.end(why)
                await self.journal.end([claim.command.key], why)
            self.enqueue(job)
        self._claimed_topics = frozenset()
        self.inbox.clear_left_open()

    async def _catch_up(self) -> None:
        """Receive the events that were missed; `ForumNotFound` as `EventStream.events`."""
        while events := await retry_until_answered(self.event_stream.missed):
            for event in events:
                self.event_stream.cursor = event.id
                self._handle_event_safely(event)

    async def _look_back(self, since: datetime, until: datetime) -> None:
        """Reply to posts of a time whose events the forum no longer sends, and close claims of a journal that was
        lost."""
        assert self._me is not None
        statuses = []
        with contextlib.suppress(ForumError):
            async for post in recent_posts(self.forum, self.settings.boards, since):
                if is_open(post, self._me) and post.reply_to not in self.inbox.coming:
                    statuses.append(post)
                elif post.created_at <= until:
                    triaged = self.triage(post)
                    if triaged.route is Route.READ:  # whether a stop came after it is unknown
                        triaged = replace(triaged, route=Route.STALE)
                    await self.inbox.accept(Event("", EventKind.POST_CREATED, post.created_at, post), triaged)
        self.tasks.spawn(self._close_unknown(statuses))

    async def _close_unknown(self, statuses: Sequence[Post]) -> None:
        await close_unknown(self.forum, self.journal, statuses, self.pipeline.claims.moves)
        await self.journal.put("looked_back", self.event_stream.now().isoformat())  # the next start need not

    async def _shut_down(self) -> None:
        """Stop the robot, give a running command a moment to post its end, and leave the rest to the next start."""
        self._ending = True
        self.queue.close()
        if (job := self.queue.moving) is not None:
            job.end(EndReason.SHUTDOWN)
            if job.task is not None:
                await asyncio.wait({job.task}, timeout=SHUTDOWN_REPLY_S)
        await self.tasks.cancel_all()
        await self.live_view.recorder.close()

    @property
    def me(self) -> Account | None:
        """Our own account; None before the forum was first reached."""
        return self._me

    @property
    def journal(self) -> Journal:
        if self._journal is None:
            raise JournalError("the agent has not been started")
        return self._journal

    @property
    def pipeline(self) -> Pipeline:
        if self._pipeline is None:
            raise JournalError("the agent has not been started")
        return self._pipeline

    @property
    def schedules(self) -> Schedules:
        if self._schedules is None:
            raise JournalError("the agent has not been started")
        return self._schedules

    def _make_schedules(self) -> Schedules:
        return Schedules(
            self.settings, self.forum, self.journal, self.queue, self.event_stream.now, self.stop_handler.why_not,
            self.enqueue, self.tasks.spawn, self.live_view.card_changed,
        )  # fmt: skip

    def _make_pipeline(self) -> Pipeline:
        names, live = self._addressing().names, self.live_view

        def ending() -> bool:
            return self._ending

        room = RoomMap(self.name, self.settings)
        previews = Previews(self.name, self.settings, self.forum, self.driver, room, live.geometry)
        approvals = Approvals(
            self.name,
            self._addressing().me.name,
            self.settings,
            self.forum,
            self.journal,
            self.queue,
            self.event_stream.now,
            self.tasks.spawn,
            previews,
        )
        admission = Admission(self.settings.rates, self.queue, RateLimiter(self.settings.rates))
        assessor = Assessor(
            names, self.settings, self.forum, self.driver, self.mind, self.journal, admission.over_limit, self.opinion,
            self.detector,
        )  # fmt: skip
        motion = Motion(
            self.name, self.settings, self.forum, self.driver, self.event_stream, self.stops, self.records,
            live.recorder, live.poses, Surroundings(self.settings.scene), assessor, self.room, ending,
            self._queue_changed,
        )  # fmt: skip
        outcomes = Outcomes(self.settings, self.journal, approvals, self.clock.was_set)
        answers = Answers(
            self.name, self.driver, self.detector is not None, self.journal, self.queue, self.stops, self.owner,
            admission, self.schedules, previews, outcomes,
        )  # fmt: skip
        claims = Claims(
            self.settings, self.forum, self.driver, self.journal, self.queue, self.writes, self.event_stream.now
        )  # fmt: skip
        final_report = FinalReport(
            self.name, self.forum, assessor, self.journal, self.records, live.recorder, self._store, self.writes,
            ending, self.owner, self._ended, live.poses, live.geometry, previews,
        )  # fmt: skip
        parts = PartWaits(
            self.name, self.settings, self.forum, self.driver, self.journal, self.queue, self.threads,
            room, self.event_stream.now, 0.0 if self.forum.live else self.settings.poll_s,
        )  # fmt: skip
        self._summaries = PartSummaries(self.forum, self.journal, self.threads, self.event_stream.now)
        return Pipeline(
            self.name, self.settings, self.forum, self.journal, self.queue, self.event_stream.now, assessor, claims,
            answers, admission, approvals, parts, self._summaries, motion, self.stops, outcomes, final_report,
        )  # fmt: skip

    def _ended(self, report: Report) -> None:
        self.activity.ended(report)
        if report.command.run is not None and lost_right(report.verdict):
            self.tasks.spawn(self.schedules.lose_right(report.command.post_id))
        self._on_end(report)

    def _stopped(self, result: StopResult | None) -> None:
        """Pass on what a stop did. An error in that never keeps the stop from being answered."""
        try:
            self.activity.stopped(result)
            self._on_stop(result)
        except Exception:
            _log.error("stop not counted", robot=self.name, trace=traceback.format_exc())

    def _display_tasks(self) -> list[Coroutine[Any, Any, None]]:
        return [self.tasks.restarted(run) for run in self.live_view.tasks()]

    # ------------------------------------------------------------------ hear
    async def _listen(self) -> None:
        while True:
            try:
                async for event in self.event_stream.events():
                    self._handle_event_safely(event)
            except ForumNotFound:
                with contextlib.suppress(ForumError):
                    if await self._recover_cursor():
                        continue
                await asyncio.sleep(1.0)

    async def _recover_cursor(self) -> bool:
        """The forum does not know our last event. If it only deleted it, continue after it (True). If the forum was
        replaced, end all commands and let nothing older move (False)."""
        newest = await retry_until_answered(self.event_stream.set_clock)
        with contextlib.suppress(ForumNotFound):
            await retry_until_answered(partial(self.forum.changes, self.event_stream.cursor))
            return True
        if (gap := await gap_after(self.forum, self.journal)) is not None:
            since, until = gap
            _log.warning("events of while I was away are not kept any more", robot=self.name, since=since, until=until)
            self.event_stream.cursor = BEFORE_ALL
            await self._look_back(since, until)
            return True
        _log.error("the forum is not the one of before; beginning at its newest event", robot=self.name)
        self.clock.begin(self.event_stream.compared_at)
        self.inbox.clear()
        for job in self.queue:
            job.end(EndReason.REPLACED)
        if tasks := {job.task for job in self.queue if job.task}:
            _, late = await asyncio.wait(tasks, timeout=DRIVER_WAIT_S)
            for task in late:
                task.cancel()
        await self.journal.set_aside()
        begun = self.event_stream.compared_at.isoformat()
        await self.journal.put_all(watermark=begun, cursor=newest, cursor_at=begun)
        self.event_stream.cursor = newest
        await self._look_back(self.event_stream.now() - LOOK_BACK, self.clock.watermark_at)
        return False

    def _handle_event_safely(self, event: Event) -> None:
        """Handle an event; an error never keeps the next events from being handled."""
        try:
            self._handle_event(event)
        except Exception:
            _log.error("event not handled", robot=self.name, event_id=event.id, trace=traceback.format_exc())

    def _handle_event(self, event: Event) -> None:
        """Handle an event without waiting: a stop is sent to the driver before anything else is done."""
        self.clock.note(event.at)
        triaged = TriagedPost(Route.NOTHING)
        if event.post is not None and event.kind is not EventKind.POST_REMOVED:
            self.known_robots.note(event.post.author)
            self._receive_part(event.post)
            triaged = self.triage(event.post, edited=event.kind is EventKind.POST_EDITED)
            if triaged.route in (Route.STOP, Route.HALT):
                self._stop(event, event.post.author, triaged)
            self.known_robots.look_up([name for name in triaged.others if name in event.post.mentions])
        elif event.robot in self._partners and event.kind in (EventKind.ROBOT_STOP, EventKind.ROBOT_ESTOP):
            self._stop(event, event.account, triaged)  # one stop stops all parts of a post
        elif event.robot == self.name and event.kind is EventKind.ROBOT_STOP:
            self._stop(event, event.account, triaged)
        elif event.robot == self.name and event.kind is EventKind.ROBOT_ESTOP:
            self._stop(event, event.account, TriagedPost(Route.HALT))
        elif event.robot == self.name and event.kind in (EventKind.ROBOT_RELEASE, EventKind.ROBOT_HOME):
            assert self._me is not None
            self.tasks.spawn(self._pressed(event, self._me))
        elif event.robot == self.name and event.kind is EventKind.ROBOT_WATCH:
            self.live_view.watch_camera()
        elif event.robot == self.name and event.kind is EventKind.ROBOT_POSES:
            self.tasks.spawn(self.live_view.watch_poses())
        elif event.robot == self.name and event.kind is EventKind.ROBOT_RESET and event.account:
            self.tasks.spawn(self._reset(event.account, event.at))
        if self._accepting:
            self.inbox.put(event, triaged)

    # ------------------------------------------------------------------ parts of posts to several robots
    @property
    def _partners(self) -> frozenset[str]:
        """The other robots of the posts of which this one carries out a part."""
        names = (name for job in self.queue if job.joint is not None for name in job.joint.robots)
        return frozenset(names) - {self.name}

    def _parts_changed(self) -> None:
        self.queue.wake()
        if self._summaries is not None:
            self._summaries.changed()

    def _receive_part(self, post: Post) -> None:
        """Note what another robot shows about a part of a post; if it was stopped, stop this robot's parts, too."""
        self.threads.receive(post)
        if post.card is None or post.card.state != CommandState.STOPPED or post.author.name == self.name:
            return
        for job in [job for job in self.queue if job.joint is not None and job.can_end]:
            if part_posts([post], job.command):
                job.stopped_by = post.author.name
                job.because = say("joint.because.stopped", job.command.language, who=quote(post.author.name))
                if job.moving:
                    job.stop = self.tasks.spawn(self.stops.stop(job.stopped_by, post.edited_at or post.created_at))
                job.end(EndReason.STOP)
                self.tasks.spawn(self.journal.end([job.command.key], EndReason.STOP))

    # ------------------------------------------------------------------ triage
    async def settle(self, post: Post, triaged: TriagedPost) -> TriagedPost:
        """Triage a post again once the clocks are compared: only then it is known whether it is fresh."""
        await self.clock.settled()
        if self.clock.was_set() is None:
            return triaged
        again = self.triage(post)
        return again if again.route in (Route.READ, Route.STALE, Route.APPROVE, Route.DENY, Route.RENEW) else triaged

    def triage(self, post: Post, edited: bool = False) -> TriagedPost:
        """Triage a post. An error while reading one never keeps the next posts from being handled."""
        assert self._me is not None
        if post.removed or not obeyed(post.author, self._me):  # most posts of a fleet are those of its robots
            return TriagedPost(Route.NOTHING)
        try:
            return triage(post, self._addressing(), edited)
        except Exception:
            _log.error("post not understood", robot=self.name, post=post.id, trace=traceback.format_exc())
            return TriagedPost(Route.NOTHING)

    def _addressing(self) -> Addressing:
        assert self._me is not None
        names = frozenset({self._me.name, *(n.lower().lstrip("@") for n in self.settings.mentions)})
        topics = self.queue.topics() | {post.topic_id for post in self.inbox.coming.values()} | self._claimed_topics
        scheduled = self._schedules.topics if self._schedules is not None else frozenset()
        renewable = self._schedules.renewable_topics if self._schedules is not None else frozenset()
        return Addressing(
            self._me, names, self.settings.boards, self.clock.watermark_at, self.event_stream.now(),
            self.settings.max_post_age_s, topics, scheduled, renewable,
            {*self.queue.posts, *self.inbox.coming, *self.inbox.left_open}, self.known_robots.names,
            self._partners,
        )  # fmt: skip

    def _stop(self, event: Event, author: Account | None, triaged: TriagedPost) -> None:
        assert self._me is not None
        if author is not None and obeyed(author, self._me) and may(author, "stop").decision is Decision.ALLOW:
            self.stop_handler.handle(
                event, author, triaged.language, halt=triaged.route is Route.HALT, taken=triaged.taken_as_stop
            )
            if self._schedules is not None:
                self._schedules.changed()

    def stop(self, by: str, posted_at: datetime | None = None) -> tuple[int, asyncio.Task[StopResult | None]]:
        """Stop without the forum, for an account that may. Returns how many commands it ended, and the stopping
        task."""
        return self.stop_handler.stop_now(by, posted_at)

    async def _stop_reply(self, reply: StopReply) -> str:
        how = await self.owner.how_to_release(reply.language) if reply.halted else ""
        text = reply_text.stop_reply(
            reply.result, reply.language, reply.ended, reply.halted, reply.folded, how, reply.taken
        )
        by = self.clock.was_set()
        return text if by is None else f"{text} {reply_text.clock_set(by, reply.language)}"

    async def _pressed(self, event: Event, me: Account) -> None:
        await self.clock.settled()
        await self.owner.pressed(event, me)

    async def _reset(self, account: Account, at: datetime) -> None:
        assert self._me is not None
        await self.clock.settled()
        granted = may(account, "command", simulated=self.settings.simulated)
        allowed = obeyed(account, self._me) and granted.decision is Decision.ALLOW
        fresh = (self.event_stream.now() - at).total_seconds() <= self.settings.max_post_age_s
        if not self.settings.room_reset or not allowed or not fresh:
            return
        if len(self.queue):
            ended = self.queue.end_all(EndReason.STOP)
            for job in ended:
                job.stopped_by = account.name
            await self.stops.stop(account.name, at)
            await self.journal.end([job.command.key for job in ended], EndReason.STOP)
            if (moving := self.queue.moving) is not None and moving.task is not None:
                await asyncio.wait({moving.task}, timeout=DRIVER_WAIT_S)
        try:
            await reset_room(self.driver, self.settings, account.name)
        except RobotError as e:
            _log.warning("room not reset", robot=self.name, error=str(e))

    # ------------------------------------------------------------------ what the inbox asks for
    def why_stopped(self, posted_at: datetime) -> EndReason | None:
        return self.stop_handler.why_not(posted_at)

    def enqueue(self, job: QueuedCommand) -> None:
        self.stops.new_command()
        self.queue.enter(job)
        job.task = self.tasks.spawn(self.pipeline.run(job))

    def decline(self, command: Command) -> None:
        self.tasks.spawn(self.pipeline.final_report.decline(command))

    async def decide(self, post: Post, triaged: TriagedPost) -> None:
        await self.pipeline.approvals.record_decision(post, triaged)

    async def cancel(self, post: Post) -> None:
        """Cancel the schedules of a thread, for an account that may stop the robot."""
        if may(post.author, "stop").decision is Decision.ALLOW:
            await self.schedules.cancel(post.topic_id, post.reply_to)

    async def renew(self, post: Post, triaged: TriagedPost) -> None:
        await self.schedules.renew(post, triaged.language, fresh=triaged.fresh)

    async def amend(self, post: Post) -> None:
        await self.schedules.amended(post)

    def _queue_changed(self) -> None:
        self.live_view.changed()
        for job in self.queue:
            show_place(job, self.queue)
