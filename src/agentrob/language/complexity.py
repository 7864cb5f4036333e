"""Estimate in linear time how long the Markdown parser would take for a text, and normalise to NFKC in linear time.

markdown-it-py takes tens of microseconds for each character that may begin markup, and more than linear time for some
texts (tables with incomplete rows, quotations and lists nested in each other). Code that parses other people's text on
an event loop must check this first, so that a stop does not wait for the parser (law 15).
"""

from __future__ import annotations

import re
import unicodedata

#: Microseconds on a slow core for: a character that may begin markup, a character at which the parser only pauses, a
#: line, a nesting level of quotations and lists, a table cell, any character. Measured with the texts of
#: `tests/language/hostile_markdown.py` and combinations of them.
_MARK_US, _PAUSE_US, _LINE_US, _LEVEL_US, _CELL_US, _CHAR_US = 50, 20, 50, 6, 20, 0.5
_MARKS, _PAUSES = "[]!<>*_`~&\\|@:", "#$%+-=^{}"
#: The parser's nesting limit (`maxNesting` of its CommonMark preset).
_DEEPEST = 20
_CONTAINERS = re.compile(r"(?:[ \t]*(?:[>*+-]|[0-9]{1,9}[.)]))*[ \t]*")
_BLANK_LINE = re.compile(r"\n[ \t]*(?=\n)")
_MARKERS = re.compile(r"[>*+-]|[0-9][.)]|\t|  ")
#: Limit of Unicode's stream-safe format (UAX #15): no language puts more marks on one letter.
_MOST_COMBINING = 30


def parsing_us(text: str, most: float = float("inf")) -> float:
    """Estimate the parse time in microseconds, rather too high than too low; stop counting once it exceeds `most`."""
    lines = text.count("\n") + text.count("\r") + 1
    found = len(text) * _CHAR_US + lines * _LINE_US
    found += _MARK_US * sum(map(text.count, _MARKS)) + _PAUSE_US * sum(map(text.count, _PAUSES))
    if found <= most:
        found += lines * _LEVEL_US * _depth(text)
    if found <= most and "|" in text:
        found += _CELL_US * sum(map(_cells, _BLANK_LINE.split(text)))
    return found


def _depth(text: str) -> int:
    """Return an upper bound of how many quotations and lists enclose a line."""
    deepest = 0
    for line in text.splitlines():
        if line and line[0] in " \t>*+-0123456789":
            containers = _CONTAINERS.match(line)
            deepest = max(deepest, len(_MARKERS.findall(containers[0] if containers else "")))
    return min(deepest, _DEEPEST)


def _cells(block: str) -> int:
    """Return how many cells a table of these lines may have: the parser fills rows that are too short."""
    lines = block.split("\n")
    return len(lines) * max(line.count("|") for line in lines)


def nfkc(text: str) -> str:
    """Normalise to NFKC in linear time: Python sorts combining marks in quadratic time, so keep only the first 30 in a
    row.
    """
    if text.isascii():
        return text
    return unicodedata.normalize("NFKC", _with_few_marks(text))


def _with_few_marks(text: str) -> str:
    if not any(map(unicodedata.combining, text)):
        return text
    kept: list[str] = []
    marks = 0
    for char in text:
        marks = marks + 1 if not char.isascii() and unicodedata.combining(char) else 0
        if marks <= _MOST_COMBINING:
            kept.append(char)
    return "".join(kept)
