"""Every word in docs/inside/glossary.md is a name in the code."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.house.sources import nodes

ROOT = Path(__file__).parents[2]
ROWS = re.findall(r"^\| ([a-z]+) \| .+ \| `(\w+)` \|$", (ROOT / "docs/inside/glossary.md").read_text(), re.MULTILINE)


@pytest.fixture(scope="module")
def names() -> set[str]:
    """Return the names of all classes, functions, attributes and fields that the package defines."""
    found = set()
    for path in (ROOT / "src/agentrob").rglob("*.py"):
        for node in nodes(path):
            if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                found.add(node.name)
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                found.add(node.target.id)
    return found


@pytest.mark.parametrize(("word", "name"), ROWS)
def test_each_word_is_a_name_in_the_code(word: str, name: str, names: set[str]) -> None:
    assert name in names, f"docs/inside/glossary.md: {word}"


def test_the_glossary_is_read() -> None:
    assert len(ROWS) == (ROOT / "docs/inside/glossary.md").read_text().count("\n| ") - 1
    assert len({word for word, _ in ROWS}) == len(ROWS)
