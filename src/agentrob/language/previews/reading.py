"""Recognise a post that asks for a preview ("preview walk 3 m", "walk 3 m, but show me first") and split it off.

Nothing that speaks of a preview moves a robot: what is not wholly understood is asked about.
"""

from __future__ import annotations

import re
from functools import cache

from agentrob.language.messages.catalog import say
from agentrob.language.registry import known, language_of, locale
from agentrob.language.visible_text import mention_spans

_ENDS = " \t\r\n,.!?;:，。！？；：、~"


def rehearsed_part(part: str, visible: str) -> str | None:
    """Return the command that the part of a post for one robot asks to preview, empty if it names none; None if it asks
    for no preview. "Preview:" before the first mention asks for a preview of every part."""
    rest = rehearsed_text(part)
    return part.strip() if rest is None and rehearsed_text(_before_mentions(visible)) == "" else rest


def asking_for_preview(text: str) -> str:
    """Return the text of a post with a request for a preview in front, unless it asks for one."""
    if speaks_of_preview(text, text):
        return text
    joint = "\n\n" if "\n" in text.strip() else ""
    return say("preview.ask", language_of(text), text=f"{joint}{text}")


def rehearsed_text(part: str) -> str | None:
    """As `rehearsed_part`, by the part alone."""
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
    texts = part, _before_mentions(visible)
    return any(_compiled(of.previews.hints).search(text) for of in known().values() for text in texts)


def _before_mentions(visible: str) -> str:
    return next((visible[:start] for _, start, _ in mention_spans(visible)), "")


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern, re.IGNORECASE)
