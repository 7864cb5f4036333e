"""Rooms that understand, screen and show commands know operations by their declarations, not by their names."""

from __future__ import annotations

import ast

import pytest

from tests.house.sources import ROOT, nodes

SOURCE = ROOT / "src" / "agentrob"
ROOMS = ("language", "screening", "minds", "mcp", "board")
#: The default lexicons, which say what words ask for the built-in operations.
LEXICONS = {"language/operations/spoken.py", "minds/extraction/evidence.py"}


def named(room: str) -> dict[str, list[str]]:
    """Return the built-in operations that the files of a room name, by file."""
    found: dict[str, list[str]] = {}
    for path in sorted((SOURCE / room).rglob("*.py")):
        for node in nodes(path):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "Op":
                found.setdefault(path.relative_to(SOURCE).as_posix(), []).append(node.attr)
    return found


@pytest.mark.parametrize("room", ROOMS)
def test_only_lexicons_name_operations(room: str) -> None:
    assert {path: ops for path, ops in named(room).items() if path not in LEXICONS} == {}


def test_lexicons_are_where_this_test_looks() -> None:
    assert {path for room in ROOMS for path in named(room)} == LEXICONS
