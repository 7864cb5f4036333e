"""How long the Markdown parser may take for a text, estimated before it is parsed; and NFKC. Both in linear time.

markdown-it-py takes tens of microseconds for each character that may begin markup, and for some texts more than linear
time (tables whose rows are completed, quotations and lists within each other). Whoever parses what others wrote on an
event loop, where a stop waits for it (law 15), asks here first.
"""

from __future__ import annotations

import re
import unicodedata

#: Microseconds on a slow core for each of: a character that may begin markup, one at which the parser only looks up, a
#: line, a level of quotations and lists around a line, a cell of a table, any character. Found by measuring the texts
#: of `tests/language/hostile_markdown.py` and combinations of them.
_MARK_US, _PAUSE_US, _LINE_US, _LEVEL_US, _CELL_US, _CHAR_US = 50, 20, 50, 6, 20, 0.5
_MARKS, _PAUSES = "[]!<>*_`~&\\|@:", "#$%+-=^{}"
#: The parser nests no deeper (`maxNesting` of its CommonMark preset).
_DEEPEST = 20
_CONTAINERS = re.compile(r"(?:[ \t]*(?:[>*+-]|[0-9]{1,9}[.)]))*[ \t]*")
_BLANK_LINE = re.compile(r"\n[ \t]*(?=\n)")
_MARKERS = re.compile(r"[>*+-]|[0-9][.)]|\t|  ")
#: As in the stream-safe format of Unicode (UAX #15): no language has more marks on one letter.
_MOST_COMBINING = 30


def parsing_us(text: str, most: float = float("inf")) -> float:
    """About how many microseconds parsing takes, rather too many than too few. Counts no further once above `most`."""
    lines = text.count("\n") + text.count("\r") + 1
    found = len(text) * _CHAR_US + lines * _LINE_US
    found += _MARK_US * sum(map(text.count, _MARKS)) + _PAUSE_US * sum(map(text.count, _PAUSES))
    if found <= most:
        found += lines * _LEVEL_US * _depth(text)
    if found <= most and "|" in text:
        found += _CELL_US * sum(map(_cells, _BLANK_LINE.split(text)))
    return found


def _depth(text: str) -> int:
    """How many quotations and lists may be around a line."""
    deepest = 0
    for line in text.splitlines():
        if line and line[0] in " \t>*+-0123456789":
            containers = _CONTAINERS.match(line)
            deepest = max(deepest, len(_MARKERS.findall(containers[0] if containers else "")))
    return min(deepest, _DEEPEST)


def _cells(block: str) -> int:
    """How many cells a table of these lines may have: the parser completes rows that are too short."""
    lines = block.split("\n")
    return len(lines) * max(line.count("|") for line in lines)


def nfkc(text: str) -> str:
    """NFKC in linear time: of more than 30 combining marks in a row, which Python sorts in quadratic time, the first
    30 are kept."""
    if text.isascii():
        return text
    return unicodedata.normalize("NFKC", _with_few_marks(text))


def _with_few_marks(text: str) -> str:
    kept: list[str] = []
    marks = 0
    for char in text:
        marks = marks + 1 if not char.isascii() and unicodedata.combining(char) else 0
        if marks <= _MOST_COMBINING:
            kept.append(char)
    return "".join(kept)
