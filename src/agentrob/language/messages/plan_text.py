"""A plan as the sentence that means it: what is shown back to people, and what the grammar reads as the same plan."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from agentrob.language.messages.catalog import can_say, say
from agentrob.model import Language, Op, Plan, Primitive

_OUTLINED = 10


def sentence(plan: Plan | Sequence[Primitive], language: Language) -> str:
    """All steps in order; equal ones together ("wave 2 times"). Empty for an empty plan."""
    steps = plan.steps if isinstance(plan, Plan) else plan
    parts = []
    for step, run in groupby(steps):
        times = len(list(run))
        one = step_sentence(step, language)
        parts.append(one if times == 1 else say("step.times", language, step=one, times=times))
    return say("step.joint", language).join(parts)


def outline(steps: Sequence[Primitive], language: Language) -> str:
    """The same, of at most ten steps."""
    return sentence(steps[:_OUTLINED], language) + (" …" if len(steps) > _OUTLINED else "")


def operation_names(ops: frozenset[Op], language: Language) -> str:
    """What a robot with these operations can do, by names alone: "walk, turn, wave"."""
    verbs = [say(f"verb.{op}", language) for op in (Op.MOVE, Op.TURN) if op in ops]
    others = [step_sentence(Primitive(op), language) for op in Op if op in ops and op not in (Op.MOVE, Op.TURN)]
    return say("list.joint", language).join([*verbs, *others])


def step_sentence(step: Primitive, language: Language) -> str:
    """One step as a command: "walk forward 1.5 m". An operation without words here is told by its name."""
    values = {
        "direction": say(f"direction.{step.direction}", language) if step.direction else "",
        "metres": _number(step.distance_m),
        "degrees": _number(step.degrees),
        "speed": _number(step.speed_mps),
    }
    key = "step.move_at" if step.op is Op.MOVE and step.speed_mps is not None else f"step.{step.op}"
    return say(key, language, **values) if can_say(key) else step.op.replace("_", " ")


def _number(value: float | None) -> str:
    """Without exponent and needless zeros, to a tenth of a millimetre."""
    return f"{value or 0.0:.4f}".rstrip("0").rstrip(".")
