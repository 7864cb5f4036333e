"""Score readings of sentences against labelled plans: exact matches, and what moved (pure).

A row is `{"text": …, "plan": [steps] | [] | null}`: steps, nothing (not a command), or the robot must ask back. A step
is `{"op": "move", "direction", "distance_m"}`, `{"op": "turn", "direction": "left|right|any", "degrees"}`, or only an
`op`. `accept` may list other plans that count.
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
    """A row that was not understood as labelled, with the actual result."""

    text: str
    wanted: Sequence[Row] | None
    intent: str
    plan: Sequence[Row]
    question: str


@dataclass(frozen=True, slots=True)
class Scored:
    """One row: the label (`steps`, `nothing`, `a question`), the result, and whether they match."""

    wanted: str
    intent: Intent
    moves: bool
    exact: bool


@dataclass(frozen=True, slots=True)
class Score:
    """All rows. `exact` counts rows understood as labelled, `moved` rows in which the robot would move."""

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
        """Return counts and failures.

        `executed` counts rows read as commands, `asked` all others, `ignored` those of them without a question.
        `refused` is 0, because this measures understanding, not permission.
        """
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
    """Pass each row's text to `understand`. Raises `ValueError` for a row without `text` or `plan`."""
    scored: list[Scored] = []
    failures: list[Failure] = []
    for row in rows:
        if not isinstance(row.get("text"), str) or "plan" not in row:
            raise ValueError(f"a row needs `text` and `plan`; this one has {', '.join(row) or 'nothing'}")
        got, plan = understand(row["text"]), row["plan"]
        exact = any(matches(got, one) for one in (plan, *row.get("accept", ())))
        wanted = "a question" if plan is None else "steps" if plan else "nothing"
        scored.append(Scored(wanted, got.intent, got.plan.moves, exact))
        if not exact:
            failures.append(Failure(row["text"], plan, str(got.intent), got.plan.as_data(), got.question))
    return Score(tuple(scored), tuple(failures))


def matches(got: Understanding, wanted: Sequence[Row] | None) -> bool:
    """Compare operations in order, distances within 2 % and degrees within 1; direction `any` matches both sides."""
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
