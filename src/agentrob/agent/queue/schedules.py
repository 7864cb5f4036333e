"""Commands for later times: begin each run when it is due, and say what did not run and what has ended.

A run is a command of the schedule's author, posted at the time of the run: its rights, freshness, screen, approval and
limits are checked then, by the same pipeline (laws 2, 4, 5 and 7). Its claim and the next time of its schedule are
written in one transaction, so that it begins at most once and none is lost in silence (law 6). A stop ends the
schedules that were posted before it (law 14). A schedule that ended by the limit of runs or days is renewed by a reply
of its author.
"""

from __future__ import annotations

import asyncio
import math
import traceback
from collections.abc import Callable, Coroutine, Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from functools import partial
from typing import Any
from uuid import uuid4

import structlog

from agentrob.agent.queue.queue import LATE_S, CommandQueue, QueuedCommand
from agentrob.agent.reporting.schedule_card import schedule_card
from agentrob.agent.reporting.schedule_text import renewed
from agentrob.agent.reporting.status_post import retry_until_answered
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.rows import KeptSchedule
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumDenied, ForumError, ForumNotFound, JournalError
from agentrob.forums.protocol import Forum
from agentrob.language.messages.catalog import quote, say
from agentrob.language.schedule.compose import MAX_DAYS, MAX_RUNS
from agentrob.model import Account, Decision, EndReason, Language, Post, ScheduledRun, ScheduleEnd, Verdict
from agentrob.model.schedules import next_run
from agentrob.screening.rights import may

#: The most schedules of one account that one robot keeps.
MOST = 5
#: How often the times are compared at least, because the forum's clock can be set, and how soon after an error.
LOOK_S, RETRY_S = 30.0, 2.0
#: How long the forum may take to show a post and its author; how often the agent tries to report a schedule's end.
ASK_S, TRIES = 10.0, 9
_log = structlog.get_logger()


