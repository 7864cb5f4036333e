"""Recognise a post that asks for a preview ("preview walk 3 m", "walk 3 m, but show me first") and split it off.

Nothing that speaks of a preview moves a robot: what is not wholly understood is asked about.
"""

from __future__ import annotations

import re
from functools import cache

from agentrob.language.registry import known, language_of, locale
from agentrob.language.visible_text import mention_spans

_ENDS = " \t\r\n,.!?;:，。！？；：、~"


def rehearsed_text(part: str) -> str | None:
    """Return the command that the part of a post for one robot asks to preview, empty if it names none; None if it asks
    for no preview."""
    words = locale(language_of(part)).previews
    rest, found = part.strip(_ENDS), False
    if match := _compiled(rf"(?:{words.leads})").match(rest):
        rest, found = rest[match.end() :], True
    plain = rest.rstrip(_ENDS)
    if match := _compiled(rf"(?:{words.ends})$").search(plain):
        rest, found = plain[: match.start()], True
    return rest.strip(_ENDS) if found else None


def speaks_of_preview(part: str, visible: str) -> bool:
    """Return whether the part of a post for one robot, or what stands before its first mention, speaks of a preview."""
    spans = list(mention_spans(visible))
    before = visible[: spans[0][1]] if spans else ""
    return any(_compiled(of.previews.hints).search(text) for of in known().values() for text in (part, before))


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern, re.IGNORECASE)
