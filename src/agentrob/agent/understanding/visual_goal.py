"""Decide whether a post is a visual goal, what it may cost, and how it is judged (laws 7 and 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from agentrob.agent.execution.visual import VisualTask
from agentrob.config.robots import LookConfig, RobotConfig
from agentrob.language.goal import Goal
from agentrob.language.messages.catalog import say
from agentrob.language.messages.plan_text import step_sentence
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.llm.fallback import FallbackModel
from agentrob.minds.llm.prompt import loop_prompt
from agentrob.minds.protocol import Addressee
from agentrob.minds.usage import Usage
from agentrob.minds.visual_loop.goal import goal_of, goal_sentence
from agentrob.minds.visual_loop.loop import LoopBudget
from agentrob.model import Capabilities, Intent, Language, Mandate, Op, Plan, Primitive, Understanding
from agentrob.screening.mandate import goal_mandate

#: How the rules say that something needs eyes.
_NO_EYES = ("vision model", "视觉模型")
#: What a post may be for the rules and still be a goal for eyes.
_MAY_BE = (Intent.COMMAND, Intent.ASK_BACK, Intent.NOTHING, Intent.QUESTION)


def vision_model(model: ChatModel | None, settings: RobotConfig) -> ChatModel | None:
    """The model that may steer this robot by its camera; None without the owner's consent, or without such a model."""
    if not settings.look.allowed or not isinstance(model, FallbackModel):
        return None
    return model.with_images()


def goal_for(text: str, addressee: Addressee, by_rules: Understanding) -> Goal | None:
    """The goal of a post, as far as the rules read nothing else in it."""
    if by_rules.intent not in _MAY_BE or by_rules.cancels or Op.GET_FRONT_IMAGE not in addressee.capabilities.ops:
        return None
    goal = goal_of(text, addressee, by_rules.language)
    if goal is None or (by_rules.intent is Intent.COMMAND and by_rules.plan.steps != goal.steps):
        return None
    return goal


def replace_no_camera_answer(understood: Understanding) -> Understanding:
    """Replace the rules' answer "I have no camera" for a robot that has one."""
    if understood.intent is not Intent.ASK_BACK or not any(w in understood.question for w in _NO_EYES):
        return understood
    return replace(understood, question=say("visual.ask", understood.language))


def judged_plan(goal: Goal) -> Plan:
    """What of a goal can be judged before it is looked for: the steps that it names, at least a picture."""
    return Plan(goal.steps or (Primitive(Op.GET_FRONT_IMAGE),))


def in_words(goal: Goal, language: Language) -> str:
    """The goal with its named steps, in our own words."""
    return goal_sentence(goal, language, [step_sentence(step, language) for step in goal.steps])


def visual_task_of(
    goal: Goal, vision_model: ChatModel, capabilities: Capabilities, look: LookConfig, language: Language,
    spent: Sequence[Usage] = (),
) -> VisualTask:  # fmt: skip
    """Return all that a visual loop needs.

    The model gets the goal in English, and answers in the language of the post.
    """
    most = Mandate(
        {Op.GET_FRONT_IMAGE: look.pictures}, look.distance_m, look.degrees, look.seconds, look.calls + look.pictures,
        look.speed_mps,
    )  # fmt: skip
    mandate = goal_mandate(goal, most, capabilities)
    budget = LoopBudget(look.calls, look.seconds)
    prompt = loop_prompt(capabilities.model, language)
    return VisualTask(goal, in_words(goal, "en"), prompt, vision_model, mandate, capabilities, budget, tuple(spent))