@dataclass
class Schedules:
    """The schedules of one robot. `now` is the forum's clock, `why_not` returns why a post of a given time may not move
    the robot, because of a later stop. `enqueue` starts a command, `spawn` a background task. `shown` is called when
    `card` has changed."""

    settings: RobotConfig
    forum: Forum
    journal: Journal
    queue: CommandQueue
    now: Callable[[], datetime]
    why_not: Callable[[datetime], EndReason | None]
    enqueue: Callable[[QueuedCommand], None]
    spawn: Callable[[Coroutine[Any, Any, Any]], object]
    shown: Callable[[], None] = lambda: None
    #: The threads of schedules with further runs, in which "cancel" needs no mention.
    topics: frozenset[str] = frozenset()
    #: The threads of schedules that may be renewed, or were, in which "keep on" needs no mention.
    renewable_topics: frozenset[str] = frozenset()
    #: What the robot's card says of its schedules.
    card: dict[str, Any] = field(default_factory=dict)
    _telling: set[str] = field(default_factory=set)
    _changed: asyncio.Event = field(default_factory=asyncio.Event)

    # ---------------------------------------------------------------- time
    async def run(self) -> None:
        """Begin runs when they are due, until cancelled."""
        while True:
            self._changed.clear()
            wait_s = RETRY_S
            try:
                wait_s = await self.step()
            except JournalError as e:
                _log.error("schedules not read", error=str(e))
            except Exception:  # no schedule ends the agent, which must hear the next stop
                _log.error("schedules not handled", trace=traceback.format_exc())
            try:
                async with asyncio.timeout(wait_s):
                    await self._changed.wait()
            except TimeoutError:
                pass

    def changed(self) -> None:
        """Look again: a schedule was added or has ended, or the robot was stopped."""
        self._changed.set()

    async def load(self) -> None:
        """Read which threads have schedules, and tell of renewals again, whose replies may not have been written."""
        kept = await self.journal.schedules()
        await self._note(kept)
        for renewed_one in kept:
            if renewed_one.ended is None and renewed_one.asked.renewed_by:
                self.spawn(self._report_renewed(renewed_one))

    async def _note(self, kept: Sequence[KeptSchedule]) -> None:
        running = [one for one in kept if one.ended is None]
        again = [*await self.journal.renewable_schedules(), *(one for one in running if one.asked.renewed_by)]
        self.topics, self.renewable_topics = _topics(running), _topics(again)
        card = schedule_card(running)
        if card != self.card:
            self.card = card
            self.shown()

    async def step(self) -> float:
        """Begin what is due, and tell what has ended. Return after how many seconds to look again."""
        due: list[KeptSchedule] = []
        for kept in await self.journal.schedules():
            if kept.ended is None and self.why_not(kept.asked.command.posted_at) is not None:
                await self.journal.end_schedule(kept.post_id, ScheduleEnd.STOP)
            elif kept.ended is not None:
                self._report_soon(kept)
            elif kept.next_at is not None and kept.next_at <= self.now():
                due.append(kept)
        await asyncio.gather(*map(self._begin, due))
        left = await self.journal.schedules()
        await self._note(left)
        for kept in left:
            if kept.ended is not None:
                self._report_soon(kept)
        times = [(kept.next_at - self.now()).total_seconds() for kept in left if kept.next_at and kept.ended is None]
        return min(LOOK_S, max(RETRY_S if due else 0.0, min(times, default=math.inf)))

    # ---------------------------------------------------------------- runs
    async def _begin(self, kept: KeptSchedule) -> None:
        """Begin the run that is due, unless it is too late, its schedule has ended, or the run before has not."""
        assert kept.next_at is not None
        latest_s = min(self.settings.max_post_age_s, LATE_S)
        if (self.now() - kept.next_at).total_seconds() > latest_s:
            return await self._miss(kept, self.now() - timedelta(seconds=latest_s))
        if any(job.command.run is not None and job.command.post_id == kept.post_id for job in self.queue):
            return await self._enter(kept, kept.asked.command.author, EndReason.OVERLAP)
        command = kept.asked.command
        try:
            async with asyncio.timeout(ASK_S):
                post, author = await asyncio.gather(
                    self.forum.post(command.post_id), self.forum.account(command.author.name)
                )
        except ForumNotFound:
            return await self.journal.end_schedule(kept.post_id, ScheduleEnd.REMOVED)
        except (ForumError, TimeoutError) as e:
            _log.info("scheduled run waits for the forum", post=kept.post_id, error=str(e))
            return None
        if (end := _end_of(kept, post, author, self.settings)) is not None:
            return await self.journal.end_schedule(kept.post_id, end)
        assert author is not None
        return await self._enter(await self._follow(kept, post), author, None, url=post.url)

    async def _follow(self, kept: KeptSchedule, post: Post) -> KeptSchedule:
        """Return a schedule in the thread in which its post is now: there its runs reply, and a stop needs no
        mention."""
        if post.topic_id == kept.asked.command.topic_id:
            return kept
        return await self.journal.move_schedule(kept.post_id, post.topic_id)

    async def _miss(self, kept: KeptSchedule, until: datetime) -> None:
        """Claim the first of the runs that are too late as one that may not move; its reply tells of all of them."""
        assert kept.next_at is not None
        count, last = 1, kept.next_at
        while count < kept.runs_left:
            following = next_run(kept.asked.schedule, last)
            if following is None or following > until:
                break
            count, last = count + 1, following
        await self._enter(kept, kept.asked.command.author, EndReason.MISSED, count, last)

    async def _enter(
        self, kept: KeptSchedule, author: Account, ended: EndReason | None, count: int = 1,
        last: datetime | None = None, url: str = "",
    ) -> None:  # fmt: skip
        """Claim a run and process it. `ended` is why it may not move, `count` how many runs it stands for, up to
        `last`. `url` is the address of the schedule's post."""
        assert kept.next_at is not None
        asked, at = kept.asked.command, kept.next_at
        missed = count if ended is EndReason.MISSED else 0
        schedule = kept.asked.schedule
        run = ScheduledRun(
            at, asked.posted_at, schedule.tz, missed, number=schedule.runs_left - kept.runs_left + 1,
            of=schedule.runs_left, limited=schedule.limited_runs, url=url,
        )  # fmt: skip
        command = replace(asked, author=author, text=kept.asked.text, posted_at=at, trace_id=uuid4().hex[:12], run=run)
        claim = await self.journal.begin_run(kept, command, ended, following(kept, last or at, count))
        if claim is None or not claim.new:
            return
        late_s = max(0.0, (self.now() - at).total_seconds())
        job = QueuedCommand(claim.command, ended=ended, waited_s=late_s)
        came = self.why_not(asked.posted_at) if ended is None else None  # while the claim was written
        if came is not None:
            job.end(came)
        self.enqueue(job)
        if came is not None:
            await self.journal.end([command.key], came)

    # ---------------------------------------------------------------- ends
    async def amended(self, post: Post) -> None:
        """End the schedule of a post that was edited or removed; move it with its post to another thread."""
        kept = await self.journal.schedule(post.id)
        if kept is None:
            return
        if not post.removed and post.content_hash == kept.asked.command.content_hash:
            if (await self._follow(kept, post)) is not kept:
                self.changed()
            return
        end = ScheduleEnd.REMOVED if post.removed else ScheduleEnd.EDITED
        await self.journal.end_schedule(post.id, end)
        await self.journal.refuse_renewal(post.id, end)
        self.changed()

    async def cancel(self, topic_id: str, reply_to: str | None = None) -> int:
        """End the schedule that a post replies to, or all of its thread if it replies to none; return how many."""
        running = [kept for kept in await self.journal.schedules() if kept.ended is None]
        ended = await self._meant(running, topic_id, reply_to)
        for kept in ended:
            await self.journal.end_schedule(kept.post_id, ScheduleEnd.CANCELLED)
        self.changed()
        return len(ended)

    async def _meant(
        self, schedules: Iterable[KeptSchedule], topic_id: str, reply_to: str | None
    ) -> Sequence[KeptSchedule]:
        """The schedules of a thread; only one if the post that speaks of them replies to it, or to its first reply."""
        here = [kept for kept in schedules if kept.asked.command.topic_id == topic_id]
        claims = [await self.journal.claimed(kept.post_id) for kept in here]
        replies = [claim.status_post if claim is not None else None for claim in claims]
        one = [kept for kept, ours in zip(here, replies, strict=True) if reply_to and reply_to in (kept.post_id, ours)]
        return one or here

    async def lose_right(self, post_id: str) -> None:
        """End a schedule whose author may not command the robot any more."""
        await self.journal.end_schedule(post_id, ScheduleEnd.RIGHTS)
        self.changed()

    # ---------------------------------------------------------------- renewal
    async def renew(self, post: Post, language: Language, *, fresh: bool) -> None:
        """Renew the schedules of a post's author in its thread that ended by the limit of runs or days, and say so.
        Receiving the post again changes nothing. `fresh`: it is young enough to move the robot (law 5)."""
        found = await self._meant(await self.journal.renewable_schedules(), post.topic_id, post.reply_to)
        mine = [kept for kept in found if kept.asked.command.author.id == post.author.id]
        answer = await self._why_not_renewed(post, found, mine, language, fresh=fresh)
        if answer:
            self.spawn(self._answer(post, answer))
        else:
            for kept in mine:
                await self._renew(kept, post)
        self.changed()

    async def _why_not_renewed(
        self,
        post: Post,
        found: Sequence[KeptSchedule],
        mine: Sequence[KeptSchedule],
        language: Language,
        *,
        fresh: bool,
    ) -> str:
        """The answer to a post that renews none of the schedules `found`, of which `mine` are its author's."""
        kept = [one for one in await self.journal.schedules() if one.ended is None]
        if not found:
            known = any(one.asked.renewed_by == post.id for one in kept)
            return "" if known else say("schedule.renew.running", language)
        if not mine:
            who = ", ".join(sorted({quote(one.asked.command.author.name) for one in found}))
            return say("schedule.renew.others", language, who=who)
        if not fresh:
            return say("schedule.renew.late", language)
        if may(post.author, "command", simulated=self.settings.simulated).decision is Decision.REFUSE:
            return say("schedule.renew.rights", language)
        full = sum(one.asked.command.author.id == post.author.id for one in kept) + len(mine) > MOST
        return say("schedule.renew.full", language, count=MOST) if full else ""

    async def _renew(self, kept: KeptSchedule, post: Post) -> None:
        again = continued(kept, post, self.now())
        if again is None:
            self.spawn(self._answer(post, say("schedule.none", kept.asked.command.language)))
        elif await self.journal.renew_schedule(again):
            self.spawn(self._report_renewed(again))

    async def _report_renewed(self, kept: KeptSchedule) -> None:
        command = kept.asked.command
        text = renewed(kept, command.language)
        reply = partial(
            self.forum.reply, command.topic_id, text, key=f"renewed:{kept.post_id}:{kept.asked.renewed_by}",
            reply_to=kept.asked.renewed_by,
        )  # fmt: skip
        await self._reply(reply, kept.post_id)

    async def _answer(self, post: Post, text: str) -> None:
        reply = partial(self.forum.reply, post.topic_id, text, key=f"renewal:{post.id}", reply_to=post.id)
        await self._reply(reply, post.id)

    async def _reply(self, reply: Callable[[], Coroutine[Any, Any, Any]], post_id: str) -> None:
        try:
            await retry_until_answered(reply, TRIES)
        except ForumError as e:
            _log.warning("renewal of a schedule not answered", post=post_id, error=str(e))

    # ---------------------------------------------------------------- telling
    def _report_soon(self, kept: KeptSchedule) -> None:
        if kept.post_id not in self._telling:
            self._telling.add(kept.post_id)
            self.spawn(self._report(kept))

    async def _report(self, kept: KeptSchedule) -> None:
        """Reply that a schedule has ended, once; if the forum does not answer, a later step tries again."""
        command, end = kept.asked.command, kept.ended
        try:
            if end not in (ScheduleEnd.REMOVED, ScheduleEnd.DONE):
                text = say(f"schedule.ended.{end}", command.language)
                key = ":".join(filter(None, ("schedule", kept.post_id, kept.asked.renewed_by)))
                reply = partial(self.forum.reply, command.topic_id, text, key=key, reply_to=kept.post_id)
                await retry_until_answered(reply, TRIES)
        except (ForumNotFound, ForumDenied) as e:
            _log.warning("end of a schedule not reported", post=kept.post_id, error=str(e))
        except ForumError as e:
            _log.warning("end of a schedule not reported yet", post=kept.post_id, error=str(e))
            return
        finally:
            self._telling.discard(kept.post_id)
        await self.journal.set_schedule_reported(kept.post_id)


