"""Let commands wait for approval, and handle the posts that approve or deny them (laws 1, 2, 4, 5 and 7).

An approval is a post of its own: by an account that may approve, fresh, never edited, and about one command. It counts
once it is in the journal, and is checked again immediately before motion (`permission`).
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from functools import partial
from typing import Any

import structlog

from agentrob.agent.intake.authorization import CommandTerms, own_rights, rights_on
from agentrob.agent.intake.triage import Route, TriagedPost
from agentrob.agent.queue.queue import LATE_S, CommandQueue, QueuedCommand
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting.status_post import SOON_S, Shown, retry_until_answered, retry_while_denied
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.rows import ApprovalDecision
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumDenied, ForumError, ForumNotFound
from agentrob.forums.protocol import Forum
from agentrob.language.messages.catalog import say
from agentrob.model import CommandState, Decision, EndReason, Post, StatusCard, Verdict
from agentrob.screening.rights import may_approve

#: For this long after a decision in a thread, an approval must reply to the command that it means, so that two people
#: who approve the same command at once do not approve the next one too.
OTHER_S = 30.0
#: The tolerance for the agent's estimate of the forum's clock.
CLOCK_S = 2.0
#: The timeout for asking the forum who may approve.
ASK_S = 10.0
_log = structlog.get_logger()


@dataclass
class Approvals:
    """The approvals of one robot. `now` is the forum's clock, `spawn` starts a background task, `called` is the name by
    which posts address the robot."""

    name: str
    called: str
    settings: RobotConfig
    forum: Forum
    journal: Journal
    queue: CommandQueue
    now: Callable[[], datetime]
    spawn: Callable[[Coroutine[Any, Any, Any]], object]
    _settled_at: dict[str, datetime] = field(default_factory=dict)

    # ---------------------------------------------------------------- waiting
    @property
    def wait_s(self) -> float:
        """Return how long after its post a command can be approved."""
        return min(self.settings.approval.wait_s, self.settings.queue_expiry_s)

    def wait_of(self, job: QueuedCommand) -> float:
        """Return how long after its post, or after the time of its run, this command can be approved."""
        return self.wait_s if job.command.run is None else min(self.wait_s, LATE_S)

    async def wait(self, job: QueuedCommand, understood: str, needed: str) -> None:
        """Wait until the command is approved or ended: denied, stopped, changed, or not approved in time.

        Other commands pass it meanwhile. After a restart it continues to wait.

        `understood` says what it would do and `needed` why it needs an approval.
        """
        wait_s = self.wait_of(job)
        until_at = job.command.posted_at + timedelta(seconds=wait_s)
        job.asked = await self.journal.ask(job.command.key, self.now(), until_at)
        if job.decided is None:
            await job.unless_ended(self._post_request(job, understood, needed, job.asked.until_at))
        left_s = wait_s - job.waited_s - (time.monotonic() - job.accepted_s)
        left_s = min(left_s, (job.asked.until_at - self.now()).total_seconds())
        await self.queue.hold(job, max(0.0, left_s), until=lambda: job.decided)
        if job.ended is None and job.decided is None:
            job.end(EndReason.LAPSED)
            await self.journal.end([job.command.key], EndReason.LAPSED)
        self._settle(job.command.topic_id, self.now())

    async def _post_request(self, job: QueuedCommand, understood: str, needed: str, until_at: datetime) -> None:
        """Post that the command waits, for what and for whose approval."""
        rights = await retry_until_answered(partial(rights_on, self.forum, job.command, self._terms))
        wait_s = (until_at - job.command.posted_at).total_seconds()
        text = reply_text.waits(understood, needed, rights, self.called, wait_s, job.command.language)
        card = StatusCard(self.name, CommandState.WAITING, trace_id=job.command.trace_id, until=until_at.isoformat())
        with contextlib.suppress(ForumDenied, ForumNotFound):
            await job.status.ask(Shown(text, card))

    @property
    def _terms(self) -> CommandTerms:
        return CommandTerms(robot=self.name, rights=own_rights(self.settings))

    def _settle(self, topic_id: str, at: datetime) -> None:
        """Record that a command of this topic has been decided or has ended."""
        recent = {k: v for k, v in self._settled_at.items() if at - v <= timedelta(seconds=OTHER_S)}
        self._settled_at = recent | {topic_id: at}

    # ---------------------------------------------------------------- decisions
    async def record_decision(self, post: Post, triaged: TriagedPost) -> None:
        """Record the decision of a post that approves or denies a command, or reply why it has no effect.

        A post counts only once.
        """
        if await self.journal.has_decision(post.id):
            return
        job, why = self._meant(post, triaged)
        if job is None and not triaged.fresh:
            return  # it may have counted already, in a journal that was lost
        if job is not None:
            why = await self._objection(job, post, triaged)
        if job is None or why:
            self.spawn(self._answer(post, why))
            return
        approved = triaged.route is Route.APPROVE
        decided = ApprovalDecision(approved, post.author, post.id, post.content_hash, post.created_at)
        if not await self.journal.decide(job.command.key, decided):
            self.spawn(self._answer(post, say("agent.approval.nothing", triaged.language)))
            return
        _log.info("approval", robot=self.name, post=job.command.post_id, by=post.author.name, approved=approved)
        self._settle(post.topic_id, post.created_at)
        job.decide(decided)
        if not approved:
            job.end(EndReason.DENIED)

    def _meant(self, post: Post, triaged: TriagedPost) -> tuple[QueuedCommand | None, str]:
        """Return the command that a post decides about, or the reason why there is none."""
        denies = triaged.route is Route.DENY
        found = [job for job in self.queue if job.command.topic_id == post.topic_id and _waits(job, denies)]
        if named := [job for job in found if post.reply_to in job.status.posts or post.reply_to == job.command.post_id]:
            return named[0], ""
        if not found:
            return None, say("agent.approval.nothing", triaged.language)
        settled_at = self._settled_at.get(post.topic_id)
        shortly = settled_at is not None and post.created_at - settled_at <= timedelta(seconds=OTHER_S)
        if len(found) > 1 or post.reply_to is not None or (shortly and not denies):
            return None, say("agent.approval.which", triaged.language)
        return found[0], ""

    async def _objection(self, job: QueuedCommand, post: Post, triaged: TriagedPost) -> str:
        """Return why a post may not decide about this command, or an empty string if it may."""
        assert job.asked is not None
        language, denies = triaged.language, triaged.route is Route.DENY
        if post.version > 1:
            return say("agent.approval.edited", language)
        if not denies and not triaged.fresh:
            return say("agent.approval.stale", language, seconds=self.settings.max_post_age_s)
        if not denies and post.created_at < job.asked.asked_at - timedelta(seconds=CLOCK_S):
            return say("agent.approval.early", language)
        if denies and post.author.id == job.command.author.id:
            return ""  # the author may always withdraw the command
        verdict = await self._may(job, post, triaged)
        return "" if verdict.decision is Decision.ALLOW else verdict.reason

    async def _may(self, job: QueuedCommand, post: Post, triaged: TriagedPost) -> Verdict:
        try:
            async with asyncio.timeout(ASK_S):
                rights = await rights_on(self.forum, job.command, self._terms)
        except (ForumError, TimeoutError):
            reason = say("agent.approval.unverified", triaged.language)
            return Verdict(Decision.REFUSE, "command.unverified", reason)
        return may_approve(post.author, job.command.author, triaged.language, rights)

    async def _answer(self, post: Post, text: str) -> None:
        try:
            await retry_while_denied(
                lambda: retry_until_answered(
                    lambda: self.forum.reply(post.topic_id, text, key=f"approval:{post.id}", reply_to=post.id), tries=9
                ),
                SOON_S,
            )
        except ForumError as e:
            _log.warning("approval not answered", post=post.id, error=str(e))


def _waits(job: QueuedCommand, denies: bool) -> bool:
    """Return whether a decision on this command still counts: an approved command can be denied until it moves."""
    if job.asked is None or job.ended is not None or job.moving or job.status is None:
        return False
    return job.decided is None or denies
