"""Carry out one command, from its claim on the forum to its final reply."""

from __future__ import annotations

import asyncio
import contextlib
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import timedelta
from functools import partial
from typing import Any, TypeVar

import structlog

from agentrob.agent.execution.execute import Execution, decisive, holder_of
from agentrob.agent.final_report import FinalReport
from agentrob.agent.intake.authorization import CommandTerms, own_rights
from agentrob.agent.intake.event_stream import EventStream
from agentrob.agent.intake.rate_limit import RateLimiter
from agentrob.agent.joint.summaries import PartSummaries
from agentrob.agent.joint.waits import PartWaits
from agentrob.agent.motion import EXECUTION, Motion
from agentrob.agent.queue.approvals import Approvals
from agentrob.agent.queue.previews import Previews
from agentrob.agent.queue.queue import LATE_S, CommandQueue, QueuedCommand
from agentrob.agent.queue.schedules import MOST, Schedules
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting import room_text, schedule_text, visual_text
from agentrob.agent.reporting.preview_text import preview_text
from agentrob.agent.reporting.status_post import (
    DeniedWrites,
    Shown,
    StatusPost,
    is_final,
    left_open,
    retry_until_answered,
)
from agentrob.agent.stop.owner import OwnerActions
from agentrob.agent.stop.replies import StopReplies
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.rows import ScheduledCommand
from agentrob.agent.understanding.extract import Assessment
from agentrob.agent.understanding.surroundings import Surroundings
from agentrob.agent.understanding.understand import Assessor
from agentrob.config.robots import RobotConfig
from agentrob.errors import JournalError, RobotError
from agentrob.forums.protocol import Forum
from agentrob.language.addressing import addresses
from agentrob.language.joint.reading import JointProblem, joint_command
from agentrob.language.messages.catalog import join_sentences, quote, say
from agentrob.language.messages.durations import duration
from agentrob.language.messages.help import help_text
from agentrob.model import (
    AccountKind,
    Command,
    CommandState,
    Decision,
    EndReason,
    Hindrance,
    Intent,
    Language,
    Plan,
    Primitive,
    Report,
    Verdict,
)
from agentrob.model.schedules import first_runs
from agentrob.robots.driver.client import DriverClient

#: How long the status post waits for the mind: a program's post that asks for nothing gets no status post.
GLANCE_S = 1.0
T = TypeVar("T")
_log = structlog.get_logger()


