"""How well rows of sentences with the plans that people meant are understood: exact matches, and what moved (pure).

A row is `{"text": …, "plan": [steps] | [] | null}`: steps are wanted, or nothing (no command), or it must ask back. A
step is `{"op": "move", "direction", "distance_m"}`, `{"op": "turn", "direction": "left|right|any", "degrees"}`, or has
only its `op`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from agentrob.model import Intent, Primitive, Understanding

Row = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Failure:
    """A row that was not understood as wanted, with what came instead."""

    text: str
    wanted: Sequence[Row] | None
    intent: str
    plan: Sequence[Row]
    question: str


@dataclass(frozen=True, slots=True)
class Scored:
    """One row: what was wanted (`steps`, `nothing`, `a question`), what came, and whether that is it."""

    wanted: str
    intent: Intent
    moves: bool
    exact: bool


@dataclass(frozen=True, slots=True)
class Score:
    """All rows. `exact` counts those understood as they were meant, `moved` those in which the robot would move."""

    rows: tuple[Scored, ...]
    failures: tuple[Failure, ...]

    @property
    def n(self) -> int:
        return len(self.rows)

    @property
    def exact(self) -> int:
        return sum(row.exact for row in self.rows)

    @property
    def moved(self) -> int:
        return sum(row.moves for row in self.rows)

    def as_json(self) -> dict[str, Any]:
        """`executed` counts what is taken for a command, `asked` all else, of which `ignored` asks nothing either.
        Nothing is `refused`: this measures what is understood, not what is allowed."""
        executed = sum(row.intent is Intent.COMMAND for row in self.rows)
        asked = sum(row.intent is Intent.ASK_BACK for row in self.rows)
        failures = [
            {"text": f.text, "wanted": f.wanted, "intent": f.intent, "plan": f.plan, "question": f.question}
            for f in self.failures
        ]
        return {
            "n": self.n, "exact": self.exact, "moved": self.moved, "executed": executed, "refused": 0,
            "asked": self.n - executed, "ignored": self.n - executed - asked, "failures": failures,
        }  # fmt: skip


def score(rows: Iterable[Row], understand: Callable[[str], Understanding]) -> Score:
    """Ask `understand` about each row's text. Raises `ValueError` for a row without `text` or `plan`."""
    scored: list[Scored] = []
    failures: list[Failure] = []
    for row in rows:
        if not isinstance(row.get("text"), str) or "plan" not in row:
            raise ValueError(f"a row needs `text` and `plan`; this one has {', '.join(row) or 'nothing'}")
        got, plan = understand(row["text"]), row["plan"]
        exact, wanted = matches(got, plan), "a question" if plan is None else "steps" if plan else "nothing"
        scored.append(Scored(wanted, got.intent, got.plan.moves, exact))
        if not exact:
            steps = [{"op": str(step.op), **step.asked()} for step in got.plan.steps]
            failures.append(Failure(row["text"], plan, str(got.intent), steps, got.question))
    return Score(tuple(scored), tuple(failures))


def matches(got: Understanding, wanted: Sequence[Row] | None) -> bool:
    """Same operations in the same order, distances within 2 %, degrees within 1; `any` accepts either side."""
    if wanted is None:
        return got.intent is Intent.ASK_BACK
    if not wanted:
        return got.intent not in (Intent.COMMAND, Intent.ASK_BACK)
    steps = got.plan.steps
    return len(steps) == len(wanted) and all(map(_same, steps, wanted))


def _same(step: Primitive, row: Row) -> bool:
    if step.op != row["op"] or row.get("direction", step.direction) not in (step.direction, "any"):
        return False
    if "distance_m" in row and not math.isclose(step.distance_m or 0, row["distance_m"], rel_tol=0.02):
        return False
    return "degrees" not in row or abs((step.degrees or 0) - row["degrees"]) <= 1
