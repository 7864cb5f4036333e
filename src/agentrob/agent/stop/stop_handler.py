"""What a stop ends: all that was posted earlier, whether it is on its way, waits or moves (laws 13 to 15).

What was heard before a stop was posted before it, whatever the forum's clock said. Of a post that is heard after it,
only the clock tells which was first, and that clock may be set in between. So a stop keeps the moment at which it was
heard as well, by a clock that nobody sets: a post can be older than the stop only if it is older than that moment.
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
    """A stop: when it was posted, by the forum's clock as it went then, and when it was heard, by `elapsed_s`. One that
    came `past` the forum bears no time of it, and ends what was posted until it was heard."""

    posted_at: datetime
    heard_s: float
    past: bool = False

    def at(self, event_stream: EventStream) -> datetime:
        """Nothing that was posted then or before moves any more. Never more than `STEP` later than when the stop was
        heard, by the forum's clock as it goes now."""
        heard_at = event_stream.at(self.heard_s)
        if self.posted_at > heard_at + STEP:  # the forum's clock has been set back since
            return heard_at
        return max(self.posted_at, heard_at) if self.past else self.posted_at


class StopHandler:
    """One robot's. `journal` gives None while it is not open, `spawn` begins work that nobody waits for. Whether
    somebody may stop is asked before."""

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
        """Nothing that was posted then or before moves any more, by the forum's clock as it goes now."""
        return self._last.at(self._event_stream) if self._last is not None else datetime.min.replace(tzinfo=UTC)

    async def remember(self, journal: Journal, begun: datetime) -> None:
        """What the journal knows of stops counts too. `begun`: the agent's first start."""
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
        """Why a post that was heard after the newest stop may not move: it was written before; or it may have been, as
        far as a clock that was set since can tell. None when it may."""
        if self._last is None or posted_at > self.stopped_at:
            return None
        step, last = self._event_stream.step, self._last
        was_set = step is not None and step.noticed_s >= last.heard_s
        if was_set or last.posted_at > self._event_stream.at(last.heard_s) + STEP:
            return EndReason.CLOCK
        return EndReason.STOP

    def heard(self, event: Event, author: Account, language: Language, halt: bool, taken: bool = False) -> None:
        """A stop of the forum: end and cancel all that was posted earlier, and stop the robot, with nothing between.
        `taken`: the post was taken as a stop since the robot moves or a command waits; its reply says so."""
        post = event.post
        edited = event.kind is EventKind.POST_EDITED
        at = post.created_at if post is not None and not edited else event.at
        coming = len(self._inbox.coming)
        ended, stopping = self._end_all(author.name, Stopped(at, elapsed_s()), at, halt)
        if post is not None:
            reply = StopReply(language, len(ended) + coming, halt, taken)
            self._spawn(self._stops.answer(post, stopping, reply))
        self._ring(event.at, post.topic_id if post is not None else None, ended, language)

    def pulled(self, by: str, posted_at: datetime | None) -> tuple[int, asyncio.Task[StopResult | None]]:
        """A stop past the forum ends what was posted until now, and until `posted_at`; how many that were."""
        now = self._event_stream.now()
        ended, stopping = self._end_all(by, Stopped(max(now, posted_at or now), elapsed_s(), past=True), now)
        self._ring(now, None, ended, "en")
        return len(ended), stopping

    def released(self, at: datetime) -> None:
        """A locked robot is released: what was posted before that does not move it afterwards (laws 14 and 17)."""
        self._note(Stopped(at, elapsed_s()))
        self._inbox.end_coming(until=at)
        self._write_down(self._queue.end_posted(at, EndReason.RELEASE), EndReason.RELEASE)

    def clear(self) -> datetime | None:
        """From now on no stop of before holds back what is posted. The time that the newest one bears, where that is in
        the future by the forum's clock as it goes now."""
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
        """The later one counts, by the forum's clock as it goes now."""
        if self._last is None or stopped.at(self._event_stream) >= self._last.at(self._event_stream):
            self._last = stopped

    def _write_down(self, ended: list[QueuedCommand], why: EndReason) -> None:
        if (journal := self._journal()) is not None:
            self._save_soon(journal)
            if ended:
                self._spawn(journal.end([job.command.post_id for job in ended], why))

    def _save_soon(self, journal: Journal) -> None:
        if self._saving is None or self._saving.done():
            self._saving = self._spawn(self._save(journal))

    def _ring(self, at: datetime, topic: str | None, ended: list[QueuedCommand], language: Language) -> None:
        if self._moderator_alert.rings(at):
            topic = topic or next((job.command.topic_id for job in ended), None)
            self._spawn(self._moderator_alert.tell(topic, language))

    async def _save(self, journal: Journal) -> None:
        """Many stops at once are one or two writes, so that nobody's command waits behind them."""
        saved: Stopped | None = None
        while (last := self._last) is not None and saved is not last:
            saved = last
            at = last.at(self._event_stream).isoformat()
            await journal.put_all(stopped=at, stopped_heard=f"{boot()} {last.heard_s!r}")
