"""Measure how well a mind reads a file of labelled sentences, one JSON object a line."""

from __future__ import annotations

import asyncio
import json
import math
import signal
from collections.abc import Awaitable, Callable, Hashable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from agentrob.config.load import Config
from agentrob.errors import ConfigError, MindError
from agentrob.evals.scoring import Score, Scored, score
from agentrob.language.visible_text import visible_text
from agentrob.minds.protocol import Addressee, ManagedMind, Mind, Reading, read
from agentrob.minds.usage import Usage
from agentrob.model import Capabilities, Intent, Limits, Op
from agentrob.wiring import app

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")

#: A robot without limits, so that only understanding is measured. Like a Go2 it offers its paw as a greeting.
UNBOUND = Capabilities("any", frozenset(Op) - {Op.SHAKE}, Limits(0.5, 45, 100, 3600, 100, 3600, 100), simulated=True)


@dataclass(frozen=True, slots=True)
class PlanScore:
    """A file's score; `unanswered` counts texts that the mind did not read itself."""

    score: Score
    mind: str
    unanswered: int

    def as_json(self) -> dict[str, Any]:
        return {**self.score.as_json(), "mind": self.mind, "unanswered": self.unanswered}


def evaluate_plans(
    path: Path, mind: str = "rules", config: Config | None = None, limit: int | None = None
) -> PlanScore:
    """Read every row's text with a mind and compare it with the labelled plan (`agentrob.evals.scoring`).

    `limit` takes only the first rows. When interrupted, the score covers the rows read so far. Raises `ConfigError` for
    an unreadable file, invalid rows and an unknown mind; `MindError` if the mind answered no question.
    """
    rows = read_rows(path, limit)
    texts = [row["text"] for row in rows if isinstance(row.get("text"), str)]
    readings = asyncio.run(_read(app.make_mind(mind, config), texts))
    rows = [row for row in rows if not isinstance(row.get("text"), str) or row["text"] in readings]
    texts = [text for text in texts if text in readings]
    if why := never_answered([reading.usage for reading in readings.values()]):
        raise MindError(f"the mind {mind!r} answered no question ({why}); see: agentrob mind check {mind}")
    try:
        found = score(rows, lambda text: readings[text].understanding)
    except ValueError as e:
        raise ConfigError(f"{path}: {e}") from None
    return PlanScore(found, mind, sum(bool(readings[text].fallback) for text in texts))


async def _read(mind: Mind, texts: list[str]) -> dict[str, Reading]:
    addressee = Addressee(("robot",), (), UNBOUND)
    if isinstance(mind, ManagedMind):
        await mind.prepare()
    try:
        return await one_by_one(texts, lambda text: read(mind, visible_text(text), addressee))
    finally:
        if isinstance(mind, ManagedMind):
            await mind.close()


async def one_by_one(items: Sequence[K], work: Callable[[K], Awaitable[V]]) -> dict[K, V]:
    """Process the items in order with a progress bar on a terminal.

    On Ctrl-C or SIGTERM, return the results so far and say so on standard error.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    todo, found = list(dict.fromkeys(items)), dict[K, V]()
    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    task = asyncio.current_task()
    assert task is not None
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, task.cancel)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as shown:
        bar = shown.add_task("reading", total=len(todo))
        try:
            for item in todo:
                found[item] = await work(item)
                shown.advance(bar)
                await asyncio.sleep(0)  # let signal handlers run, also with a mind that never awaits
        except asyncio.CancelledError:
            if not found:
                raise KeyboardInterrupt from None
            console.print(f"interrupted after {len(found)} of {len(todo)}; the results cover these", markup=False)
    return found


def never_answered(usages: Sequence[Sequence[Usage]]) -> str:
    """Return why models failed every time they were asked; empty if one answered, or none was asked."""
    questions = [usage for one in usages for usage in one]
    return questions[-1].failed if questions and all(usage.failed for usage in questions) else ""


def read_rows(path: Path, limit: int | None = None) -> list[dict[str, Any]]:
    """Read a file of JSON objects, one a line, skipping empty lines; `limit` takes the first. Raises `ConfigError`."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as e:
        raise ConfigError(f"cannot read {path}: {getattr(e, 'strerror', None) or e}") from None
    rows = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            row = json.loads(line)
        except ValueError as e:
            raise ConfigError(f"{path}, line {number}: not JSON ({e})") from None
        if not isinstance(row, dict):
            raise ConfigError(f"{path}, line {number}: a row is a JSON object, such as {EXAMPLE}")
        rows.append(row)
    if not rows:
        raise ConfigError(f"{path} has no rows; a row is, for example, {EXAMPLE}")
    return rows[:limit]


EXAMPLE = '{"text": "turn left", "plan": [{"op": "turn", "direction": "left", "degrees": 90}]}'


def describe(found: PlanScore) -> str:
    """Return a table with 95 % intervals, and every failure with the expected and actual result."""
    result = found.score
    lines = [f"{result.exact} of {result.n} exact ({result.exact / result.n:.1%}), {result.moved} move something"]
    rows = [(wanted, [r for r in result.rows if r.wanted == wanted]) for wanted in ("steps", "nothing", "a question")]
    header = ("wanted", "n", "exact", "would move", "asked back")
    lines += table(header, [_line(*row) for row in (*rows, ("all", list(result.rows))) if row[1]])
    if found.unanswered:
        lines.append(f"{found.unanswered} texts that {found.mind} did not answer: other minds read them")
    for failure in result.failures:
        wanted = "to ask back" if failure.wanted is None else _steps(failure.wanted) or "nothing"
        got = _steps(failure.plan) or failure.intent
        lines.append(f"  {failure.text!r}\n    wanted {wanted}\n    got    {got}")
    return "\n".join(lines)


def _line(wanted: str, rows: Sequence[Scored]) -> Sequence[str]:
    counts = (sum(r.exact for r in rows), sum(r.moves for r in rows), sum(r.intent is Intent.ASK_BACK for r in rows))
    return wanted, str(len(rows)), *(cell(count, len(rows)) for count in counts)


def _steps(steps: Any) -> str:
    return ", ".join(" ".join(str(value) for value in step.values()) for step in steps)


# ---------------------------------------------------------------------- counting
def wilson(count: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """Return the 95 % Wilson interval of a share, both ends in 0..1; (0, 1) for n = 0."""
    if n == 0:
        return 0.0, 1.0
    share = count / n
    middle = (share + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
    return max(0.0, middle - half), min(1.0, middle + half)


def cell(count: int, n: int) -> str:
    """Return a count with its share and interval for a table: "3 (1.5%, 0.5–4.3%)"."""
    low, high = wilson(count, n)
    return f"{count} ({count / n if n else 0:.1%}, {low:.1%}–{high:.1%})"


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return lines of columns, each as wide as its widest cell."""
    widths = [max(len(row[at]) for row in (header, *rows)) for at in range(len(header))]
    return [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()
        for row in (header, *rows)
    ]
