"""A joint command: its parts, which robot does each of them, and which parts each waits for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from graphlib import CycleError, TopologicalSorter

from agentrob.model import Capabilities, Language, Op, Plan
from agentrob.model.estimate import seconds_of

#: How many parts a joint command has, and how many of them may follow one another.
LEAST_PARTS, MOST_PARTS, MOST_DEEP = 2, 5, 3
#: A part may take this many times its estimate and this many seconds more, before parts that wait for it give up.
TIMES_ESTIMATE, MORE_S = 2.0, 60.0
#: Estimates are the same for all robots, so that every agent computes the same times.
_ANY_ROBOT = Capabilities("", frozenset(Op))


class Choice(StrEnum):
    """Who does a part: the robot that is named, or one of several."""

    NAMED = "named"
    ANY = "any"  # one of you
    NEAREST = "nearest"  # whoever is nearer
    FREE = "free"  # whoever is free


@dataclass(frozen=True, slots=True)
class JointWords:
    """Regular expressions of one language, in lower case. `R` stands for one robot, as in `when R is done`.

    `then` puts a part after those before it, `ended_it`, `ended_all` and `ended_robot` are conditions to wait for, and
    `meanwhile` begins a part with the one before it. `any_of`, `nearest` and `free` address one of several robots;
    `near` finds the group `place` in what `nearest` has matched: nearer to what. `either` stands between robots of
    which one is meant, `leads` between these words and a robot, `linking` between a robot and what it does. `first`
    ends the part that is done first, `greets` is what may stand before everything.
    """

    then: str = "(?!)"
    ended_it: str = "(?!)"
    ended_all: str = "(?!)"
    ended_robot: str = "(?!)"
    meanwhile: str = "(?!)"
    any_of: str = "(?!)"
    nearest: str = "(?!)"
    near: str = "(?!)"
    free: str = "(?!)"
    either: str = "(?!)"
    leads: str = "(?!)"
    linking: str = "(?!)"
    first: str = "(?!)"
    greets: str = "(?!)"


@dataclass(frozen=True, slots=True)
class JointPart:
    """One part: what one robot does, once the parts `after` are done. `number` counts from 1.

    `robots` are handles: one, or those of which one is chosen. `text` is the part in the words of the post. `near` is
    to what the nearest robot is meant, in the words of the post; empty if that is not said.
    """

    number: int
    robots: tuple[str, ...]
    plan: Plan
    text: str
    after: tuple[int, ...] = ()
    choice: Choice = Choice.NAMED
    near: str = ""

    @property
    def seconds(self) -> float:
        """How long it may take, in seconds, before those that wait for it give up."""
        return TIMES_ESTIMATE * seconds_of(self.plan, _ANY_ROBOT) + MORE_S


@dataclass(frozen=True, slots=True)
class JointCommand:
    """The parts of a post, in the order of the text. All agents that read the post read the same."""

    parts: tuple[JointPart, ...]
    language: Language

    @property
    def robots(self) -> tuple[str, ...]:
        """The handles of all robots, in the order of the text."""
        return tuple(dict.fromkeys(name for part in self.parts for name in part.robots))

    @property
    def first(self) -> str:
        """The robot that is named first; its agent sums up."""
        return self.parts[0].robots[0]

    def part(self, number: int) -> JointPart:
        return self.parts[number - 1]

    def of(self, robot: str) -> tuple[JointPart, ...]:
        """The parts that this robot does, or may be chosen to do."""
        return tuple(part for part in self.parts if robot in part.robots)

    def seconds_before(self, number: int) -> float:
        """How long after the post this part still waits for others, in seconds."""
        after = self.part(number).after
        return max((self.seconds_until(other) for other in after), default=0.0)

    def seconds_until(self, number: int) -> float:
        """How long after the post this part may end, in seconds."""
        return self.seconds_before(number) + self.part(number).seconds

    @property
    def seconds(self) -> float:
        """How long after the post all parts may end, in seconds."""
        return max(self.seconds_until(part.number) for part in self.parts)


def cycle_of(parts: Sequence[JointPart]) -> tuple[JointPart, ...]:
    """The parts that wait for each other in a circle; empty if there are none."""
    try:
        TopologicalSorter({part.number: part.after for part in parts}).prepare()
    except CycleError as e:
        return tuple(parts[number - 1] for number in dict.fromkeys(e.args[1]))
    return ()


def depth_of(parts: Sequence[JointPart]) -> int:
    """How many parts follow one another at most; the parts must have no cycle."""
    deep: dict[int, int] = {}
    for number in TopologicalSorter({part.number: part.after for part in parts}).static_order():
        deep[number] = 1 + max((deep[before] for before in parts[number - 1].after), default=0)
    return max(deep.values(), default=0)


def ordered(parts: Sequence[JointPart], earlier: int, later: int) -> bool:
    """Whether the part `later` waits for the part `earlier`, directly or through others."""
    ahead, seen = list(parts[later - 1].after), set[int]()
    while ahead:
        number = ahead.pop()
        if number == earlier:
            return True
        if number not in seen:
            seen.add(number)
            ahead += parts[number - 1].after
    return False
