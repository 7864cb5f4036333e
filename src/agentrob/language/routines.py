"""Routines: dances, figures and patrols as plans of ordinary steps within a robot's limits. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from enum import StrEnum
from functools import lru_cache

from agentrob.model import ActionClass, BaseMotion, Capabilities, Direction, Plan, Primitive, turn, walk
from agentrob.model.estimate import seconds_of


class Routine(StrEnum):
    """A motion that is requested by one name and done in several steps. The size of a square and of a patrol is a side,
    that of a circle its diameter, or its radius if that was said."""

    DANCE = "dance"
    SQUARE = "square"
    CIRCLE = "circle"
    CIRCLE_RADIUS = "circle_radius"
    PATROL = "patrol"

    @property
    def has_size(self) -> bool:
        return self is not Routine.DANCE


#: Sizes in metres where none is said.
_USUAL_M = {Routine.SQUARE: 0.5, Routine.CIRCLE: 0.8, Routine.CIRCLE_RADIUS: 0.4, Routine.PATROL: 1.0}
#: Sizes are offered in these steps, from the smallest; larger ones than the largest are never tried.
SIZE_STEP_M, MOST_SIZE_M = 0.1, 20.0
#: A circle is walked as a polygon of so many sides, as many as the limits allow.
FEWEST_SIDES, MOST_SIDES = 4, 12
#: How far a dancing robot turns to each side, and its gestures, of which the first that fit are done.
SWAY_DEG = 30.0
_MOST_GESTURES = 2
_MOST_TIMES = 20


def steps_of(routine: Routine, can: Capabilities, size_m: float | None = None, times: int = 1) -> list[Primitive]:
    """Return the steps of a routine, done `times` times; empty if it does not fit the limits of one command."""
    size = _USUAL_M.get(routine, 0.0) if size_m is None else size_m
    for once in _ways(routine, can, size):
        if fits(steps := once * times, can):
            return steps
    return []


def usual_size_m(routine: Routine, can: Capabilities, times: int = 1) -> float | None:
    """Return the size of a routine for which none was said: the usual one, or the largest that fits."""
    if not routine.has_size:
        return None
    usual = _USUAL_M[routine]
    return usual if steps_of(routine, can, usual, times) else min(usual, largest_size_m(routine, can, times)) or usual


@lru_cache(maxsize=256)
def largest_size_m(routine: Routine, can: Capabilities, times: int = 1) -> float:
    """Return the largest size that fits the limits of one command, 0 if none does."""
    most = round(min(MOST_SIZE_M, can.limits.command_m) / SIZE_STEP_M)
    sizes = (n * SIZE_STEP_M for n in range(most, 0, -1))
    return next((round(size, 1) for size in sizes if steps_of(routine, can, size, times)), 0.0)


@lru_cache(maxsize=256)
def most_times(routine: Routine, can: Capabilities, size_m: float | None = None) -> int:
    """Return how often a routine of this size can be done in one command, 0 if not even once."""
    return next((n for n in range(_MOST_TIMES, 0, -1) if steps_of(routine, can, size_m, n)), 0)


def fits(steps: Sequence[Primitive], can: Capabilities) -> bool:
    """Return whether a robot can do these steps in one command."""
    limits, plan = can.limits, Plan(tuple(steps))
    possible = all(can.can_do(step) for step in steps)
    short = all((s.distance_m or 0.0) <= limits.step_m and (s.degrees or 0.0) <= limits.step_deg for s in steps)
    whole = len(steps) <= limits.command_steps and plan.distance_m <= limits.command_m
    return bool(steps) and possible and short and whole and math.ceil(seconds_of(plan, can)) <= limits.command_s


def sides_of(steps: Sequence[Primitive]) -> tuple[int, float]:
    """Return the number of walks of a routine and the length of the first, in metres."""
    walks = [step.distance_m or 0.0 for step in steps if step.translates]
    return len(walks), walks[0] if walks else 0.0


def _ways(routine: Routine, can: Capabilities, size_m: float) -> Iterator[list[Primitive]]:
    """Yield the ways to do a routine once, the best first."""
    if routine is Routine.DANCE:
        yield from _dances(can)
    elif routine is Routine.PATROL:
        yield _polygon(2, size_m)
    elif routine is Routine.SQUARE:
        yield _polygon(4, size_m)
    else:
        across_m = size_m * (2 if routine is Routine.CIRCLE_RADIUS else 1)
        for sides in range(MOST_SIDES, FEWEST_SIDES - 1, -1):
            yield _polygon(sides, across_m * math.sin(math.pi / sides))


def _polygon(sides: int, side_m: float) -> list[Primitive]:
    """Return a way along a regular polygon that ends where and as it began; with two sides, out and back."""
    return [walk(Direction.FORWARD, round(side_m, 3)), turn(Direction.LEFT, round(360.0 / sides, 4))] * sides


def _dances(can: Capabilities) -> Iterator[list[Primitive]]:
    sway = [
        turn(side, degrees)
        for side, degrees in ((Direction.LEFT, SWAY_DEG), (Direction.RIGHT, 2 * SWAY_DEG), (Direction.LEFT, SWAY_DEG))
    ]
    gestures = [
        can.bound(Primitive(one.name, arguments=one.complete({})))
        for one in can.operations
        if one.action_class is ActionClass.GESTURE and one.harmless and not any(a.needed for a in one.arguments)
    ]
    if not can.does(BaseMotion.ROTATION):
        sway = []
    for count in range(min(_MOST_GESTURES, len(gestures)), -1, -1):
        if sway or count > 1:
            yield [*sway, *gestures[:count]]
