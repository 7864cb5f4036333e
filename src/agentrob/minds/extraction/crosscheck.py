"""Whether two readings of the same post mean the same motion. Pure."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.minds.extraction.units import same
from agentrob.model import Plan, Primitive


def agree(one: Plan, other: Plan) -> bool:
    """The same steps in the same order, but for rounding."""
    return len(one.steps) == len(other.steps) and all(map(_alike, one.steps, other.steps))


def _alike(one: Primitive, other: Primitive) -> bool:
    amounts: Sequence[tuple[float | None, float | None]] = (
        (one.distance_m, other.distance_m),
        (one.degrees, other.degrees),
        (one.speed_mps, other.speed_mps),
    )
    return one.op is other.op and one.direction is other.direction and all(_equal(a, b) for a, b in amounts)


def _equal(one: float | None, other: float | None) -> bool:
    return one is other if one is None or other is None else same(one, other)