def following(kept: KeptSchedule, last: datetime, count: int) -> KeptSchedule:
    """Return a schedule after `count` more runs, the last of them at `last`."""
    schedule, left = kept.asked.schedule, kept.runs_left - count
    at = next_run(schedule, last) if left > 0 else None
    if at is not None:
        return replace(kept, next_at=at, runs_left=left)
    limited = schedule.limited_runs if left <= 0 else schedule.limited_days
    end = ScheduleEnd.LIMIT if limited else ScheduleEnd.DONE
    return replace(kept, next_at=None, runs_left=left, ended=end, reported=end is ScheduleEnd.DONE)


def continued(kept: KeptSchedule, post: Post, now: datetime) -> KeptSchedule | None:
    """Return a schedule as its author renews it by a post: for as many runs and days as any may have, where the author
    did not say how many. None if it has no further run."""
    before = kept.asked.schedule
    left = MAX_RUNS if before.limited_runs else kept.runs_left
    until_at = now + timedelta(days=MAX_DAYS) if before.limited_days else before.until_at
    schedule = replace(before, until_at=until_at.replace(microsecond=0), runs_left=left)
    next_at = next_run(schedule, max(now, post.created_at)) if left > 0 else None
    if next_at is None:
        return None
    command = replace(kept.asked.command, posted_at=post.created_at)
    asked = replace(
        kept.asked, command=command, schedule=replace(schedule, start_at=next_at), renewed_by=post.id
    )  # fmt: skip
    return KeptSchedule(asked, next_at, left)


