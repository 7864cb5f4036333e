"""How a command ended, as its report: refused, failed, ended from outside, or with what its motion measured."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass
from datetime import timedelta
from typing import Any

import structlog

from agentrob.agent.execution.execute import Execution
from agentrob.agent.motion import EXECUTION
from agentrob.agent.queue.approvals import Approvals
from agentrob.agent.queue.queue import LATE_S, QueuedCommand, expiry_s
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting import schedule_text, visual_text
from agentrob.agent.store.journal import Journal
from agentrob.agent.understanding.extract import Assessment
from agentrob.config.robots import RobotConfig
from agentrob.errors import JournalError, RobotError
from agentrob.language.messages.catalog import join_sentences, quote, say
from agentrob.language.messages.durations import duration
from agentrob.model import CommandState, Decision, EndReason, Plan, Report, Verdict

_log = structlog.get_logger()


def report_of(
    job: QueuedCommand,
    status: CommandState,
    plan: Plan = Plan(),
    execution: Execution | None = None,
    **more: Any,
) -> Report:
    """Return the report of a command; `more` are fields of it beside those of the command and its motion."""
    if execution is not None:
        more = {"results": execution.results, "verdict": execution.verdict, "findings": execution.findings, **more}
    by = job.decided.by.name if job.decided is not None and job.decided.approved else ""
    timings = dict(job.timings_ms)
    return Report(job.command, status, plan=plan, timings_ms=timings, goal=job.goal_text, approved_by=by, **more)


def reason_text(job: QueuedCommand, why: str) -> str:
    """Return the sentence `agent.because.WHY` in the language of the command."""
    return say(f"agent.because.{why}", job.command.language)


def refusal(job: QueuedCommand, assessment: Assessment) -> Report | None:
    """Return the report of a command that the screen refuses or asks about; None if it may run, perhaps with an
    approval."""
    plan, verdict = assessment.understanding.plan, assessment.verdict
    assert verdict is not None
    if verdict.decision in (Decision.ALLOW, Decision.NEEDS_APPROVAL):
        return None
    asks = verdict.decision is Decision.ASK_BACK
    status = CommandState.ASKS_BACK if asks else CommandState.REFUSED
    return report_of(job, status, plan, verdict=verdict, message=verdict.reason if asks else "")


@dataclass(frozen=True)
class Outcomes:
    """Makes the report of a command by how it ended.

    `clock_set` returns by how much the forum's clock was set, if that was just noticed.
    """

    settings: RobotConfig
    journal: Journal
    approvals: Approvals
    clock_set: Callable[[], timedelta | None]

    async def fault(self, job: QueuedCommand, error: Exception) -> Report:
        """The report of a command that an error ended, with everything measured until then (law 18)."""
        if isinstance(error, RobotError):
            message = say("agent.because.driver", job.command.language, message=error)
        elif isinstance(error, JournalError):
            _log.error("journal failed", post=job.command.post_id, error=str(error))
            message = reason_text(job, "journal" if job.run is None else "not_kept")
        else:
            # As text: pretty tracebacks with locals take minutes and put people's words and tokens into the log.
            trace = "".join(traceback.format_exception(error))
            _log.error("command failed", post=job.command.post_id, trace=trace)
            message = reason_text(job, "internal")
        plan = job.assessment.understanding.plan if job.assessment is not None else Plan()
        execution = job.run.execution() if job.run is not None else None
        if execution is None and job.begun:  # before this process, which knows of it only what is in the journal
            with job.log_errors("what was measured is not read"):
                text = await self.journal.motion_result(job.command.key)
                execution = EXECUTION.validate_json(text) if text is not None else None
        if execution is None:
            status = CommandState.INTERRUPTED if job.begun else CommandState.FAILED
            return report_of(job, status, plan, message=message)
        return report_of(job, execution.status, plan, execution, message=message)

    async def cancelled(self, job: QueuedCommand, plan: Plan) -> Report:
        """The report of a command that ended before its motion; the journal will not begin it."""
        await self.journal.cancel(job.command.key)
        return await self.ended(job, plan)

    async def ended(self, job: QueuedCommand, plan: Plan, execution: Execution | None = None) -> Report:
        """The report of a command that was ended from outside, before its motion or during it."""
        why, language = job.ended or EndReason.BEFORE, job.command.language
        if why is EndReason.MISSED and job.command.run is not None:
            late_s = min(self.settings.max_post_age_s, LATE_S)
            message = schedule_text.missed(job.command.run, late_s, language)
            return report_of(job, CommandState.EXPIRED, message=message)
        if why.state_before_motion is CommandState.EXPIRED and execution is None:
            lapsed = why is EndReason.LAPSED
            wait_s = self.approvals.wait_of(job) if lapsed else expiry_s(job.command, self.settings)
            limits = {"seconds": self.settings.max_post_age_s, "wait": duration(wait_s, language)}
            by = self.clock_set()
            sentences = [
                say(f"agent.{why}", language, **limits),
                *([reply_text.clock_set(by, language)] if by is not None else []),
            ]
            return report_of(job, CommandState.EXPIRED, plan, message=" ".join(sentences))
        if why is EndReason.DENIED and execution is None and job.decided is not None:
            reason = say("agent.denied.by", language, who=quote(job.decided.by.name))
            denied = Verdict(Decision.REFUSE, "approval.denied", reason)
            return report_of(job, CommandState.REFUSED, plan, verdict=denied)
        stop = await job.stop if job.stop is not None and execution is not None else None
        status = execution.status if execution else CommandState.CANCELLED
        message = job.stopped_by if status is CommandState.STOPPED else job.because or reason_text(job, why)
        return report_of(job, status, plan, execution, message=message, stop=stop)

    async def moved(self, job: QueuedCommand, plan: Plan, execution: Execution, recorded: bool) -> Report:
        """The report of a command whose motion began. `recorded`: the journal has its result."""
        language = job.command.language
        job.stopped_by = job.stopped_by or execution.stopped_by
        job.looked = execution.looked
        if job.ended is not None and execution.status is not CommandState.DONE:
            return await self.ended(job, plan, execution)
        if execution.status is CommandState.STOPPED:  # past us: at the robot's machine, or by another of its clients
            return report_of(job, CommandState.STOPPED, plan, execution, message=job.stopped_by)
        sentences = [say("agent.because.driver", language, message=execution.message)] if execution.message else []
        sentences = sentences or [reason_text(job, execution.fault)] if execution.fault else sentences
        sentences = sentences or [why] if (why := visual_text.why(execution.looked, language)) else sentences
        sentences += [] if recorded else [reason_text(job, "not_kept")]
        return report_of(job, execution.status, plan, execution, message=join_sentences(sentences, language))
