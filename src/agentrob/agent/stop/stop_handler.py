"""Stop the robot, and end every command that was posted earlier: received, waiting or moving (laws 13 to 15).

A post that was received before a stop was posted before it, whatever the forum's clock said. For a post that is
received after a stop only the clock tells which came first, and that clock may be set in between. So a stop also keeps
the moment at which it was received, by a clock that cannot be set: a post can be older than the stop only if it is
older than that moment.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import structlog

from agentrob.agent.intake.event_stream import STEP, ClockStep, EventStream, elapsed_s
from agentrob.agent.intake.inbox import Inbox
from agentrob.agent.queue.queue import CommandQueue, QueuedCommand
from agentrob.agent.stop.moderator_alert import ModeratorAlert
from agentrob.agent.stop.replies import StopReplies, StopReply
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.rows import boot
from agentrob.forums.protocol import Event
from agentrob.model import Account, EndReason, EventKind, Language, StopResult

_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Stopped:
    """A stop: when it was posted, by the forum's clock as it was set then, and when it was received, by `elapsed_s`. A
    stop that did not come through the forum (`past`) has no time of the forum, and ends what was posted until it was
    received."""

    posted_at: datetime
    heard_s: float
    past: bool = False

    def at(self, event_stream: EventStream) -> datetime:
        """Nothing that was posted then or before moves any more. At most `STEP` later than when the stop was received,
        by the forum's clock as it is set now."""
        heard_at = event_stream.at(self.heard_s)
        if self.posted_at > heard_at + STEP:  # the forum's clock has been set back since
            return heard_at
        return max(self.posted_at, heard_at) if self.past else self.posted_at


