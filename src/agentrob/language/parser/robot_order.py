"""Detect posts that put the steps of several robots in order: "@a walk 1 m, then @b wave", "when @a is done, @b wave".

Each robot reads only its own part and begins at once; none knows when another has finished. So every robot mentioned in
such a post asks back.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache

from agentrob.language.registry import known
from agentrob.language.visible_text import mention_spans

#: What may stand between an ordering word and the mention.
_BETWEEN = r"(?:[\s,，:：、]|please\b|let\b|have\b|make\b|ask\b|tell\b|and\b|it's\b|请|让|叫|由|轮到)*"
_POLITE = re.compile(
    r"(?:\W|\b(?:ok|okay|alright|well|so|hi|hello|please|thanks|great|now|and|yes)\b|[好的那嗯啊])*", re.I
)


def ordering_words(visible: str, names: Sequence[str], others: Sequence[str]) -> str:
    """Return the words that order this robot's part relative to another's; "" if there are none.

    `names` and `others` are as for `addressing.part_for`. A single robot that is mentioned after such a word and other
    words counts too: those words may be for the robot in whose thread the post is.
    """
    robots = {n.lower() for n in (*names, *others)}
    spans = [(name, start, end) for name, start, end in mention_spans(visible) if name in robots]
    if not spans:
        return ""
    several = len({name for name, _, _ in spans}) > 1
    before, waits, after, begins = _patterns()
    for at, (_, start, end) in enumerate(spans):
        since = spans[at - 1][2] if at else 0
        until = spans[at + 1][1] if at + 1 < len(spans) else len(visible)
        ahead, following = visible[since:start], visible[end:until]
        found = before.search(ahead)
        if found and (several if at else not _POLITE.fullmatch(ahead[: found.start()])):
            return found["words"]
        if several:
            later = after.search(following) or begins.match(following) if at else _first().search(following)
            found = waits.search(ahead) or later
            if found:
                return found["words"]
    return ""


@cache
def _patterns() -> tuple[re.Pattern[str], ...]:
    """Return the patterns, in order: an ordering word right before a mention; a condition in the clause before it; an
    ordering word at the end of its part; one at the beginning of its part.
    """
    order, waits = _either("order"), _either("waits")
    flags = re.IGNORECASE
    return (
        re.compile(rf"(?P<words>{order}){_BETWEEN}$", flags),
        re.compile(rf"(?P<words>{waits})(?![A-Za-z])[^.,;!?\n，。；！？]*$", flags),
        re.compile(rf"(?P<words>{order})[\s.,!?。，！？]*$", flags),
        re.compile(rf"{_BETWEEN}(?P<words>{order})(?![A-Za-z])", flags),
    )


@cache
def _first() -> re.Pattern[str]:
    """Match words that put the first robot's part first."""
    return re.compile(r"(?P<words>\bfirst|首先|先)[\s.,!?;。，！？；]*$", re.IGNORECASE)


def _either(field: str) -> str:
    """Return an alternation of the words of all languages, longest first; words in Latin letters match whole words."""
    words = {w.strip() for t in known().values() for w in getattr(t, field).replace("\n", "").split("|")} - {""}
    return "|".join(
        rf"(?<![A-Za-z]){re.escape(w)}" if w.isascii() else w for w in sorted(words, key=lambda w: (-len(w), w))
    )
