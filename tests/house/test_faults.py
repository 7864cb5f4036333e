"""docs/safety/faults.md matches the code: each kind of fault has a row, its tests exist, and the code has its
messages."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from agentrob.language.messages import en, zh
from tests.house.sources import functions_of, nodes

ROOT = Path(__file__).parents[2]
#: Faults that must have a row, by the first words of its first cell.
KINDS = (
    "no robot on the network", "robot appears later", "frozen robot", "state topic stops", "robot's computer dies",
    "command dropped", "pushed off course", "tipped over", "low battery", "path blocked before", "path blocked during",
    "odometry jump", "odometry not a number", "camera dead", "camera black", "wrong network interface", "wrong domain",
    "two drivers for one robot", "clock jump", "forum unreachable for ten minutes", "cable to the robot pulled",
    "link between an agent and a driver", "worker cut off from the journals' database",
)  # fmt: skip
#: A template with fewer fixed letters would match anything.
LEAST_LETTERS = 12


def table() -> list[list[str]]:
    lines = [
        line for line in (ROOT / "docs/safety/faults.md").read_text(encoding="utf-8").splitlines() if line[:1] == "|"
    ]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


ROWS = table()
IDS = [row[0].split(":")[0] for row in ROWS]


def pattern(node: ast.expr) -> str:
    """Return a string of the code as a regular expression; inserted values match anything."""
    if isinstance(node, ast.JoinedStr):
        return "".join(pattern(value) for value in node.values)
    if isinstance(node, ast.Constant):
        return re.sub(r"\\\{[^{}]*\\\}", ".+", re.escape(str(node.value)))
    return ".+"


@cache
def templates() -> list[re.Pattern[str]]:
    """Return all strings and f-strings of the packages whose messages reach people."""
    files = [*(ROOT / "src/agentrob/robots").rglob("*.py"), ROOT / "src/agentrob/process/host_lock.py"]
    found = {*en.PHRASES.values(), *zh.PHRASES.values()}
    patterns = {re.sub(r"\\\{[^{}]*\\\}", ".+", re.escape(text)) for text in found}
    for path in files:
        for node in nodes(path):
            if isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str)):
                patterns.add(pattern(node))
    return [re.compile(p) for p in patterns if sum(c.isalpha() for c in p) >= LEAST_LETTERS]


def said(words: str) -> bool:
    """Return whether a template produces these words, as a whole or as one complete sentence."""
    return any(t.fullmatch(words) for t in templates()) or any(
        re.escape(words) in t.pattern for t in templates() if len(words) >= LEAST_LETTERS
    )


def test_every_kind_of_fault_has_one_row() -> None:
    for kind in KINDS:
        assert sum(row[0].startswith(kind) for row in ROWS) == 1, kind
    assert all(len(row) == 5 and all(row) for row in ROWS)


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_the_tests_of_a_fault_exist(row: list[str]) -> None:
    named = re.findall(r"`(tests/[^`]+)`", row[4])
    assert named
    for name in named:
        path, _, test = name.partition("::")
        assert test in functions_of(ROOT / path), name


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_the_messages_of_a_fault_exist_in_the_code(row: list[str]) -> None:
    for words in re.findall(r"“([^”]+)”", " ".join(row)):
        assert said(words), words
    chinese = list(zh.PHRASES.values())
    for words in re.findall(r"「([^」]+)」", " ".join(row)):
        assert any(words in sentence for sentence in chinese), words


def test_unknown_messages_are_detected() -> None:
    assert not said("The robot is perfectly well and did everything.")
    assert not said("The battery is at 9 volts.")
    assert said("The battery is at 9 %, and below 15 % no motion begins (least_battery_percent).")
