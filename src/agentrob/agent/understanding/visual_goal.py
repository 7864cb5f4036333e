"""Decide whether a post is a goal, who pursues it, what it may cost, and how it is judged (laws 7 and 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from agentrob.agent.execution.local_goal import LocalTask
from agentrob.agent.execution.visual import VisualTask
from agentrob.config.robots import LookConfig, RobotConfig
from agentrob.eyes.protocol import Detector
from agentrob.eyes.sight import FOV_DEG, FOV_OF_MODEL_DEG
from agentrob.language.goal import Goal
from agentrob.language.messages.catalog import say
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.llm.fallback import FallbackModel
from agentrob.minds.llm.prompt import loop_prompt
from agentrob.minds.usage import Usage
from agentrob.minds.visual_loop.loop import LoopBudget
from agentrob.minds.visual_loop.pursuit import in_words
from agentrob.model import PHOTO, Capabilities, Intent, Language, Mandate, Understanding
from agentrob.screening.mandate import goal_mandate

#: The most pictures of a goal without a model, and the most degrees that it turns.
LOCAL_PICTURES, LOCAL_DEG = 16, 1080.0
#: How the rules say that something needs eyes.
_NO_EYES = ("vision model", "视觉模型")


def vision_model(model: ChatModel | None, settings: RobotConfig) -> ChatModel | None:
    """The model that may steer this robot by its camera; None without the owner's consent, or without such a model."""
    if not settings.look.allowed or not isinstance(model, FallbackModel):
        return None
    return model.with_images()


def replace_no_camera_answer(understood: Understanding) -> Understanding:
    """Replace the rules' answer "I have no camera" for a robot that has one."""
    if understood.intent is not Intent.ASK_BACK or not any(w in understood.question for w in _NO_EYES):
        return understood
    return replace(understood, question=say("visual.ask", understood.language))


def local_task_of(
    goal: Goal, detector: Detector | None, capabilities: Capabilities, fov_deg: float | None
) -> LocalTask:
    """Return all that is needed to pursue a goal without a model, within the limits of one command."""
    limits = capabilities.limits
    most = Mandate(
        {PHOTO: LOCAL_PICTURES}, limits.command_m, LOCAL_DEG, limits.command_s,
        limits.command_steps + LOCAL_PICTURES,
    )  # fmt: skip
    fov_deg = fov_deg or FOV_OF_MODEL_DEG.get(capabilities.model, FOV_DEG)
    mandate = replace(goal_mandate(goal, most, capabilities), speed_mps=None)  # as in a plan, the robot's own limit
    return LocalTask(goal, mandate, capabilities, detector, fov_deg)


def visual_task_of(
    goal: Goal, vision_model: ChatModel, capabilities: Capabilities, look: LookConfig, language: Language,
    spent: Sequence[Usage] = (),
) -> VisualTask:  # fmt: skip
    """Return all that a visual loop needs.

    The model gets the goal in English, and answers in the language of the post.
    """
    most = Mandate(
        {PHOTO: look.pictures}, look.distance_m, look.degrees, look.seconds, look.calls + look.pictures,
        look.speed_mps,
    )  # fmt: skip
    mandate = goal_mandate(goal, most, capabilities)
    budget = LoopBudget(look.calls, look.seconds)
    prompt = loop_prompt(capabilities.model, language)
    return VisualTask(goal, in_words(goal, "en"), prompt, vision_model, mandate, capabilities, budget, tuple(spent))
