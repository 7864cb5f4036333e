"""Goals whose steps are decided on the way, in a closed vocabulary: no part of a goal is text that somebody wrote."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from agentrob.model import Primitive


class Aim(StrEnum):
    """The kind of a part of a goal. All but `home` and `step` need a camera; `see` asks whether and where something
    is in view, `colours` what colours are."""

    APPROACH = "approach"
    FACE = "face"
    FIND = "find"
    LOOK = "look"
    SEE = "see"
    COLOURS = "colours"
    HOME = "home"
    STEP = "step"


@dataclass(frozen=True, slots=True)
class Subgoal:
    """One part of a goal, in words of a closed vocabulary.

    `thing` and `colour` are English words of `agentrob.minds.visual_loop.vocabulary`. `where` is a relation to the
    thing (beside, behind, …) or `around`. A `look` without a thing describes whatever is visible. `step` is set for the
    aim `step`.
    """

    aim: Aim
    thing: str = ""
    colour: str = ""
    where: str = ""
    step: Primitive | None = None


@dataclass(frozen=True, slots=True)
class Goal:
    """A goal to reach or describe; the steps towards it are decided on the way."""

    tasks: tuple[Subgoal, ...]

    @property
    def aims(self) -> frozenset[Aim]:
        return frozenset(task.aim for task in self.tasks)

    @property
    def steps(self) -> tuple[Primitive, ...]:
        """The steps that the goal names explicitly."""
        return tuple(task.step for task in self.tasks if task.step is not None)
