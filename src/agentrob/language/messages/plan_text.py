"""Render steps and plans as text: as commands that the grammar reads back, and as labels for reports."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import groupby

from agentrob.language.messages.catalog import can_say, say
from agentrob.model import Language, Op, Plan, Primitive

_OUTLINED = 10


def sentence(plan: Plan | Sequence[Primitive], language: Language) -> str:
    """Return all steps in order, with equal ones combined ("wave 2 times"); empty for an empty plan."""
    steps = plan.steps if isinstance(plan, Plan) else plan
    parts = []
    for step, run in groupby(steps):
        times = len(list(run))
        one = step_sentence(step, language)
        parts.append(one if times == 1 else say("step.times", language, step=one, times=times))
    return say("step.joint", language).join(parts)


def outline(steps: Sequence[Primitive], language: Language) -> str:
    """Return the same for at most ten steps."""
    return sentence(steps[:_OUTLINED], language) + (" …" if len(steps) > _OUTLINED else "")


@lru_cache(maxsize=64)
def operation_names(ops: frozenset[Op], language: Language) -> str:
    """Return the names of what a robot with these operations can do: "walk, turn, wave"."""
    first = (Op.MOVE, Op.TURN)
    named = [op for op in (*first, *(op for op in Op if op not in first)) if op in ops]
    return say("list.joint", language).join(operation_name(op, language) for op in named)


def operation_name(op: Op, language: Language) -> str:
    """Return an operation as a verb without amounts: "walk", "take a photo"."""
    return say(f"verb.{op}", language) if op in (Op.MOVE, Op.TURN) else step_sentence(Primitive(op), language)


def step_sentence(step: Primitive, language: Language) -> str:
    """Return one step as a command that the grammar reads as this step: "walk forward 1.5 m"."""
    key = "step.move_at" if step.op is Op.MOVE and step.speed_mps is not None else f"step.{step.op}"
    return _render(key, step, language)


def step_label(step: Primitive, language: Language) -> str:
    """Return one step as reports show it: "walk forward 1 m", "turn left 90°"."""
    label = _render(f"label.{step.op}", step, language)
    return say("label.speed", language, step=label, speed=f"{step.speed_mps:g}") if step.speed_mps else label


def _render(key: str, step: Primitive, language: Language) -> str:
    """Fill a step's amounts into the sentence `key`; show an operation without a sentence by its name."""
    if not can_say(key):
        return step.op.replace("_", " ")
    direction = say(f"direction.{step.direction}", language) if step.direction else ""
    amounts = {"metres": step.distance_m, "degrees": step.degrees, "speed": step.speed_mps}
    return say(key, language, direction=direction, **{name: _number(amount) for name, amount in amounts.items()})


def _number(value: float | None) -> str:
    """Format a number without exponent or trailing zeros, to four decimals."""
    return f"{value:.4f}".rstrip("0").rstrip(".") if value else "0"