@dataclass(frozen=True)
class Pipeline:
    """Carries out the commands of one robot; `run` carries out one.

    `clock_set` returns by how much the forum's clock was set, if that was just noticed.
    """

    name: str
    settings: RobotConfig
    forum: Forum
    driver: DriverClient
    assessor: Assessor
    journal: Journal
    event_stream: EventStream
    queue: CommandQueue
    stops: StopReplies
    approvals: Approvals
    rate_limiter: RateLimiter
    surroundings: Surroundings
    motion: Motion
    writes: DeniedWrites
    final_report: FinalReport
    owner: OwnerActions
    clock_set: Callable[[], timedelta | None]
    schedules: Schedules
    previews: Previews
    parts: PartWaits
    summaries: PartSummaries

    @property
    def terms(self) -> CommandTerms:
        names = tuple(self.assessor.names)
        return CommandTerms(
            self.settings.consents, self.event_stream.step_s, robot=self.name, scene=self.surroundings.scene,
            names=names, boards=tuple(self.settings.boards), rights=own_rights(self.settings),
        )  # fmt: skip

    async def run(self, job: QueuedCommand) -> None:
        """Carry out a command, from its claim to its final reply. An error in between becomes the reply."""
        job.status = StatusPost(self.forum, job.command)
        try:
            report = await self._decide(job)
        except Exception as e:
            report = await self._report_fault(job, e)
        finally:
            self.queue.leave(job)
        if report is not None:
            await self.final_report.post_final(job, report)

    async def _report_fault(self, job: QueuedCommand, error: Exception) -> Report:
        """The report of a command that an error ended, with everything measured until then (law 18)."""
        if isinstance(error, RobotError):
            message = say("agent.because.driver", job.command.language, message=error)
        elif isinstance(error, JournalError):
            _log.error("journal failed", post=job.command.post_id, error=str(error))
            message = self._reason_text(job, "journal" if job.run is None else "not_kept")
        else:
            # As text: pretty tracebacks with locals take minutes and put people's words and tokens into the log.
            trace = "".join(traceback.format_exception(error))
            _log.error("command failed", post=job.command.post_id, trace=trace)
            message = self._reason_text(job, "internal")
        plan = job.assessment.understanding.plan if job.assessment is not None else Plan()
        execution = job.run.execution() if job.run is not None else None
        if execution is None and job.begun:  # before this process, which knows of it only what is in the journal
            with job.log_errors("what was measured is not read"):
                text = await self.journal.motion_result(job.command.key)
                execution = EXECUTION.validate_json(text) if text is not None else None
        if execution is None:
            return self._report(
                job, CommandState.INTERRUPTED if job.begun else CommandState.FAILED, plan, message=message
            )
        return self._report(job, execution.status, plan, execution, message=message)

    async def decline(self, command: Command) -> None:
        """Reply to a command that the journal could not record: its first status is its end."""
        job = QueuedCommand(command)
        report = self._report(job, CommandState.FAILED, message=self._reason_text(job, "journal"))
        shown = Shown(reply_text.final(report), command.card(CommandState.FAILED))
        await self.writes.when_allowed(partial(StatusPost(self.forum, command).claim, shown))
        self.final_report.on_end(report)

    async def _decide(self, job: QueuedCommand) -> Report | None:
        """The final report; None if there is no reply (the post asks for nothing, or was answered before)."""
        thinking = asyncio.ensure_future(self.assessor.think(job, self.terms))
        try:
            return await self._claimed(job, thinking)
        finally:
            thinking.cancel()  # where the claim failed or is not ours, nobody pays for a thought that nobody reads

    async def _claimed(self, job: QueuedCommand, thinking: asyncio.Future[Assessment]) -> Report | None:
        """The final report of a post that is read while it is claimed."""
        key = job.command.key
        await asyncio.wait({thinking}, timeout=GLANCE_S)
        # A person who speaks to a robot always gets an answer; programs would answer each other without end.
        person = job.command.author.kind is AccountKind.HUMAN
        expected = job.known or job.command.run is not None  # a run that was announced is never silently dropped
        silent = not expected and not (person and addresses(job.command.text, self.assessor.names))
        if thinking.done() and silent and thinking.result().understanding.intent is Intent.NOTHING:
            await self.journal.finish(key, CommandState.NOTHING)
            return None
        ours, has_ended = await self._claim(job)
        if has_ended:
            await self.journal.finish(key, CommandState.HANDLED_ELSEWHERE)
            return None
        if not ours:  # another agent's, or of a journal that is lost: whoever holds it reports the end, if anybody does
            thinking.cancel()
            await self.journal.cancel(key)
            self.queue.leave(job)
            claimed = await retry_until_answered(partial(self.forum.post, job.status.post_id))
            if not await left_open(self.forum, claimed, self.moves):
                await self.journal.finish(key, CommandState.HANDLED_ELSEWHERE)
                return None
            return self._report(
                job, CommandState.INTERRUPTED, message=say("agent.interrupted.claim", job.command.language)
            )
        assessment: Assessment = await thinking
        if assessment.understanding.cancels:
            job.cancelled_earlier = await self._cancel_earlier(job)
        if job.joint is not None and job.command.part == 1 and job.joint.first == self.name:
            await self.summaries.add(job.command)
        if assessment.schedule is not None:
            return await self._schedule(job, assessment)
        if assessment.previews and job.ended is None:
            return await self._preview(job, assessment)
        if job.ended is None and assessment.understanding.intent is Intent.COMMAND:
            return await self._execute_command(job, assessment)
        return await self._answer(job, assessment)

    async def _claim(self, job: QueuedCommand) -> tuple[bool, bool]:
        """Post the first status. Return whether the claim is ours, and whether its end was posted before (law 6)."""
        command = job.command
        shown = Shown(reply_text.seen(command.language, command.trace_id), command.card(CommandState.SEEN))
        written = await self.writes.when_allowed(partial(job.status.claim, shown), partial(self._denied, job))
        job.note("seen", self.event_stream.now())
        now = written.post
        if not written.created:
            state = now.card.state if now.card else ""
            if is_final(now.card):  # what our journal knows of it may be more than whoever posted that knew
                ended = await self.journal.moved(command.key, ended=True)
                if not ended:
                    return False, True
            elif command.trace_id not in (now.raw, now.card.trace_id if now.card else ""):
                return False, False
            elif state == CommandState.RUNNING and not await self.journal.moved(command.key):
                return False, False  # a journal that knows of no motion may be an old copy: the forum knows more
            job.status.adopt(now)
        await self.journal.set_status_post(command.key, now.id)
        return True, False

    async def _denied(self, job: QueuedCommand, seconds: float) -> None:
        """The forum denies us the claim: let others pass meanwhile. A command that has become too old only waits for
        its reply."""
        await self.queue.let_others_pass(job, seconds)
        if job.can_end and job.waited_s + time.monotonic() - job.accepted_s > self._expiry_s(job):
            job.end(EndReason.EXPIRED)
            self.queue.leave(job)
            await self.journal.end([job.command.key], EndReason.EXPIRED)

    async def moves(self, trace_id: str) -> bool:
        """Whether the driver now carries out the command of this trace id, from whichever agent."""
        with contextlib.suppress(RobotError):
            return await self.driver.holder() == holder_of(trace_id)
        return False

    async def _answer(self, job: QueuedCommand, assessment: Assessment) -> Report:
        """The report of a post that moves nothing."""
        language, understood = job.command.language, assessment.understanding
        if job.ended is not None:
            await self.journal.cancel(job.command.key)
            return await self._ended(job, understood.plan)
        match understood.intent:
            case Intent.HELP:
                sees = self.assessor.detector is not None
                text = help_text(await self.driver.capabilities(), self.name, language, sees=sees)
                return self._report(job, CommandState.ANSWERED, message=text)
            case Intent.STATUS:
                return self._report(job, CommandState.ANSWERED, message=await self._state_text(language))
            case Intent.SCHEDULES:
                text = schedule_text.listed(await self.journal.schedules(), language)
                return self._report(job, CommandState.ANSWERED, message=text)
            case Intent.CANCEL:
                key = "talk.cancel" if job.cancelled_earlier else "talk.cancel_nothing"
                return self._report(job, CommandState.ANSWERED, message=say(key, language, count=job.cancelled_earlier))
            case Intent.QUESTION:
                return self._report(
                    job,
                    CommandState.ANSWERED,
                    message=reply_text.disarmed(understood.question) or say("talk.question", language),
                )
            case Intent.ASK_BACK if assessment.verdict is not None:
                return self._report(job, CommandState.REFUSED, verdict=assessment.verdict)
            case Intent.ASK_BACK:
                problem = joint_command(job.command.text)
                hint = problem.example if isinstance(problem, JointProblem) else ""
                message = understood.question or say("agent.ask.default", language)
                return self._report(job, CommandState.ASKS_BACK, message=message, hint=hint)
            case Intent.STOP | Intent.HALT:  # in words that only the mind understood
                ended = self.queue.end_before(job, EndReason.STOP)
                for other in ended:
                    other.stopped_by = job.command.author.name
                stop = await self.stops.stop(job.command.author.name, job.command.posted_at)
                await self.journal.end([other.command.key for other in ended], EndReason.STOP)
                return self._report(job, CommandState.STOPPED, stop=stop)
        return self._report(job, CommandState.ANSWERED, message=say("agent.nothing", language))

    async def _cancel_earlier(self, job: QueuedCommand) -> int:
        """End the earlier commands of its author that do not move; return how many."""
        before = self.queue.end_waiting(job, EndReason.TAKEN_BACK)
        await self.journal.end([other.command.key for other in before], EndReason.TAKEN_BACK)
        return len(before)

    async def _state_text(self, language: Language) -> str:
        try:
            state = await self.driver.state()
            more = await self.owner.of_state(state, language)
            return "\n\n".join([reply_text.state_text(state, len(self.queue) - 1, language), *more])
        except RobotError as e:
            return reply_text.state_text(None, len(self.queue) - 1, language, str(e))

    async def _ended(self, job: QueuedCommand, plan: Plan, execution: Execution | None = None) -> Report:
        """The report of a command that was ended from outside, before its motion or during it."""
        why, language = job.ended or EndReason.BEFORE, job.command.language
        if why is EndReason.MISSED and job.command.run is not None:
            late_s = min(self.settings.max_post_age_s, LATE_S)
            message = schedule_text.missed(job.command.run, late_s, language)
            return self._report(job, CommandState.EXPIRED, message=message)
        if why.state_before_motion is CommandState.EXPIRED and execution is None:
            wait = duration(self.approvals.wait_of(job) if why is EndReason.LAPSED else self._expiry_s(job), language)
            limits = {"seconds": self.settings.max_post_age_s, "wait": wait}
            by = self.clock_set()
            sentences = [
                say(f"agent.{why}", language, **limits),
                *([reply_text.clock_set(by, language)] if by is not None else []),
            ]
            return self._report(job, CommandState.EXPIRED, plan, message=" ".join(sentences))
        if why is EndReason.DENIED and execution is None and job.decided is not None:
            reason = say("agent.denied.by", language, who=quote(job.decided.by.name))
            return self._report(
                job, CommandState.REFUSED, plan, verdict=Verdict(Decision.REFUSE, "approval.denied", reason)
            )
        stop = await job.stop if job.stop is not None and execution is not None else None
        status = execution.status if execution else CommandState.CANCELLED
        message = job.stopped_by if status is CommandState.STOPPED else job.because or self._reason_text(job, why)
        return self._report(job, status, plan, execution, message=message, stop=stop)

    async def _schedule(self, job: QueuedCommand, assessment: Assessment) -> Report:
        """Keep a command for later times; nothing moves now. A restart finds the schedule that was kept."""
        command, plan, verdict = job.command, assessment.understanding.plan, assessment.verdict
        assert assessment.schedule is not None
        kept = await self.journal.schedule(command.post_id)
        if kept is None:
            if job.ended is None and (refused := self._refusal(job, assessment)) is not None:
                return refused
            if job.ended is None and (waiting := await self._wait_for_rate_limit(job)) is not None:
                return self._report(job, CommandState.REFUSED, plan, verdict=waiting)
            mine = [k for k in await self.journal.schedules() if k.asked.command.author.id == command.author.id]
            if sum(other.ended is None for other in mine) >= MOST:
                reason = say("schedule.full", command.language, count=MOST)
                full = Verdict(Decision.REFUSE, "schedule.full", reason)
                return self._report(job, CommandState.REFUSED, plan, verdict=full)
            if job.ended is not None:
                await self.journal.cancel(command.key)
                return await self._ended(job, plan)
            understood = reply_text.planned(plan, command.language, job.goal_text)
            asked = ScheduledCommand(command, assessment.schedule, assessment.untimed, understood)
            kept = await self.journal.add_schedule(asked, first_runs(assessment.schedule, 1)[0])
            self.schedules.changed()
        asks = verdict is not None and verdict.decision is Decision.NEEDS_APPROVAL
        text = schedule_text.scheduled(kept, command.language, needs_approval=asks)
        return self._report(job, CommandState.ANSWERED, message=text)

    async def _preview(self, job: QueuedCommand, assessment: Assessment) -> Report:
        """Rehearse a command; nothing moves. It is judged and rate-limited like one that would. A stop ends it."""
        command, plan = job.command, assessment.understanding.plan
        if (refused := self._refusal(job, assessment)) is not None:
            return refused
        if (waiting := await self._wait_for_rate_limit(job)) is not None:
            return self._report(job, CommandState.REFUSED, plan, verdict=waiting)
        self._show(job, say("preview.running", command.language), CommandState.SEEN)
        job.preview = await self.previews.unless_ended(job, plan)
        if job.preview is None:
            await self.journal.cancel(command.key)
            return await self._ended(job, plan)
        text = preview_text(job.preview, command.language)
        return self._report(job, CommandState.ANSWERED, Plan(notes=plan.notes), message=text)

    def _refusal(self, job: QueuedCommand, assessment: Assessment) -> Report | None:
        """The report of a command that the screen refuses or asks about; None if it may run, perhaps with an
        approval."""
        plan, verdict = assessment.understanding.plan, assessment.verdict
        assert verdict is not None
        if verdict.decision in (Decision.ALLOW, Decision.NEEDS_APPROVAL):
            return None
        asks = verdict.decision is Decision.ASK_BACK
        status = CommandState.ASKS_BACK if asks else CommandState.REFUSED
        return self._report(job, status, plan, verdict=verdict, message=verdict.reason if asks else "")

    def _expiry_s(self, job: QueuedCommand) -> float:
        """How long after its post, or after the time of its run, a command may begin."""
        return self.settings.queue_expiry_s if job.command.run is None else min(self.settings.queue_expiry_s, LATE_S)

    async def _execute_command(self, job: QueuedCommand, assessment: Assessment) -> Report:
        """Carry out a command: check the verdict, wait for approval, for other robots and for its turn, then move."""
        plan, verdict, command = assessment.understanding.plan, assessment.verdict, job.command
        assert verdict is not None
        if (refused := self._refusal(job, assessment)) is not None:
            return refused
        if not job.begun and (waiting := await self._wait_for_rate_limit(job)) is not None:
            return self._report(job, CommandState.REFUSED, plan, verdict=waiting)
        if verdict.decision is Decision.NEEDS_APPROVAL:
            planned = reply_text.planned(plan, command.language, job.goal_text)
            rehearsable = plan if assessment.goal is None else None
            await self.approvals.wait(job, planned, verdict.reason, rehearsable)
        if job.joint is not None:
            await self.parts.wait(job)
        self.show_place(job)
        if not await self.queue.turn(job, self._expiry_s(job)):
            await self.journal.cancel(command.key)
            return await self._ended(job, plan)
        if not job.begun and not await self._wait_for_room(job, plan):
            await self.journal.cancel(command.key)
            return await self._ended(job, plan)
        if not job.begun and (elsewhere := await self._left_preview(job, plan)) is not None:
            return self._report(job, CommandState.REFUSED, plan, verdict=elsewhere)
        if job.joint is not None and not job.begun and not await self.parts.take(job):
            await self.journal.cancel(command.key)
            return await self._ended(job, plan)
        recorded = True
        show_step, show_wait = partial(self._show_step, job, plan), partial(self._show_wait, job, CommandState.RUNNING)
        try:
            text = await self.journal.move(
                command.key, partial(self.motion.run, job, plan, self.terms, show_step, show_wait)
            )
        except Exception:
            if job.run is None:
                raise
            recorded = False  # the robot was given steps: their results are reported, whatever failed since
            _log.error("motion not recorded", post=command.post_id, trace=traceback.format_exc())
            text = ""
        if text == CommandState.CANCELLED:
            return await self._ended(job, plan)
        if text == CommandState.INTERRUPTED:
            await self.stops.stop("interrupted command", self.event_stream.now())
            return self._report(job, CommandState.INTERRUPTED, plan, verdict=verdict)
        execution = job.run.execution() if job.run is not None else self.motion.read(text)
        return await self._report_execution(
            job, plan, replace(execution, verdict=decisive(execution, verdict)), recorded
        )

    async def _wait_for_room(self, job: QueuedCommand, plan: Plan) -> bool:
        """Wait, before anything begins, until no other robot moves in the shared room. Return False if the command was
        ended or expired meanwhile. If waiting does not help, the driver refuses the first step."""
        left_s = self._expiry_s(job) - (time.monotonic() - job.queued_s)
        show = partial(self._show_wait, job, CommandState.QUEUED)
        hindrance = await job.unless_ended(self.motion.room.enter(plan.steps, show, lambda: job.ended, left_s))
        if hindrance is not None and hindrance.passes:
            job.end(EndReason.EXPIRED)
        return job.ended is None

    async def _left_preview(self, job: QueuedCommand, plan: Plan) -> Verdict | None:
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

    async def _report_execution(self, job: QueuedCommand, plan: Plan, execution: Execution, recorded: bool) -> Report:
        """The report of a command whose motion began. `recorded`: the journal has its result."""
        language = job.command.language
        job.stopped_by = job.stopped_by or execution.stopped_by
        job.looked = execution.looked
        if job.ended is not None and execution.status is not CommandState.DONE:
            return await self._ended(job, plan, execution)
        if execution.status is CommandState.STOPPED:  # past us: at the robot's machine, or by another of its clients
            return self._report(job, CommandState.STOPPED, plan, execution, message=job.stopped_by)
        sentences = [say("agent.because.driver", language, message=execution.message)] if execution.message else []
        sentences = sentences or [self._reason_text(job, execution.fault)] if execution.fault else sentences
        sentences = sentences or [why] if (why := visual_text.why(execution.looked, language)) else sentences
        sentences += [] if recorded else [self._reason_text(job, "not_kept")]
        return self._report(job, execution.status, plan, execution, message=join_sentences(sentences, language))

    async def _wait_for_rate_limit(self, job: QueuedCommand) -> Verdict | None:
        """Wait until the account is within its rate limit; return a refusal if that takes long."""
        author, language = job.command.author, job.command.language
        most = self.settings.rates.waiting
        if most and len(self.queue.of_same_author(job)) >= most:
            return Verdict(Decision.REFUSE, "rate.waiting", say("agent.rate.waiting", language, count=most))
        await self.queue.in_order(job)
        while job.ended is None and (wait := self.rate_limiter.take(author.id)) is not None:
            if not wait.short:
                count = self.settings.rates.commands_per_hour
                return Verdict(
                    Decision.REFUSE, wait.rule, say(f"agent.{wait.rule}", language, minutes=wait.minutes, count=count)
                )
            self._show(job, say("agent.held", language, seconds=wait.seconds), CommandState.QUEUED)
            await self.queue.hold(job, wait.seconds)
        self.queue.mark_admitted(job)
        return None

    # ------------------------------------------------------------------ status posts
    def show_place(self, job: QueuedCommand) -> None:
        """Show a command that waits its place in the queue."""
        if (
            job.ended is None
            and not job.held
            and not job.waits_for_others
            and not job.begun
            and "seen" in job.timings_ms
            and (ahead := self.queue.ahead(job))
        ):
            left = [other.left_s for other in ahead]
            wait_s = None if None in left else sum(seconds for seconds in left if seconds is not None)
            behind = ahead[-1].command.author.name
            text = reply_text.queued(job.command.language, len(ahead), behind, wait_s)
            self._show(job, text, CommandState.QUEUED, place=len(ahead))

    def _show(self, job: QueuedCommand, text: str, state: CommandState, **more: Any) -> None:
        job.status.show(Shown(text, job.command.card(state, **more)))

    def _show_wait(self, job: QueuedCommand, state: CommandState, hindrance: Hindrance) -> None:
        """Show for whom the command waits in the room."""
        doing = room_text.who_does(hindrance, job.command.language)
        card = f"{say('agent.room.card', job.command.language)} {doing}"
        self._show(job, room_text.waits_for_room(hindrance, job.command.language), state, doing=card)

    def _show_step(self, job: QueuedCommand, plan: Plan, step: Primitive, number: int) -> None:
        language = job.command.language
        doing = reply_text.doing(step, language)
        if goal := job.goal_text:
            text = say("visual.running", language, step=number + 1, doing=doing, goal=goal)
            return self._show(job, text, CommandState.RUNNING, step=number + 1, doing=doing)
        text = reply_text.running(language, number, plan.steps)
        self._show(job, text, CommandState.RUNNING, step=number + 1, steps=len(plan.steps), doing=doing)

    def _reason_text(self, job: QueuedCommand, why: str) -> str:
        return say(f"agent.because.{why}", job.command.language)

    def _report(
        self,
        job: QueuedCommand,
        status: CommandState,
        plan: Plan = Plan(),
        execution: Execution | None = None,
        **more: Any,
    ) -> Report:
        if execution is not None:
            more = {"results": execution.results, "verdict": execution.verdict, "findings": execution.findings, **more}
        by = job.decided.by.name if job.decided is not None and job.decided.approved else ""
        timings = dict(job.timings_ms)
        return Report(job.command, status, plan=plan, timings_ms=timings, goal=job.goal_text, approved_by=by, **more)
