"""What the files of the tree contain: each is read and parsed once in a test process."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """Every node of a Python file."""
    return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def functions(source: str) -> list[str]:
    """The names of the functions of a file, in its order. Parsing every test file takes seconds; this does not."""
    return re.findall(r"^[ \t]*(?:async )?def (\w+)\(", source, re.MULTILINE)


@cache
def functions_of(path: Path) -> tuple[str, ...]:
    return tuple(functions(path.read_text(encoding="utf-8")))