class StopHandler:
    """Handles the stops of one robot. `journal` returns None while it is not open, `spawn` starts a task that nobody
    awaits. The caller has checked that the account may stop."""

    def __init__(
        self,
        queue: CommandQueue,
        inbox: Inbox,
        stops: StopReplies,
        moderator_alert: ModeratorAlert,
        journal: Callable[[], Journal | None],
        event_stream: EventStream,
        spawn: Callable[[Coroutine[Any, Any, Any]], asyncio.Task[Any]],
    ) -> None:
        self._last: Stopped | None = None
        self._queue = queue
        self._inbox = inbox
        self._stops = stops
        self._moderator_alert = moderator_alert
        self._event_stream = event_stream
        self._spawn = spawn
        self._journal = journal
        self._saving: asyncio.Task[None] | None = None

    @property
    def stopped_at(self) -> datetime:
        """Nothing that was posted then or before moves any more, by the forum's clock as it is set now."""
        return self._last.at(self._event_stream) if self._last is not None else datetime.min.replace(tzinfo=UTC)

    async def remember(self, journal: Journal, begun: datetime) -> None:
        """Load the newest stop from the journal. `begun`: the agent's first start."""
        posted_at, heard = await journal.get_time("stopped") or begun, await journal.get("stopped_heard") or ""
        machine, _, heard_s = heard.partition(" ")
        kept = Stopped(posted_at, float(heard_s) if heard_s and machine == boot() else elapsed_s())
        by = self._event_stream.at(kept.heard_s) - posted_at
        if by < -STEP:
            self._event_stream.step = ClockStep(by, elapsed_s())
        known = self._last is not None  # somebody stopped before we could write it down
        self._note(kept)
        if known or by < -STEP:
            self._save_soon(journal)

    def why_not(self, posted_at: datetime) -> EndReason | None:
        """Why a post that was received after the newest stop may not move: it was written before the stop, or may have
        been, as far as a clock that was set since can tell. None if it may."""
        if self._last is None or posted_at > self.stopped_at:
            return None
        step, last = self._event_stream.step, self._last
        was_set = step is not None and step.noticed_s >= last.heard_s
        if was_set or last.posted_at > self._event_stream.at(last.heard_s) + STEP:
            return EndReason.CLOCK
        return EndReason.STOP

    def handle(self, event: Event, author: Account, language: Language, halt: bool, taken: bool = False) -> None:
        """Handle a stop of the forum: end everything that was posted earlier and stop the robot, with nothing in
        between. `taken`: the post counts as a stop only because the robot moves or a command waits; its reply says
        so."""
        post = event.post
        edited = event.kind is EventKind.POST_EDITED
        at = post.created_at if post is not None and not edited else event.at
        coming = len(self._inbox.coming)
        ended, stopping = self._end_all(author.name, Stopped(at, elapsed_s()), at, halt)
        if post is not None:
            reply = StopReply(language, len(ended) + coming, halt, taken)
            self._spawn(self._stops.answer(post, stopping, reply))
        self._alert(event.at, post.topic_id if post is not None else None, ended, language)

    def stop_now(self, by: str, posted_at: datetime | None) -> tuple[int, asyncio.Task[StopResult | None]]:
        """Handle a stop that did not come through the forum: end what was posted until now and until `posted_at`.
        Return how many commands it ended, and the task that stops the robot."""
        now = self._event_stream.now()
        ended, stopping = self._end_all(by, Stopped(max(now, posted_at or now), elapsed_s(), past=True), now)
        self._alert(now, None, ended, "en")
        return len(ended), stopping

    def released(self, at: datetime) -> None:
        """Record that a locked robot is released: what was posted before does not move it afterwards (laws 14, 17)."""
        self._note(Stopped(at, elapsed_s()))
        self._inbox.end_coming(until=at)
        self._write_down(self._queue.end_posted(at, EndReason.RELEASE), EndReason.RELEASE)

    def clear(self) -> datetime | None:
        """Let no earlier stop hold back what is posted from now on. Return the time of the newest stop if it is in the
        future, by the forum's clock as it is set now."""
        last, now = self._last, self._event_stream.now()
        if last is None or last.posted_at <= now:
            return None
        self._last = Stopped(min(self.stopped_at, now), last.heard_s)
        self._write_down([], EndReason.STOP)
        return last.posted_at

    def _end_all(
        self, by: str, stopped: Stopped, accepted_at: datetime, halt: bool = False
    ) -> tuple[list[QueuedCommand], asyncio.Task[StopResult | None]]:
        self._note(stopped)
        self._inbox.end_coming()
        ended = self._queue.end_all(EndReason.STOP)
        stopping: asyncio.Task[StopResult | None] = self._spawn(self._stops.stop(by, accepted_at, halt))
        for job in ended:
            job.stop, job.stopped_by = stopping, by
        self._write_down(ended, EndReason.STOP)  # on disk only now that the stop is on its way: nothing delays it
        return ended, stopping

    def _note(self, stopped: Stopped) -> None:
        """Keep the later stop, by the forum's clock as it is set now."""
        if self._last is None or stopped.at(self._event_stream) >= self._last.at(self._event_stream):
            self._last = stopped

    def _write_down(self, ended: list[QueuedCommand], why: EndReason) -> None:
        if (journal := self._journal()) is not None:
            self._save_soon(journal)
            if ended:
                self._spawn(journal.end([job.command.key for job in ended], why))

    def _save_soon(self, journal: Journal) -> None:
        if self._saving is None or self._saving.done():
            self._saving = self._spawn(self._save(journal))

    def _alert(self, at: datetime, topic: str | None, ended: list[QueuedCommand], language: Language) -> None:
        if self._moderator_alert.count_stop(at):
            topic = topic or next((job.command.topic_id for job in ended), None)
            self._spawn(self._moderator_alert.post(topic, language))

    async def _save(self, journal: Journal) -> None:
        """Save the newest stop. Many stops at once need one or two writes, so that no command waits behind them."""
        saved: Stopped | None = None
        while (last := self._last) is not None and saved is not last:
            saved = last
            at = last.at(self._event_stream).isoformat()
            await journal.put_all(stopped=at, stopped_heard=f"{boot()} {last.heard_s!r}")
