"""Which goals can be pursued with a model or without one, and by which steps each is judged beforehand. Pure."""

from __future__ import annotations

from collections.abc import Collection
from typing import Protocol

from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.language.messages.plan_text import step_sentence
from agentrob.minds.protocol import Addressee
from agentrob.minds.visual_loop.goal import goal_of, goal_sentence
from agentrob.model import PHOTO, Capabilities, Direction, Intent, Language, Plan, Primitive, Understanding, turn, walk


class Known(Protocol):
    """The things that a detector can tell apart, as English words."""

    @property
    def things(self) -> Collection[str]: ...

    @property
    def colours(self) -> Collection[str]: ...


#: Aims that a model pursues, and those that are pursued without one.
_OF_MODEL = frozenset({Aim.APPROACH, Aim.FACE, Aim.FIND, Aim.LOOK, Aim.STEP})
_OF_DETECTOR = frozenset({Aim.FACE, Aim.FIND, Aim.SEE, Aim.COLOURS})
#: Steps of the kinds that an aim needs, by which it is judged before its own are known.
_TURN = turn(Direction.LEFT, 45.0)
_WALK = walk(Direction.FORWARD, 0.5)
_PICTURE = Primitive(PHOTO)
#: What a post may be for the rules and still be a goal for eyes.
_MAY_BE = (Intent.COMMAND, Intent.ASK_BACK, Intent.NOTHING, Intent.QUESTION)


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
    return goal.aims <= _OF_MODEL and PHOTO in capabilities.ops


def without_model(goal: Goal, capabilities: Capabilities, detector: Known | None) -> bool:
    """Whether this robot can pursue the goal without a model: go home, and look for what its detector knows."""
    if not goal.aims <= _OF_DETECTOR | {Aim.HOME, Aim.STEP}:
        return False
    looks = [task for task in goal.tasks if task.aim in _OF_DETECTOR]
    known = detector is not None and all(_knows(detector, task) for task in looks)
    return (known or not looks) and all(step.op in capabilities.ops for step in judged_plan(goal, local=True).steps)


def _knows(detector: Known, task: Subgoal) -> bool:
    return (not task.thing or task.thing in detector.things) and (not task.colour or task.colour in detector.colours)


def judged_plan(goal: Goal, *, local: bool = False) -> Plan:
    """The part of a goal that can be judged before the robot pursues it: the steps that it names, at least a picture. A
    goal that is pursued without a model (`local`) also has a step of every kind that it needs."""
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


def in_words(goal: Goal, language: Language) -> str:
    """The goal with its named steps, in our own words."""
    return goal_sentence(goal, language, [step_sentence(step, language) for step in goal.steps])
