"""Regular expressions in f-strings: `{1,4}` there is a tuple and no quantifier."""

from __future__ import annotations

import ast
from pathlib import Path

SOURCES = Path(__file__).parents[2] / "src" / "agentrob"


def tuples_in(source: str) -> list[int]:
    """Return the lines of f-strings that format a tuple of numbers."""
    return [
        node.lineno
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.FormattedValue)
        and isinstance(node.value, ast.Tuple)
        and all(isinstance(part, ast.Constant) for part in node.value.elts)
    ]


def test_no_quantifier_is_formatted_as_a_tuple() -> None:
    found = {str(path): lines for path in SOURCES.rglob("*.py") if (lines := tuples_in(path.read_text("utf-8")))}
    assert found == {}


def test_a_formatted_quantifier_is_found() -> None:
    assert tuples_in('x = 1\ny = rf"{x}[ab]{1,4}"') == [2]
    assert tuples_in('y = rf"{x}[ab]{{1,4}}"') == []
