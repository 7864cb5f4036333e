"""Decide whether a post is a goal, who pursues it, what it may cost, and how it is judged (laws 7 and 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from agentrob.agent.execution.local_goal import LocalTask
from agentrob.agent.execution.visual import VisualTask
from agentrob.config.robots import LookConfig, RobotConfig
from agentrob.eyes.protocol import Detector
from agentrob.eyes.sight import FOV_DEG, FOV_OF_MODEL_DEG
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.language.messages.catalog import say
from agentrob.language.messages.plan_text import step_sentence
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.llm.fallback import FallbackModel
from agentrob.minds.llm.prompt import loop_prompt
from agentrob.minds.protocol import Addressee
from agentrob.minds.usage import Usage
from agentrob.minds.visual_loop.goal import goal_of, goal_sentence
from agentrob.minds.visual_loop.loop import LoopBudget
from agentrob.model import Capabilities, Direction, Intent, Language, Mandate, Op, Plan, Primitive, Understanding
from agentrob.screening.mandate import goal_mandate

#: Aims that a model pursues, and those that are pursued without one.
_OF_MODEL = frozenset({Aim.APPROACH, Aim.FACE, Aim.FIND, Aim.LOOK, Aim.STEP})
_OF_DETECTOR = frozenset({Aim.FACE, Aim.FIND, Aim.SEE, Aim.COLOURS})
#: The most pictures of a goal without a model, and the most degrees that it turns.
LOCAL_PICTURES, LOCAL_DEG = 16, 1080.0
#: Steps of the kinds that an aim needs, by which it is judged before its own are known.
_TURN = Primitive(Op.TURN, Direction.LEFT, degrees=45.0)
_WALK = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5)
_PICTURE = Primitive(Op.GET_FRONT_IMAGE)
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
    if by_rules.intent not in _MAY_BE or by_rules.cancels:
        return None
    goal = goal_of(text, addressee, by_rules.language)
    if goal is None or (by_rules.intent is Intent.COMMAND and by_rules.plan.steps != goal.steps):
        return None
    return goal


def for_model(goal: Goal, capabilities: Capabilities) -> bool:
    """Whether a model with images could pursue the goal with this robot."""
    return goal.aims <= _OF_MODEL and Op.GET_FRONT_IMAGE in capabilities.ops


def without_model(goal: Goal, capabilities: Capabilities, detector: Detector | None) -> bool:
    """Whether this robot can pursue the goal without a model: go home, and look for what its detector knows."""
    if not goal.aims <= _OF_DETECTOR | {Aim.HOME, Aim.STEP}:
        return False
    looks = [task for task in goal.tasks if task.aim in _OF_DETECTOR]
    known = detector is not None and all(_knows(detector, task) for task in looks)
    return (known or not looks) and all(step.op in capabilities.ops for step in judged_plan(goal, local=True).steps)


def _knows(detector: Detector, task: Subgoal) -> bool:
    return (not task.thing or task.thing in detector.things) and (not task.colour or task.colour in detector.colours)


def replace_no_camera_answer(understood: Understanding) -> Understanding:
    """Replace the rules' answer "I have no camera" for a robot that has one."""
    if understood.intent is not Intent.ASK_BACK or not any(w in understood.question for w in _NO_EYES):
        return understood
    return replace(understood, question=say("visual.ask", understood.language))


def judged_plan(goal: Goal, *, local: bool = False) -> Plan:
    """What of a goal can be judged before it is pursued: the steps that it names, at least a picture; of one that is
    pursued without a model (`local`), also steps of every kind that it needs."""
    if not local:
        return Plan(goal.steps or (_PICTURE,))
    needed = [step for task in goal.tasks for step in _needed(task)]
    return Plan((*goal.steps, *dict.fromkeys(needed)))


def _needed(task: Subgoal) -> tuple[Primitive, ...]:
    match task.aim:
        case Aim.HOME:
            return (_TURN, _WALK)
        case Aim.FACE | Aim.FIND:
            return (_PICTURE, _TURN)
        case Aim.STEP:
            return ()
    return (_PICTURE,)


def local_task_of(
    goal: Goal, detector: Detector | None, capabilities: Capabilities, fov_deg: float | None
) -> LocalTask:
    """Return all that is needed to pursue a goal without a model, within the limits of one command."""
    limits = capabilities.limits
    most = Mandate(
        {Op.GET_FRONT_IMAGE: LOCAL_PICTURES}, limits.command_m, LOCAL_DEG, limits.command_s,
        limits.command_steps + LOCAL_PICTURES,
    )  # fmt: skip
    fov_deg = fov_deg or FOV_OF_MODEL_DEG.get(capabilities.model, FOV_DEG)
    mandate = replace(goal_mandate(goal, most, capabilities), speed_mps=None)  # as in a plan, the robot's own limit
    return LocalTask(goal, mandate, capabilities, detector, fov_deg)


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
