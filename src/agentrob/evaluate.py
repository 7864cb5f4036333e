"""How well a mind does on a file of labelled sentences: one JSON object a line."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

from agentrob.errors import ConfigError
from agentrob.language.score import Score, score
from agentrob.language.visible import visible_text
from agentrob.minds.mind import Listener, Mind
from agentrob.model import Capabilities, Limits, Op, Understanding
from agentrob.plugins import find

#: A robot that is bound by nothing: what is measured is understanding. It offers its paw as its hello, as a Go2 does.
UNBOUND = Capabilities("any", frozenset(Op) - {Op.SHAKE}, Limits(0.5, 45, 100, 3600, 100, 3600, 100), simulated=True)


def plans(path: Path, mind: str = "rules") -> Score:
    """Read every row's text by a mind and compare with the plan that was meant (`agentrob.language.score`).

    Raises `ConfigError` for a file that cannot be read or holds other rows, and for an unknown mind.
    """
    rows = read_rows(path)
    texts = [row["text"] for row in rows if isinstance(row.get("text"), str)]
    understood = asyncio.run(_understand(find("minds", mind)(), texts))
    try:
        return score(rows, understood.__getitem__)
    except ValueError as e:
        raise ConfigError(f"{path}: {e}") from None


async def _understand(mind: Mind, texts: list[str]) -> dict[str, Understanding]:
    listener = Listener(("robot",), (), UNBOUND)
    return {text: await mind.understand(visible_text(text), listener) for text in texts}


def read_rows(path: Path) -> list[dict[str, Any]]:
    """The JSON objects of a file, one a line; empty lines are passed over. Raises `ConfigError`."""
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
        raise ConfigError(f"{path} holds no rows; one is {EXAMPLE}")
    return rows


EXAMPLE = '{"text": "turn left", "plan": [{"op": "turn", "direction": "left", "degrees": 90}]}'


def describe(result: Score) -> str:
    """For people: the counts, and every failure with what was wanted and what came."""
    lines = [f"{result.exact} of {result.n} exact ({result.exact / result.n:.1%}), {result.moved} move something"]
    for failure in result.failures:
        wanted = "to ask back" if failure.wanted is None else _steps(failure.wanted) or "nothing"
        got = _steps(failure.plan) or failure.intent
        lines.append(f"  {failure.text!r}\n    wanted {wanted}\n    got    {got}")
    return "\n".join(lines)


def _steps(steps: Any) -> str:
    return ", ".join(" ".join(str(value) for value in step.values()) for step in steps)
