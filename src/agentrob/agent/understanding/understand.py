"""Assess a post before anything moves: the mind reads it, rules judge it, a model reviews it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

from pydantic import TypeAdapter

from agentrob.agent.intake.authorization import CommandTerms, chain_refusal, judge, rights_on
from agentrob.agent.queue.queue import QueuedCommand
from agentrob.agent.reporting.status_post import retry_until_answered
from agentrob.agent.store.journal import Journal
from agentrob.agent.understanding.extract import OVER, RATE, Assessment, by_rules, extract
from agentrob.agent.understanding.second_opinion import SecondOpinion
from agentrob.agent.understanding.visual_goal import replace_no_camera_answer, vision_model
from agentrob.config.robots import RobotConfig
from agentrob.eyes.protocol import Detector
from agentrob.forums.protocol import Forum
from agentrob.language.addressing import part_for
from agentrob.language.goal import Goal
from agentrob.language.joint.parts import JointCommand
from agentrob.language.joint.reading import JointProblem, joint_command
from agentrob.language.messages.catalog import join_sentences, quote, say
from agentrob.language.previews.reading import rehearsed_part, speaks_of_preview
from agentrob.language.registry import language_of
from agentrob.language.schedule.reading import TimedText, cancels_elsewhere, lists_schedules, timed_text
from agentrob.language.visible_text import mentions
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.extraction.summary import Summary, summarise
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.protocol import Addressee, Mind
from agentrob.minds.safety_review import SafetyReview, apply_review, review_command
from agentrob.minds.visual_loop.goal import goal_of
from agentrob.minds.visual_loop.pursuit import for_model, goal_for, in_words, judged_plan, without_model
from agentrob.model import (
    PHOTO,
    AccountKind,
    Capabilities,
    Command,
    CommandState,
    Decision,
    Intent,
    Plan,
    Primitive,
    Report,
    Understanding,
)
from agentrob.model.estimate import seconds_of
from agentrob.robots.driver.client import DriverClient
from agentrob.screening.rights import may
from agentrob.screening.screen import harm_in_words
from agentrob.screening.second_opinion import is_own_words, with_opinion

_ASSESSMENT = TypeAdapter(Assessment)


@dataclass(frozen=True)
class Assessor:
    """How one robot's agent thinks about any post."""

    names: Collection[str]
    settings: RobotConfig
    forum: Forum
    driver: DriverClient
    mind: Mind
    journal: Journal
    #: Whether a command that this account posts now is over its limits.
    over_limit: Callable[[Command], bool] = lambda _: False
    #: A classifier that may suspect harm in what the rules allow.
    opinion: SecondOpinion | None = None
    #: What finds things in the robot's pictures without a model.
    detector: Detector | None = None

    @property
    def model(self) -> ChatModel | None:
        """The model behind the mind, if there is one."""
        return self.mind.model if isinstance(self.mind, ModelMind) else None

    @property
    def vision_model(self) -> ChatModel | None:
        """The model that may steer the robot by its camera, if the owner allows one."""
        return vision_model(self.model, self.settings)

    async def think(self, job: QueuedCommand, terms: CommandTerms) -> Assessment:
        """Understand and judge a command once; a restart gets the same assessment. A command that is ended does not
        wait for the mind."""
        work = partial(self._think, job, terms)
        assessment = _ASSESSMENT.validate_json(await self.journal.assess(job.command.key, work))
        if assessment.understanding.intent is not Intent.NOTHING:
            job.command = replace(job.command, language=assessment.understanding.language)
        job.assessment = assessment
        return assessment

    async def summary(self, job: QueuedCommand, report: Report) -> Summary | None:
        """A model's summary of the measured results, if the owner wants one."""
        if not self.settings.summary or self.model is None or report.status is not CommandState.DONE:
            return None
        spent = (*(job.assessment.usage if job.assessment else ()), *(job.looked.usage if job.looked else ()))
        return await summarise(self.model, report.results, report.command.language, spent)

    async def _think(self, job: QueuedCommand, terms: CommandTerms) -> str:
        return _ASSESSMENT.dump_json(await self.consider(job, terms)).decode()

    async def consider(self, job: QueuedCommand, terms: CommandTerms) -> Assessment:
        """Understand and judge a command now, without storing the assessment. Nothing that speaks of a preview moves:
        it is one, or is asked about."""
        command = job.command
        if command.run is None and (joint := joint_command(command.text)) is not None:
            return await self._consider_part(job, joint, terms)
        part = part_for(command.text, tuple(self.names), self._others(command))
        rehearsed = rehearsed_part(part, command.text)
        if rehearsed is not None and command.run is None:
            return await self._considered_preview(job, part, rehearsed, terms)
        assessment = await self._considered_command(job, part, terms)
        if assessment.understanding.intent is Intent.COMMAND and speaks_of_preview(part, command.text):
            return _asks(assessment, "preview.unclear")
        return assessment

    async def _considered_preview(self, job: QueuedCommand, part: str, rest: str, terms: CommandTerms) -> Assessment:
        """The assessment of a post that asks to preview `rest`."""
        command = job.command
        timed = timed_text(rest, command.posted_at, self.settings.time_zone) if rest else None
        alone = replace(command, text=f"@{next(iter(self.names))} {rest or part}")
        assessment = await self._consider(job, alone, terms)
        job.takes_s = None  # it takes no time of the robot
        if timed is not None and timed.schedule is not None:
            return _asks(assessment, "preview.later")
        if not rest or assessment.understanding.intent is Intent.NOTHING:
            return _asks(assessment, "preview.what")
        if assessment.goal is not None:
            return _asks(assessment, "preview.goal")
        return replace(assessment, previews=assessment.understanding.intent is Intent.COMMAND)

    async def _considered_command(self, job: QueuedCommand, part: str, terms: CommandTerms) -> Assessment:
        """The assessment of a post that asks for no preview. One that says when is understood and judged without the
        time."""
        command = job.command
        if command.run is not None:
            return await self._consider(job, command, terms, alone=True)
        if lists_schedules(part) or cancels_elsewhere(part):
            return Assessment(Understanding(Intent.SCHEDULES, command.language), "rules")
        timed = timed_text(part, command.posted_at, self.settings.time_zone)
        if timed is None or (
            timed.schedule is None and not timed.surely_later and await self._is_command_of_now(command)
        ):
            return await self._consider(job, command, terms)
        if timed.schedule is not None and command.text.count(part) == 1:
            untimed = replace(command, text=command.text.replace(part, timed.rest))
            assessment = await self._consider(job, untimed, terms, alone=True)
            if assessment.understanding.intent is Intent.COMMAND:
                return replace(assessment, schedule=timed.schedule, untimed=untimed.text)
            if assessment.understanding.intent is Intent.ASK_BACK:
                return assessment
        assessment = await self._consider(job, command, terms)
        return _asks_when(assessment, timed)

    async def _consider_part(
        self, job: QueuedCommand, joint: JointCommand | JointProblem, terms: CommandTerms
    ) -> Assessment:
        """Judge this robot's part of a post to several robots. It is read by the rules, whatever the mind, as the
        agents of the other robots read it; if any part is not understood, all of them ask."""
        command, language = job.command, joint.language
        question = joint.question if isinstance(joint, JointProblem) else await self._not_joint(command, joint)
        if question or isinstance(joint, JointProblem):
            asked = Understanding(Intent.ASK_BACK, language, question=question)
            return Assessment(asked, "rules", harm_in_words(command.text, terms.scene, language))
        capabilities = await self.driver.capabilities()
        understood = Understanding(Intent.COMMAND, language, joint.part(command.part).plan)
        return await self._judged(job, Assessment(understood, "rules"), command, capabilities, (), terms)

    async def _not_joint(self, command: Command, joint: JointCommand) -> str:
        """Why no agent carries out its part of a post that was read, as a question; empty if they do."""
        if not command.part:  # it was called by another name, which the other agents do not know
            return say("joint.alias", joint.language, name=quote(command.robot))
        for name in joint.robots:
            account = await retry_until_answered(partial(self.forum.account, name))
            if account is None or account.kind is not AccountKind.ROBOT_AGENT:
                return say("joint.robot", joint.language, name=quote(name))
        return ""

    def _others(self, command: Command) -> tuple[str, ...]:
        return tuple(name for name in mentions(command.text) if name not in self.names)

    async def _is_command_of_now(self, command: Command) -> bool:
        """Whether the rules understand every word, and so take what says when for a remark: "happy friday, wave"."""
        capabilities = await self.driver.capabilities()
        addressee = Addressee(tuple(self.names), self._others(command), capabilities, self.settings.step_length_m)
        history = await self.journal.history(command.topic_id)
        return (await by_rules(command.text, addressee, history)).understanding.intent is Intent.COMMAND

    async def _consider(
        self, job: QueuedCommand, command: Command, terms: CommandTerms, *, alone: bool = False
    ) -> Assessment:
        """Understand and judge a text. `alone`: without what was done before in the thread, which "again" would repeat:
        when a schedule runs that may be something else."""
        capabilities = await self.driver.capabilities()
        addressee = Addressee(tuple(self.names), self._others(command), capabilities, self.settings.step_length_m)
        history = () if alone else await self.journal.history(command.topic_id)
        assessment = await self._goal(command, addressee, history)
        allowed = may(command.author, "command", simulated=capabilities.simulated).decision is Decision.ALLOW
        if assessment is None and not allowed:
            assessment = await by_rules(command.text, addressee, history)  # whose words move nothing cost nothing
        if assessment is None and self.over_limit(command):  # nor do those whose command is refused, whoever reads it
            assessment = await by_rules(command.text, addressee, history, RATE)
        if assessment is None:
            reading = extract(self.mind, command.text, addressee, history)
            assessment = await job.unless_ended(reading) or await by_rules(command.text, addressee, history, OVER)
        if self.vision_model is not None:
            assessment = replace(assessment, understanding=replace_no_camera_answer(assessment.understanding))
        if assessment.understanding.looks:
            photographed = await self._photographed(assessment.understanding, command, capabilities, terms)
            assessment = replace(assessment, understanding=photographed)
        understood = assessment.understanding
        if understood.intent is Intent.COMMAND:
            return await self._judged(job, assessment, command, capabilities, history, terms)
        if understood.intent is Intent.ASK_BACK:  # harm is named also where the rest is not understood
            assessment = replace(assessment, verdict=harm_in_words(command.text, terms.scene, understood.language))
        return assessment

    async def _judged(
        self,
        job: QueuedCommand,
        assessment: Assessment,
        command: Command,
        capabilities: Capabilities,
        history: Sequence[Plan],
        terms: CommandTerms,
    ) -> Assessment:
        """Judge a command that was understood: by rights, limits and rules, and by what looks at it besides."""
        command = replace(command, language=assessment.understanding.language)
        addressee = Addressee(tuple(self.names), self._others(command), capabilities, self.settings.step_length_m)
        chained = await retry_until_answered(partial(chain_refusal, self.forum, command))
        goal = assessment.goal
        plan = judged_plan(goal, local=not self.by_model(goal, capabilities)) if goal else assessment.understanding.plan
        job.takes_s = None if assessment.goal else seconds_of(plan, capabilities)
        rights = await retry_until_answered(partial(rights_on, self.forum, command, terms))
        known = replace(terms, known=assessment.goal is not None)
        verdict = chained or judge(command, plan, command.author, capabilities, known, rights)
        assessment = replace(assessment, verdict=verdict)
        assessment = await self._with_opinion(
            job, assessment, part_for(command.text, addressee.names, addressee.others)
        )
        assessment = await self._looked_at(job, command.text, assessment, addressee, capabilities, history, terms.scene)
        return assessment

    async def _photographed(
        self, understood: Understanding, command: Command, capabilities: Capabilities, terms: CommandTerms
    ) -> Understanding:
        """Answer "what do you see?" with a photo, where this account may have one now without an approval."""
        plan = Plan((Primitive(PHOTO),), (say("note.see", understood.language),))
        rights = await retry_until_answered(partial(rights_on, self.forum, command, terms))
        verdict = judge(command, plan, command.author, capabilities, terms, rights)
        if self.over_limit(command) or (verdict is not None and verdict.decision is not Decision.ALLOW):
            return understood
        return replace(understood, intent=Intent.COMMAND, plan=plan, looks=False)

    def by_model(self, goal: Goal, capabilities: Capabilities) -> bool:
        """Whether a model pursues the goal, as the owner allows, and not the robot's detector and odometry."""
        return self.vision_model is not None and for_model(goal, capabilities)

    async def _goal(self, command: Command, addressee: Addressee, history: Sequence[Plan]) -> Assessment | None:
        """The assessment of a post that is a goal which this robot can pursue; else None."""
        language, capabilities = language_of(command.text), addressee.capabilities
        goal = goal_of(command.text, addressee, language)  # None for most posts, which the rules read later
        if goal is None or not (self.by_model(goal, capabilities) or without_model(goal, capabilities, self.detector)):
            return None
        assessment = await by_rules(command.text, addressee, history)
        understood = assessment.understanding
        if (goal := goal_for(command.text, addressee, understood)) is None:
            return None
        return replace(
            assessment, goal=goal, understanding=Understanding(Intent.COMMAND, understood.language, Plan(goal.steps))
        )

    async def _with_opinion(self, job: QueuedCommand, assessment: Assessment, text: str) -> Assessment:
        """Ask back if the rules allow a command and the classifier suspects harm in its words."""
        verdict, language = assessment.verdict, assessment.understanding.language
        if self.opinion is None or verdict is None or verdict.decision is not Decision.ALLOW:
            return assessment
        plan = None if assessment.goal else assessment.understanding.plan
        if plan is not None and is_own_words(text, plan, language):
            return assessment
        suspected = await job.unless_ended(self.opinion.suspects(text, language))
        return replace(assessment, verdict=with_opinion(verdict, suspected, plan, language))

    async def _looked_at(
        self,
        job: QueuedCommand,
        text: str,
        assessment: Assessment,
        addressee: Addressee,
        capabilities: Capabilities,
        history: Sequence[Plan],
        scene: str,
    ) -> Assessment:
        """Add a model's objection to a command that the rules allow, or would allow with an approval."""
        verdict, settings = assessment.verdict, self.settings
        passed = verdict is not None and verdict.decision in (Decision.ALLOW, Decision.NEEDS_APPROVAL)
        if verdict is None or not passed or settings.screen == "rules":
            return assessment
        screened: SafetyReview | None = None
        plan, language = assessment.understanding.plan, assessment.understanding.language
        if self.model is None:
            pass  # nobody was to look at it
        elif (
            assessment.mind == "rules" and assessment.fallback
        ):  # nobody answered a moment ago, or nobody was waited for
            screened = SafetyReview(self.mind.name, failed=assessment.fallback) if assessment.fallback != OVER else None
        else:
            part = part_for(text, addressee.names, addressee.others)
            goal = in_words(assessment.goal, "en") if assessment.goal else ""
            looking = review_command(
                self.model, part, plan, capabilities, language, history, scene, spent=assessment.usage, goal=goal
            )
            screened = await job.unless_ended(looking)
        usage = (*assessment.usage, *(screened.usage if screened else ()))
        verdict = apply_review(verdict, screened, language, settings.screen == "required")
        return replace(assessment, verdict=verdict, usage=usage, screened=screened)


def _asks(assessment: Assessment, key: str) -> Assessment:
    """The assessment of a post that is asked about instead of being done."""
    language = assessment.understanding.language
    question = join_sentences([say(key, language), say("preview.still", language)], language)
    asked = Understanding(Intent.ASK_BACK, language, question=question)
    return replace(assessment, understanding=asked, verdict=None, goal=None, schedule=None)


def _asks_when(assessment: Assessment, timed: TimedText) -> Assessment:
    """Ask about the time of a command that says when, and is not carried out at once instead."""
    understood = assessment.understanding
    if understood.intent not in (Intent.COMMAND, Intent.ASK_BACK):
        return assessment
    question = (
        timed.question
        or f"{say('schedule.unclear', understood.language)} {say('schedule.examples', understood.language)}"
    )
    verdict = assessment.verdict if understood.intent is Intent.ASK_BACK else None
    asked = Understanding(Intent.ASK_BACK, understood.language, question=question)
    return replace(assessment, understanding=asked, verdict=verdict)
