"""Compare a model's claims with the robot's measurements. Pure.

Measurements can contradict that the robot walked, that a named step was done, and distances and angles the model says
it did. What the model says it saw cannot be checked, and the report says so.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from agentrob.language.goal import Aim, Goal
from agentrob.language.messages.catalog import say
from agentrob.language.messages.plan_text import step_sentence
from agentrob.model import ActionResult, Language, Outcome, Primitive

#: Absolute and relative tolerance of claimed distances and angles.
NEAR_M, NEAR_DEG, NEAR_SHARE = 0.1, 5.0, 0.2
_NUMBER = r"(\d+(?:[.,]\d+)?)\s*-?\s*"
_METRES = re.compile(_NUMBER + r"(?:m\b|met(?:er|re)s?\b|米|公尺)", re.IGNORECASE)
_DEGREES = re.compile(_NUMBER + r"(?:°|deg(?:ree)?s?\b|度)", re.IGNORECASE)


def walked_m(results: Sequence[ActionResult]) -> float:
    """Return the measured length of all walks together, in metres."""
    return sum(abs(r.measured.get("distance_m", 0.0)) for r in results if r.primitive.translates)


def turned_deg(results: Sequence[ActionResult]) -> float:
    """Return the measured angle of all turns together in either direction, in degrees."""
    return sum(abs(r.measured.get("degrees", 0.0)) for r in results if r.primitive.rotates)


def contradiction(goal: Goal, claim: str, did: str, results: Sequence[ActionResult], language: Language = "en") -> str:
    """Return the first claim that the measurements contradict, as a clause in `language`; empty if there is none.

    If a step was not measured, amounts are not contradicted.
    """
    measured = not any(r.unmeasured for r in results)
    if claim == "done":
        if measured and any(t.aim is Aim.APPROACH for t in goal.tasks) and walked_m(results) < NEAR_M:
            return say("minds.claim.there", language, whole=f"{walked_m(results):.2f}")
        if (missing := _not_done(goal.steps, results)) is not None:
            return say("minds.claim.step", language, step=step_sentence(missing, language))
    for pattern, key, near in ((_METRES, "distance_m", NEAR_M), (_DEGREES, "degrees", NEAR_DEG)):
        for said in pattern.findall(did) if measured else ():
            amount = float(said.replace(",", "."))
            if not any(_near(amount, known, near) for known in _known(results, key)):
                whole = walked_m(results) if key == "distance_m" else turned_deg(results)
                return say(f"minds.claim.{key}", language, amount=f"{amount:g}", whole=f"{whole:.2f}")
    return ""


def _known(results: Sequence[ActionResult], key: str) -> list[float]:
    """Return every measured amount: of each step, and the sum."""
    each = [abs(r.measured.get(key, 0.0)) for r in results]
    return [*each, math.fsum(each)]


def _near(claimed: float, measured: float, near: float) -> bool:
    return abs(claimed - measured) <= max(near, NEAR_SHARE * measured)


def _not_done(steps: Sequence[Primitive], results: Sequence[ActionResult]) -> Primitive | None:
    """Return the first named step without a result that shows it as done."""
    done = [r.primitive for r in results if r.outcome is Outcome.DONE]
    for step in steps:
        same = next((d for d in done if _same(step, d)), None)
        if same is None:
            return step
        done.remove(same)
    return None


def _same(step: Primitive, done: Primitive) -> bool:
    amounts = ((step.distance_m, done.distance_m, NEAR_M), (step.degrees, done.degrees, NEAR_DEG))
    return (step.op, step.direction) == (done.op, done.direction) and all(
        a is None or (b is not None and abs(a - b) <= near) for a, b, near in amounts
    )
