"""What a stop ends: all that was posted earlier, whether it is on its way, waits or moves (laws 13 to 15)."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from datetime import UTC, datetime, timedelta
from typing import Any

import structlog

from agentrob.agent.alarm import Alarm
from agentrob.agent.execute import STOP
from agentrob.agent.inbox import Inbox
from agentrob.agent.journal import Journal
from agentrob.agent.line import Job, Line
from agentrob.agent.stops import Stops
from agentrob.forums.forum import Event, EventKind
from agentrob.model import Account, Language, StopResult

#: Why a command was ended that had been posted before the robot was released.
RELEASE = "release"

#: A clock that differs by more than this was set.
STEP = timedelta(seconds=5)
_log = structlog.get_logger()


class Brake:
    """One robot's. `stopped_at` is when the newest stop was posted: nothing of then or before moves any more.

    `journal` gives None while it is not open, `spawn` begins work that nobody waits for. Whether somebody may stop is
    asked before.
    """

    def __init__(
        self,
        line: Line,
        inbox: Inbox,
        stops: Stops,
        alarm: Alarm,
        journal: Callable[[], Journal | None],
        now: Callable[[], datetime],
        spawn: Callable[[Coroutine[Any, Any, Any]], asyncio.Task[Any]],
    ) -> None:
        self.stopped_at = datetime.min.replace(tzinfo=UTC)
        self._leapt_at = self.stopped_at
        self._line = line
        self._inbox = inbox
        self._stops = stops
        self._alarm = alarm
        self._now = now
        self._spawn = spawn
        self._journal = journal
        self._saving: asyncio.Task[None] | None = None

    async def remember(self, journal: Journal, begun: datetime) -> None:
        """What the journal knows of stops counts too. `begun`: the agent's first start."""
        kept = await journal.get_time("stopped") or begun
        self.bound(kept)
        if self.stopped_at > kept:  # somebody stopped before we could write it down
            self._saving = self._spawn(self._save(journal))
        self.stopped_at = max(self.stopped_at, min(kept, self._now()) if self._leapt_at >= kept else kept)

    def bound(self, stopped_at: datetime | None = None) -> None:
        """A stop stamped later than it is by the forum's clock (which leapt ahead and came back) ends what was posted
        until now, and what bears a stamp of that leap; it does not block what is posted from now on."""
        stopped_at, now = stopped_at or self.stopped_at, self._now()
        if stopped_at > now + STEP:
            _log.warning("a stop is stamped in the future; it counts until now", stopped_at=stopped_at, now=now)
            self._leapt_at = max(self._leapt_at, stopped_at)
            self.stopped_at = min(self.stopped_at, now)

    def ends(self, posted_at: datetime) -> bool:
        """Whether a post was written before the newest stop, by the forum's clock."""
        return posted_at <= self.stopped_at or self._now() + STEP < posted_at <= self._leapt_at

    def heard(self, event: Event, author: Account, language: Language, halt: bool, taken: bool = False) -> None:
        """A stop of the forum: end and cancel all that was posted earlier, and stop the robot, with nothing between.
        `taken`: the post was taken as a stop since the robot moves or a command waits; its reply says so."""
        post = event.post
        edited = event.kind is EventKind.POST_EDITED
        at = post.created_at if post is not None and not edited else event.at
        # What is known came before it in the order of events, whatever the forum's clock did meanwhile.
        before = max(
            [at, *(job.command.posted_at for job in self._line), *(p.created_at for p in self._inbox.coming.values())]
        )
        ended, stopping = self._end_all(author.name, before, halt, at)
        if post is not None:
            count = len(ended) + sum(coming.created_at <= before for coming in self._inbox.coming.values())
            self._spawn(self._stops.answer(post, language, stopping, count, halt, taken))
        self._ring(event.at, post.topic_id if post is not None else None, ended, language)

    def pulled(self, by: str, posted_at: datetime | None) -> tuple[int, asyncio.Task[StopResult | None]]:
        """A stop past the forum ends what was posted until now; how many that were.

        What is known to be posted (in line, on its way, at `posted_at`) was posted before, whatever the clocks say.
        """
        known = [job.command.posted_at for job in self._line] + [p.created_at for p in self._inbox.coming.values()]
        at = max([self._now(), *known, *([posted_at] if posted_at else [])])
        ended, stopping = self._end_all(by, at)
        self._ring(self._now(), None, ended, "en")
        return len(ended), stopping

    def released(self, at: datetime) -> None:
        """A locked robot is released: what was posted before that does not move it afterwards (laws 14 and 17)."""
        self.stopped_at = max(self.stopped_at, at)
        self._write_down(self._line.end_before(at, RELEASE), RELEASE)

    def _end_all(
        self, by: str, at: datetime, halt: bool = False, accepted_at: datetime | None = None
    ) -> tuple[list[Job], asyncio.Task[StopResult | None]]:
        self.stopped_at = max(self.stopped_at, at)
        ended = self._line.end_before(at, STOP)
        stopping: asyncio.Task[StopResult | None] = self._spawn(self._stops.stop(by, accepted_at or at, halt))
        for job in ended:
            job.stop, job.stopped_by = stopping, by
        self._write_down(ended, STOP)  # on disk only now that the stop is on its way: nothing delays it
        return ended, stopping

    def _write_down(self, ended: list[Job], why: str) -> None:
        if (journal := self._journal()) is not None:
            if self._saving is None or self._saving.done():
                self._saving = self._spawn(self._save(journal))
            if ended:
                self._spawn(journal.end([job.command.post_id for job in ended], why))

    def _ring(self, at: datetime, topic: str | None, ended: list[Job], language: Language) -> None:
        if self._alarm.rings(at):
            topic = topic or next((job.command.topic_id for job in ended), None)
            self._spawn(self._alarm.tell(topic, language))

    async def _save(self, journal: Journal) -> None:
        """Many stops at once are one or two writes, so that nobody's command waits behind them."""
        saved_at = None
        while saved_at != self.stopped_at:
            saved_at = self.stopped_at
            await journal.put("stopped", saved_at.isoformat())
