"""Sources of the repository; each file is read and parsed once per test process."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """Return all nodes of a Python file."""
    return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def functions(source: str) -> list[str]:
    """Return the names of a file's functions in order, without parsing, which would take seconds for all test files."""
    return re.findall(r"^[ \t]*(?:async )?def (\w+)\(", source, re.MULTILINE)


@cache
def functions_of(path: Path) -> tuple[str, ...]:
    return tuple(functions(path.read_text(encoding="utf-8")))
