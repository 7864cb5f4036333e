"""What a robot is to reach or to tell by looking, in a closed vocabulary: nothing of it was written by anybody else."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from agentrob.model import Primitive


class Aim(StrEnum):
    """What only a robot with eyes can do, and `step`: what any robot can."""

    APPROACH = "approach"
    FACE = "face"
    FIND = "find"
    LOOK = "look"
    STEP = "step"


@dataclass(frozen=True, slots=True)
class Subgoal:
    """One part of a goal, in words of a closed vocabulary: nothing here was written by anybody else.

    `thing` and `colour` are English words of `agentrob.minds.visual_loop.vocabulary`, `where` is a relation to the
    thing (beside, behind, …) or `around`; a `look` without a thing is at whatever is there. `step` is what a `step`
    does.
    """

    aim: Aim
    thing: str = ""
    colour: str = ""
    where: str = ""
    step: Primitive | None = None


@dataclass(frozen=True, slots=True)
class Goal:
    """What is to be reached or told by looking; which steps that takes is found out on the way."""

    tasks: tuple[Subgoal, ...]

    @property
    def steps(self) -> tuple[Primitive, ...]:
        """The steps that were named besides."""
        return tuple(task.step for task in self.tasks if task.step is not None)
