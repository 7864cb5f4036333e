"""What a clause says is somewhere, so that it is not read as a command: 前面五米是墙."""

from __future__ import annotations

import re

_CLAUSE = re.compile(r"(?:[^，,。.！!？?；;：:\n]|(?<=\d)\.(?=\d))+")


def without_statements(part: str, stated: str) -> str:
    """With such clauses blanked; `stated` is a language's expression of their beginning. What is asked stays."""
    if not stated:
        return part
    said = re.compile(rf"\s*{stated}")

    def blank(clause: re.Match[str]) -> str:
        asked = part[clause.end() : clause.end() + 1] in ("?", "？")
        found = None if asked else said.match(clause[0])
        return " " * found.end() + clause[0][found.end() :] if found else clause[0]

    return _CLAUSE.sub(blank, part)
