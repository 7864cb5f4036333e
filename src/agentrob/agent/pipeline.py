"""Carry out one command, from its claim on the forum to its final reply."""

from __future__ import annotations

import asyncio
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial

import structlog

from agentrob.agent.admission import Admission
from agentrob.agent.answers import Answers
from agentrob.agent.claims import Claim, Claims
from agentrob.agent.execution.execute import decisive
from agentrob.agent.final_report import FinalReport
from agentrob.agent.joint.summaries import PartSummaries
from agentrob.agent.joint.waits import PartWaits
from agentrob.agent.motion import Motion
from agentrob.agent.outcomes import Outcomes, refusal, report_of
from agentrob.agent.progress import show_place, show_step, show_wait
from agentrob.agent.queue.approvals import Approvals
from agentrob.agent.queue.queue import CommandQueue, QueuedCommand, expiry_s
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting.status_post import StatusPost
from agentrob.agent.stop.replies import StopReplies
from agentrob.agent.store.journal import Journal
from agentrob.agent.understanding.extract import Assessment
from agentrob.agent.understanding.understand import Assessor
from agentrob.config.robots import RobotConfig
from agentrob.forums.protocol import Forum
from agentrob.language.addressing import addresses
from agentrob.language.messages.catalog import say
from agentrob.model import AccountKind, CommandState, Decision, EndReason, Intent, Plan, Report, Verdict

#: How long the status post waits for the mind: a program's post that asks for nothing gets no status post.
GLANCE_S = 1.0
_log = structlog.get_logger()


