"""Say what a robot did, with measured values: "walked 0.97 m, turned left 91°, waved 2 times, took a photo". Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from agentrob.language.messages.catalog import can_say, say
from agentrob.language.messages.plan_text import done_sentence, measured_text, step_label
from agentrob.model import ActionResult, Direction, Language

#: Less than this is not mentioned: the figure would be 0.
_LEAST_M, _LEAST_DEG = 0.005, 0.5


def done_text(results: Sequence[ActionResult], language: Language) -> str:
    """Return what was done, in order, equal actions combined; empty if nothing was done.

    A walk or turn that did not end as asked counts with what was measured of it, another step only if it is done.
    """
    parts = []
    for action, run in groupby(_actions(results, language)):
        times = len(list(run))
        parts.append(action if times == 1 else say("did.times", language, action=action, times=times))
    return say("agent.list.joint", language).join(parts)


def _actions(results: Sequence[ActionResult], language: Language) -> Iterator[str]:
    for result in results:
        if result.moved and (action := _action(result, language)):
            yield action


def _action(result: ActionResult, language: Language) -> str:
    step, measured = result.primitive, result.measured
    if step.translates:
        key, least, amount, shown = "did.move", _LEAST_M, measured.get("distance_m"), "{:.2f}"
    elif step.rotates:
        key, least, amount, shown = "did.turn", _LEAST_DEG, measured.get("degrees"), "{:.0f}"
    elif not result.ok:
        return ""
    elif can_say(f"did.{step.op}"):
        return say(f"did.{step.op}", language)
    else:
        return _declared(result, language)
    direction = step.direction or (Direction.FORWARD if step.translates else Direction.LEFT)
    named = say(f"direction.{direction}", language)
    if amount is None:
        return say(f"{key}.unknown", language, direction=named)
    if abs(amount) < least:
        return ""
    if step.rotates:
        return say(key, language, direction=named, degrees=shown.format(amount))
    return say(f"{key}.{direction}", language, metres=shown.format(amount))


def _declared(result: ActionResult, language: Language) -> str:
    """Return an operation that the robot declares, with what was measured of it: "blew bubbles (3.0 s)"."""
    operation = result.primitive.operation
    done = done_sentence(result.primitive, language) or step_label(result.primitive, language)
    found = [(result.measured[q.name], q.unit) for q in operation.measured if q.name in result.measured]
    if not found:
        return done
    amounts = say("list.joint", language).join(measured_text(value, unit) for value, unit in found)
    return say("did.declared", language, action=done, amounts=amounts)
