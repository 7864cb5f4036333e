"""How the tests of language read a post and write down what was made of it."""

from __future__ import annotations

from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.visible_text import visible_text
from agentrob.model import Direction, Op, Plan, Primitive, Understanding

OPS = frozenset(Op)
NOTHING_KNOWN = ParseContext()


def read(text: str, background: ParseContext = NOTHING_KNOWN) -> Understanding:
    return parse(visible_text(text), ["quadruped"], ["dog2"], OPS, background)


def short(plan: Plan) -> str:
    """ "F1 l90 hello": direction and amount of walks (upper case) and turns, or the operation."""
    return " ".join(_short(step) for step in plan.steps)


def _short(step: Primitive) -> str:
    letter = str(step.direction or "?")[0]
    if step.op is Op.MOVE:
        return f"{letter.upper()}{step.distance_m:g}" + (f"@{step.speed_mps:g}" if step.speed_mps else "")
    return f"{letter}{step.degrees:g}" if step.op is Op.TURN else {"get_front_image": "photo"}.get(step.op, step.op)


def walk(direction: Direction, distance_m: float, speed_mps: float | None = None) -> Primitive:
    return Primitive(Op.MOVE, direction, distance_m=distance_m, speed_mps=speed_mps)


def turn(direction: Direction, degrees: float) -> Primitive:
    return Primitive(Op.TURN, direction, degrees=degrees)