@dataclass(frozen=True)
class Pipeline:
    """Carries out the commands of one robot; `run` carries out one. `now` is the forum's clock."""

    name: str
    settings: RobotConfig
    forum: Forum
    journal: Journal
    queue: CommandQueue
    now: Callable[[], datetime]
    assessor: Assessor
    claims: Claims
    answers: Answers
    admission: Admission
    approvals: Approvals
    parts: PartWaits
    summaries: PartSummaries
    motion: Motion
    stops: StopReplies
    outcomes: Outcomes
    final_report: FinalReport

    async def run(self, job: QueuedCommand) -> None:
        """Carry out a command, from its claim to its final reply. An error in between becomes the reply."""
        job.status = StatusPost(self.forum, job.command)
        try:
            report = await self._decide(job)
        except Exception as e:
            report = await self.outcomes.fault(job, e)
        finally:
            self.queue.leave(job)
        if report is not None:
            await self.final_report.post_final(job, report)

    async def _decide(self, job: QueuedCommand) -> Report | None:
        """The final report; None if there is no reply (the post asks for nothing, or was answered before)."""
        thinking = asyncio.ensure_future(self.assessor.think(job, self.motion.terms))
        try:
            return await self._claimed(job, thinking)
        finally:
            thinking.cancel()  # where the claim failed or is not ours, nobody pays for a thought that nobody reads

    async def _claimed(self, job: QueuedCommand, thinking: asyncio.Future[Assessment]) -> Report | None:
        """The final report of a post that is read while it is claimed."""
        key = job.command.key
        await asyncio.wait({thinking}, timeout=GLANCE_S)
        if thinking.done() and self._passes_over(job, thinking.result()):
            await self.journal.finish(key, CommandState.NOTHING)
            return None
        claim = await self.claims.claim(job)
        if claim is Claim.OTHERS:
            thinking.cancel()
            if await self.claims.abandoned(job):
                lost = say("agent.interrupted.claim", job.command.language)
                return report_of(job, CommandState.INTERRUPTED, message=lost)
        if claim is not Claim.OURS:  # whoever holds it reports its end, or did
            await self.journal.finish(key, CommandState.HANDLED_ELSEWHERE)
            return None
        assessment = await thinking
        if assessment.understanding.cancels:
            job.cancelled_earlier = await self.answers.cancel_earlier(job)
        if job.joint is not None and job.command.part == 1 and job.joint.first == self.name:
            await self.summaries.add(job.command)
        moves = assessment.understanding.intent is Intent.COMMAND and job.ended is None
        if moves and assessment.schedule is None and not assessment.previews:
            return await self._execute_command(job, assessment)
        return await self.answers.answer(job, assessment)

    def _passes_over(self, job: QueuedCommand, assessment: Assessment) -> bool:
        """Whether a post that asks for nothing gets no reply. A person who speaks to a robot always gets one; programs
        would answer each other without end."""
        person = job.command.author.kind is AccountKind.HUMAN
        expected = job.known or job.command.run is not None  # a run that was announced is never silently dropped
        silent = not expected and not (person and addresses(job.command.text, self.assessor.names))
        return silent and assessment.understanding.intent is Intent.NOTHING

    async def _execute_command(self, job: QueuedCommand, assessment: Assessment) -> Report:
        """Carry out a command: check the verdict, wait for approval, for other robots and for its turn, then move."""
        plan, verdict, command = assessment.understanding.plan, assessment.verdict, job.command
        assert verdict is not None
        if (refused := refusal(job, assessment)) is not None:
            return refused
        if not job.begun and (limited := await self.admission.admit(job)) is not None:
            return report_of(job, CommandState.REFUSED, plan, verdict=limited)
        if verdict.decision is Decision.NEEDS_APPROVAL:
            planned = reply_text.planned(plan, command.language, job.goal_text)
            rehearsable = plan if assessment.goal is None else None
            await self.approvals.wait(job, planned, verdict.reason, rehearsable)
        if job.joint is not None:
            await self.parts.wait(job)
        show_place(job, self.queue)
        if not await self.queue.turn(job, expiry_s(command, self.settings)):
            return await self.outcomes.cancelled(job, plan)
        if not job.begun:
            if not await self._wait_for_room(job, plan):
                return await self.outcomes.cancelled(job, plan)
            if (mismatch := await self.approvals.mismatch(job, plan)) is not None:
                return report_of(job, CommandState.REFUSED, plan, verdict=mismatch)
            if job.joint is not None and not await self.parts.take(job):
                return await self.outcomes.cancelled(job, plan)
        return await self._move(job, plan, verdict)

    async def _wait_for_room(self, job: QueuedCommand, plan: Plan) -> bool:
        """Wait, before anything begins, until no other robot moves in the shared room. Return False if the command was
        ended or expired meanwhile. If waiting does not help, the driver refuses the first step."""
        left_s = expiry_s(job.command, self.settings) - (time.monotonic() - job.queued_s)
        show = partial(show_wait, job, CommandState.QUEUED)
        hindrance = await job.unless_ended(self.motion.room.enter(plan.steps, show, lambda: job.ended, left_s))
        if hindrance is not None and hindrance.passes:
            job.end(EndReason.EXPIRED)
        return job.ended is None

    async def _move(self, job: QueuedCommand, plan: Plan, verdict: Verdict) -> Report:
        """Move, unless the journal knows that the motion began before; report what was measured."""
        command, recorded = job.command, True
        on_step, on_wait = partial(show_step, job, plan), partial(show_wait, job, CommandState.RUNNING)
        run = partial(self.motion.run, job, plan, self.motion.terms, on_step, on_wait)
        try:
            text = await self.journal.move(command.key, run)
        except Exception:
            if job.run is None:
                raise
            recorded = False  # the robot was given steps: their results are reported, whatever failed since
            _log.error("motion not recorded", post=command.post_id, trace=traceback.format_exc())
            text = ""
        if text == CommandState.CANCELLED:
            return await self.outcomes.ended(job, plan)
        if text == CommandState.INTERRUPTED:
            await self.stops.stop("interrupted command", self.now())
            return report_of(job, CommandState.INTERRUPTED, plan, verdict=verdict)
        execution = job.run.execution() if job.run is not None else self.motion.read(text)
        return await self.outcomes.moved(job, plan, replace(execution, verdict=decisive(execution, verdict)), recorded)
