"""Rewrite lists and tables of CommonMark as Python-Markdown reads them, which Zensical uses.

Code hosts and editors show the pages as CommonMark: the text of a list item begins where its first word does, and a
list or a table may follow a paragraph at once. Python-Markdown wants four spaces for each level, and a blank line
before a list or a table.
"""

from __future__ import annotations

import re

_ITEM = re.compile(r"( *)([-*]|\d+\.) +(?=\S)")
_FENCE = re.compile(r" *(`{3,})")
#: Spaces of one level.
INDENT = 4


def rewrite(text: str) -> str:
    """Return the same document for Python-Markdown."""
    lines: list[str] = []
    levels: list[int] = []  # where the text of each open list item begins
    fence, spare = "", 0
    for line in text.split("\n"):
        if not line.strip():
            lines.append("")
            continue
        indent = len(line) - len(line.lstrip(" "))
        if not fence:
            while levels and indent < levels[-1]:
                levels.pop()
        item = None if fence else _ITEM.match(line)
        begin = levels[-1] if levels else 0
        if not fence:  # up to three spaces more mean nothing
            spare = indent - begin if indent - begin < INDENT else 0
        moved = " " * INDENT * len(levels) + line[begin + min(spare, max(0, indent - begin)) :]
        if _needs_blank_line(lines, moved, bool(item), not levels, fence):
            lines.append("")
        lines.append(moved)
        if item:
            levels.append(len(item[0]))
        if found := _FENCE.match(line):
            fence = "" if fence == found[1] else fence or found[1]
    return "\n".join(lines)


def _needs_blank_line(before: list[str], line: str, item: bool, outermost: bool, fence: str) -> bool:
    """Whether a list or a table begins at this line, directly behind a paragraph."""
    last = before[-1] if before else ""
    if fence or not last.strip() or last.lstrip().startswith(("```", "#")):
        return False
    if item:
        return outermost and not _in_list(before)
    return line.lstrip().startswith("|") and not last.lstrip().startswith("|")


def _in_list(before: list[str]) -> bool:
    """Whether the paragraph that ends here is part of a list."""
    for line in reversed(before):
        if not line.strip():
            return False
        if _ITEM.match(line):
            return True
    return False
