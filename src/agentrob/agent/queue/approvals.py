"""Let commands wait for approval, and handle the posts that approve or deny them (laws 1, 2, 4, 5 and 7).

An approval is a post of its own: by an account that may approve, fresh, never edited, and about one command. It counts
once it is in the journal, and is checked again immediately before motion (`permission`).
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from functools import partial
from typing import Any

import structlog

from agentrob.agent.intake.authorization import CommandTerms, own_rights, rights_on
from agentrob.agent.intake.triage import Route, TriagedPost
from agentrob.agent.queue.previews import Previews
from agentrob.agent.queue.queue import LATE_S, CommandQueue, QueuedCommand, ShownPreview
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting.preview_text import approval_preview
from agentrob.agent.reporting.status_post import SOON_S, Shown, retry_until_answered, retry_while_denied
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.rows import ApprovalDecision
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumDenied, ForumError, ForumNotFound, JournalError
from agentrob.forums.protocol import Forum
from agentrob.language.messages.catalog import say
from agentrob.model import CommandState, Decision, EndReason, Plan, Post, Verdict
from agentrob.rehearsal.preview import Preview, read_preview, write_preview
from agentrob.screening.rights import may_approve

#: For this long after a decision in a thread, an approval must reply to the command that it means, so that two people
#: who approve the same command at once do not approve the next one too.
OTHER_S = 30.0
#: The tolerance for the agent's estimate of the forum's clock.
CLOCK_S = 2.0
#: The timeout for asking the forum who may approve.
ASK_S = 10.0
#: How long a decided command waits for the end of its preview's process.
CANCEL_S = 1.0
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
    spawn: Callable[[Coroutine[Any, Any, Any]], asyncio.Task[Any]]
    previews: Previews
    _settled_at: dict[str, datetime] = field(default_factory=dict)

    # ---------------------------------------------------------------- waiting
    @property
    def wait_s(self) -> float:
        """Return how long after its post a command can be approved."""
        return min(self.settings.approval.wait_s, self.settings.queue_expiry_s)

    def wait_of(self, job: QueuedCommand) -> float:
        """Return how long after its post, or after the time of its run, this command can be approved."""
        return self.wait_s if job.command.run is None else min(self.wait_s, LATE_S)

    async def wait(self, job: QueuedCommand, understood: str, needed: str, plan: Plan | None) -> None:
        """Wait until the command is approved or ended: denied, stopped, changed, or not approved in time.

        Other commands pass it meanwhile. After a restart it continues to wait.

        `understood` says what it would do and `needed` why it needs an approval. The `plan` is rehearsed meanwhile, and
        an approval that comes afterwards is bound to that preview. A decision waits for nothing of this: neither for
        the preview nor for a forum that takes its time to show the question.
        """
        wait_s = self.wait_of(job)
        until_at = job.command.posted_at + timedelta(seconds=wait_s)
        job.asked = await self.journal.ask(job.command.key, self.now(), until_at)
        if job.decided is not None:
            with job.log_errors("preview not recalled"):
                await self._recall(job)
        else:
            job.asking = self.spawn(self._ask(job, understood, needed, plan, job.asked.until_at))
            job.asking.add_done_callback(lambda _: job.notify())
        try:
            await self.queue.hold(job, self._left_s(job), until=lambda: job.decided or _failed(job.asking))
        finally:
            await _cancelled(job.asking)
        if job.ended is None and job.decided is None:
            if job.asking is not None and _failed(job.asking):
                job.asking.result()
            job.end(EndReason.LAPSED)
            await self.journal.end([job.command.key], EndReason.LAPSED)
        self._settle(job.command.topic_id, self.now())

    async def mismatch(self, job: QueuedCommand, plan: Plan) -> Verdict | None:
        """Refuse what was approved by a preview of another plan, as another version of AgentRob may have read the post,
        and a walk that was approved by one from another place: it would not be what was approved."""
        language, approved = job.command.language, job.preview
        bound = job.decided is not None and approved is not None and job.decided.preview == approved.hash
        if bound and approved is not None and approved.plan.steps != plan.steps:
            return Verdict(Decision.REFUSE, "approval.preview", say("agent.approval.other", language))
        start = job.decided.start if job.decided is not None else None
        if start is None or not plan.distance_m or (metres := await self.previews.moved_since(start)) is None:
            return None
        reason = say("agent.approval.moved", language, metres=metres)
        return Verdict(Decision.REFUSE, "approval.preview", reason)

    def _left_s(self, job: QueuedCommand) -> float:
        """Return how much longer it can be approved."""
        assert job.asked is not None
        left_s = self.wait_of(job) - job.waited_s - (time.monotonic() - job.accepted_s)
        return max(0.0, min(left_s, (job.asked.until_at - self.now()).total_seconds()))

    async def _ask(
        self, job: QueuedCommand, understood: str, needed: str, plan: Plan | None, until_at: datetime
    ) -> None:
        """Post that the command waits, for what and for whose approval; then what its preview found.

        A preview that an earlier process has shown stays, unless the command is understood otherwise now.
        """
        with job.log_errors("preview not recalled"):
            await retry_until_answered(partial(self._recall, job))
        if job.preview is not None and plan is not None and job.preview.plan.steps == plan.steps:
            return await self._ask_again(job, job.preview, await self._question(job, understood, needed, until_at))
        job.preview = job.shown = None
        making = None if plan is None else asyncio.create_task(self.previews.make(job.command, plan))
        try:
            question = await self._question(job, understood, needed, until_at)
            follows = [] if making is None else [say("preview.follows", job.command.language)]
            with contextlib.suppress(ForumDenied, ForumNotFound):
                await job.status.ask(_with(question, follows))
            if making is not None:
                with job.log_errors("preview not shown"):
                    await self._show_preview(job, question, making)
        finally:
            if making is not None:
                making.cancel()
                await asyncio.wait({making})

    async def _question(self, job: QueuedCommand, understood: str, needed: str, until_at: datetime) -> Shown:
        language = job.command.language
        rights = await retry_until_answered(partial(rights_on, self.forum, job.command, self._terms))
        wait_s = (until_at - job.command.posted_at).total_seconds()
        text = reply_text.waits(understood, needed, rights, self.called, wait_s, language)
        return Shown(text, job.command.card(CommandState.WAITING, until=until_at.isoformat()))

    async def _show_preview(self, job: QueuedCommand, question: Shown, making: asyncio.Task[Preview]) -> None:
        """Show a preview beside the question, or that there is none. From then on approvals are bound to it."""
        language, preview, paths = job.command.language, None, None
        found = say("preview.none", language)
        with job.log_errors("no preview"):
            preview = await making
            found = approval_preview(preview, language)
            paths = await asyncio.to_thread(self.previews.draw, preview)
        pictures = [paths] if paths else []
        added, key = Shown(found, question.card), _preview_key(preview)
        if preview is not None:  # before anybody sees it: a restart then knows what an approval is bound to
            kept = write_preview(replace(preview, frames=(), step_times_s=())).decode()
            await self.journal.keep_preview(job.command.key, kept)
        written = await job.status.ask_with(_with(question, [found]), pictures, added, key)
        if preview is not None:
            job.preview, job.shown = preview, self._shown_by(job, written)
            await self.journal.set_preview_shown(job.command.key, job.shown.at, job.shown.pictures)
            await self.previews.publish(preview, job.page)

    def _shown_by(self, job: QueuedCommand, post: Post) -> ShownPreview:
        """Since when the preview is there that this post shows."""
        if job.status.limited:  # a reply of its own
            return ShownPreview(post.created_at, 0)
        return ShownPreview(post.edited_at or self.now(), len(post.images))

    async def _recall(self, job: QueuedCommand) -> None:
        """Take up the preview that an earlier process has shown for this command, if it has. Raises `ForumError` if the
        forum must tell whether it has, and does not."""
        if job.recalled or not job.known or job.shown is not None:
            return
        kept = await self.journal.preview(job.command.key)
        if kept is not None:
            preview = read_preview(kept.data)
            if kept.shown_at is not None:
                shown: ShownPreview | None = ShownPreview(kept.shown_at, kept.pictures)
            elif (post := await self._post_with(job, preview)) is not None:  # it ended between showing and recording
                shown = self._shown_by(job, post)
                await self.journal.set_preview_shown(job.command.key, shown.at, shown.pictures)
            else:
                shown = None
            if shown is not None and not job.recalled:
                job.preview, job.shown = preview, shown
        job.recalled = True

    async def _post_with(self, job: QueuedCommand, preview: Preview) -> Post | None:
        """Return our post that shows a preview, if there is one."""
        if job.status.limited:
            return await self.forum.find(f"{_preview_key(preview)}:{job.command.key}")
        post = await self.forum.post(job.status.post_id) if job.status.post_id is not None else None
        return post if post is not None and preview.hash[:12] in post.raw else None

    async def _ask_again(self, job: QueuedCommand, preview: Preview, question: Shown) -> None:
        """Show the question with the preview that was shown before a restart, and its pictures, which are there."""
        found = approval_preview(preview, job.command.language)
        if job.status.limited:
            await job.status.ask(question)
        shown = _with(question, [found])
        with contextlib.suppress(ForumDenied, ForumNotFound):
            await job.status.ask_with(shown, [], Shown(found, question.card), _preview_key(preview))

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
        if approved and not await self._recalled(job):
            self.spawn(self._answer(post, say("agent.approval.unseen", triaged.language)))
            return
        shown = job.preview if job.shown is not None and post.created_at >= job.shown.at else None
        decided = ApprovalDecision(
            approved, post.author, post.id, post.content_hash, post.created_at,
            preview=shown.hash if shown is not None else "", start=shown.start if shown is not None else None,
        )  # fmt: skip
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

    async def _recalled(self, job: QueuedCommand) -> bool:
        """Whether it is known which preview was beside the question."""
        try:
            async with asyncio.timeout(ASK_S):
                await self._recall(job)
        except (ForumError, JournalError, TimeoutError) as e:
            _log.warning("preview not recalled", post=job.command.post_id, error=str(e))
            return False
        return True

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


def _preview_key(preview: Preview | None) -> str:
    """The first half of the key of a reply that shows a preview, where edits are limited."""
    return f"preview:{preview.hash[:12] if preview is not None else 'none'}"


def _with(question: Shown, paragraphs: Sequence[str]) -> Shown:
    return replace(question, text="\n\n".join([question.text, *paragraphs]))


def _failed(task: asyncio.Task[None] | None) -> bool:
    return task is not None and task.done() and not task.cancelled() and task.exception() is not None


async def _cancelled(task: asyncio.Task[None] | None) -> None:
    """Cancel a task; wait for its end, but not long, since a command waits for this."""
    if task is not None and not task.done():
        task.cancel()
        await asyncio.wait({task}, timeout=CANCEL_S)


def _waits(job: QueuedCommand, denies: bool) -> bool:
    """Return whether a decision on this command still counts: an approved command can be denied until it moves."""
    if job.asked is None or job.ended is not None or job.moving or job.status is None:
        return False
    return job.decided is None or denies
