"""Answer posts that move nothing now: questions, help, cancellations, schedules and previews."""

from __future__ import annotations

from dataclasses import dataclass

from agentrob.agent.admission import Admission
from agentrob.agent.outcomes import Outcomes, refusal, report_of
from agentrob.agent.progress import show
from agentrob.agent.queue.previews import Previews
from agentrob.agent.queue.queue import CommandQueue, QueuedCommand
from agentrob.agent.queue.schedules import MOST, Schedules
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting import schedule_text
from agentrob.agent.reporting.preview_text import preview_text
from agentrob.agent.stop.owner import OwnerActions
from agentrob.agent.stop.replies import StopReplies
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.rows import ScheduledCommand
from agentrob.agent.understanding.extract import Assessment
from agentrob.errors import RobotError
from agentrob.language.joint.reading import JointProblem, joint_command
from agentrob.language.messages.catalog import say
from agentrob.language.messages.help import help_text
from agentrob.model import CommandState, Decision, EndReason, Intent, Language, Plan, Report, Verdict
from agentrob.model.schedules import first_runs
from agentrob.robots.driver.client import DriverClient


@dataclass(frozen=True)
class Answers:
    """The answers of one robot. `sees`: it finds things in its pictures without a model."""

    name: str
    driver: DriverClient
    sees: bool
    journal: Journal
    queue: CommandQueue
    stops: StopReplies
    owner: OwnerActions
    admission: Admission
    schedules: Schedules
    previews: Previews
    outcomes: Outcomes

    async def answer(self, job: QueuedCommand, assessment: Assessment) -> Report:
        """The report of a post that moves nothing, or that was ended before it could."""
        language, understood = job.command.language, assessment.understanding
        if assessment.schedule is not None:
            return await self._schedule(job, assessment)
        if job.ended is not None:
            return await self.outcomes.cancelled(job, understood.plan)
        if assessment.previews:
            return await self._preview(job, assessment)
        match understood.intent:
            case Intent.HELP:
                text = help_text(await self.driver.capabilities(), self.name, language, sees=self.sees)
                return report_of(job, CommandState.ANSWERED, message=text)
            case Intent.STATUS:
                return report_of(job, CommandState.ANSWERED, message=await self._state_text(language))
            case Intent.SCHEDULES:
                text = schedule_text.listed(await self.journal.schedules(), language)
                return report_of(job, CommandState.ANSWERED, message=text)
            case Intent.CANCEL:
                key = "talk.cancel" if job.cancelled_earlier else "talk.cancel_nothing"
                return report_of(job, CommandState.ANSWERED, message=say(key, language, count=job.cancelled_earlier))
            case Intent.QUESTION:
                text = reply_text.disarmed(understood.question) or say("talk.question", language)
                return report_of(job, CommandState.ANSWERED, message=text)
            case Intent.ASK_BACK if assessment.verdict is not None:
                return report_of(job, CommandState.REFUSED, verdict=assessment.verdict)
            case Intent.ASK_BACK:
                problem = joint_command(job.command.text)
                hint = problem.example if isinstance(problem, JointProblem) else ""
                message = understood.question or say("agent.ask.default", language)
                return report_of(job, CommandState.ASKS_BACK, message=message, hint=hint)
            case Intent.STOP | Intent.HALT:
                return await self._stop(job)
        return report_of(job, CommandState.ANSWERED, message=say("agent.nothing", language))

    async def cancel_earlier(self, job: QueuedCommand) -> int:
        """End the earlier commands of its author that do not move; return how many."""
        before = self.queue.end_waiting(job, EndReason.TAKEN_BACK)
        await self.journal.end([other.command.key for other in before], EndReason.TAKEN_BACK)
        return len(before)

    async def _stop(self, job: QueuedCommand) -> Report:
        """Stop for words that only the mind understood as a stop."""
        command = job.command
        ended = self.queue.end_before(job, EndReason.STOP)
        for other in ended:
            other.stopped_by = command.author.name
        stop = await self.stops.stop(command.author.name, command.posted_at)
        await self.journal.end([other.command.key for other in ended], EndReason.STOP)
        return report_of(job, CommandState.STOPPED, stop=stop)

    async def _state_text(self, language: Language) -> str:
        try:
            state = await self.driver.state()
            more = await self.owner.of_state(state, language)
            return "\n\n".join([reply_text.state_text(state, len(self.queue) - 1, language), *more])
        except RobotError as e:
            return reply_text.state_text(None, len(self.queue) - 1, language, str(e))

    async def _schedule(self, job: QueuedCommand, assessment: Assessment) -> Report:
        """Keep a command for later times; nothing moves now. A restart finds the schedule that was kept."""
        command, plan, verdict = job.command, assessment.understanding.plan, assessment.verdict
        assert assessment.schedule is not None
        kept = await self.journal.schedule(command.post_id)
        if kept is None:
            if job.ended is None and (refused := refusal(job, assessment)) is not None:
                return refused
            if job.ended is None and (limited := await self.admission.admit(job)) is not None:
                return report_of(job, CommandState.REFUSED, plan, verdict=limited)
            mine = [k for k in await self.journal.schedules() if k.asked.command.author.id == command.author.id]
            if sum(other.ended is None for other in mine) >= MOST:
                reason = say("schedule.full", command.language, count=MOST)
                full = Verdict(Decision.REFUSE, "schedule.full", reason)
                return report_of(job, CommandState.REFUSED, plan, verdict=full)
            if job.ended is not None:
                return await self.outcomes.cancelled(job, plan)
            understood = reply_text.planned(plan, command.language, job.goal_text)
            asked = ScheduledCommand(command, assessment.schedule, assessment.untimed, understood)
            kept = await self.journal.add_schedule(asked, first_runs(assessment.schedule, 1)[0])
            self.schedules.changed()
        asks = verdict is not None and verdict.decision is Decision.NEEDS_APPROVAL
        text = schedule_text.scheduled(kept, command.language, needs_approval=asks)
        return report_of(job, CommandState.ANSWERED, message=text)

    async def _preview(self, job: QueuedCommand, assessment: Assessment) -> Report:
        """Rehearse a command; nothing moves. It is judged and rate-limited like one that would. A stop ends it."""
        command, plan = job.command, assessment.understanding.plan
        if (refused := refusal(job, assessment)) is not None:
            return refused
        if (limited := await self.admission.admit(job)) is not None:
            return report_of(job, CommandState.REFUSED, plan, verdict=limited)
        show(job, say("preview.running", command.language), CommandState.SEEN)
        job.preview = await self.previews.unless_ended(job, plan)
        if job.preview is None:
            return await self.outcomes.cancelled(job, plan)
        text = preview_text(job.preview, command.language)
        return report_of(job, CommandState.ANSWERED, Plan(notes=plan.notes), message=text)