def _topics(kept: Iterable[KeptSchedule]) -> frozenset[str]:
    return frozenset(one.asked.command.topic_id for one in kept)


def lost_right(verdict: Verdict | None) -> bool:
    """Whether a run was refused because its author may not command the robot; maintenance hours pass."""
    refused = verdict is not None and verdict.decision is Decision.REFUSE
    return refused and verdict is not None and verdict.rule.startswith("rights.") and verdict.rule != "rights.closed"


def _end_of(kept: KeptSchedule, post: Post, author: Account | None, settings: RobotConfig) -> ScheduleEnd | None:
    """Return why a schedule has ended, as the forum shows its post and author now; None if it has not (law 4).

    Whether the robot itself says that it is simulated, as it is configured, is asked again with the run.
    """
    if post.removed:
        return ScheduleEnd.REMOVED
    if post.content_hash != kept.asked.command.content_hash:
        return ScheduleEnd.EDITED
    if author is None or author.id != kept.asked.command.author.id or post.author.id != author.id:
        return ScheduleEnd.RIGHTS
    if settings.boards and post.board_id not in settings.boards:  # a moderator moved it where nobody may command
        return ScheduleEnd.RIGHTS
    refused = may(author, "command", simulated=settings.simulated).decision is Decision.REFUSE
    return ScheduleEnd.RIGHTS if refused else None
