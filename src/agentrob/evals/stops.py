"""Count how many posts stop a moving robot, of those that should and those that should not (law 13)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from agentrob.agent.intake.triage import Addressing, Route, triage
from agentrob.errors import ConfigError
from agentrob.evals.understanding import cell, read_rows
from agentrob.language.visible_text import mention_spans, visible_text
from agentrob.model import Account, AccountKind, Post, Role

EXAMPLE = '{"text": "stop right there", "stop": true}'
_NOW = datetime(2026, 1, 1, tzinfo=UTC)
_SOMEBODY = Account("2", "somebody", role=Role.MEMBER)


@dataclass(frozen=True, slots=True)
class StopScore:
    """The result for a file: `stops` rows should stop, `others` should not; and the texts judged wrongly."""

    stops: int
    others: int
    missed: tuple[str, ...]
    false: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        return {"stops": self.stops, "missed": len(self.missed), "others": self.others, "false": len(self.false)}


def evaluate_stops(path: Path, limit: int | None = None) -> StopScore:
    """Judge every row's `text` as a post in the thread of a moving robot's command; `stop` is the expected result.

    Raises `ConfigError` for an unreadable file or invalid rows.
    """
    rows = read_rows(path)[:limit]
    for row in rows:
        if not isinstance(row.get("text"), str) or not isinstance(row.get("stop"), bool):
            raise ConfigError(f"{path}: a row needs `text`, and `stop` true or false, such as {EXAMPLE}")
    stops = [row["text"] for row in rows if row["stop"]]
    others = [row["text"] for row in rows if not row["stop"]]
    return StopScore(
        len(stops), len(others),
        tuple(text for text in stops if not stops_it(text)), tuple(text for text in others if stops_it(text)),
    )  # fmt: skip


def stops_it(text: str) -> bool:
    """Return whether a member's post stops the robot it mentions first, or the thread's robot."""
    named = next((name.lower() for name, _, _ in mention_spans(visible_text(text))), "quadruped")
    robot = Account("1", named, AccountKind.ROBOT_AGENT)
    addressing = Addressing(
        robot, frozenset({named, "robot"}), ("robots",), _NOW - timedelta(days=1), _NOW, 120.0, {"thread"}, {"command"}
    )
    return triage(Post("post", "thread", "robots", _SOMEBODY, text, _NOW), addressing).route in (Route.STOP, Route.HALT)


def describe(found: StopScore) -> str:
    """Return both counts with their 95 % intervals, and every row judged wrongly."""
    lines = [
        f"missed: {cell(len(found.missed), found.stops)} of {found.stops} that should stop",
        f"false:  {cell(len(found.false), found.others)} of {found.others} that should not",
    ]
    return "\n".join([*lines, *_listed("missed", found.missed), *_listed("false", found.false)])


def _listed(name: str, texts: Sequence[str]) -> list[str]:
    return [f"  {name}: {text!r}" for text in texts]
