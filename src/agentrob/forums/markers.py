"""Encode key, card and pictures of a post into its text, for forums without idempotency keys and cards (pure).

The code is one word at the end of the raw text, hidden from readers in a way that each platform defines. A marker
proves nothing: check the post's author.
"""

from __future__ import annotations

import base64
import json
import re
from dataclasses import dataclass

from agentrob.forums.cards import card_of, facts_of
from agentrob.model import StatusCard

#: A code by `encode_marker`, as a group for the platform's pattern of a marker.
CODE = r"([A-Za-z0-9_=-]{1,8192})"
#: The most pictures below a text.
MOST_PICTURES = 50


@dataclass(frozen=True, slots=True)
class MarkedText:
    """A raw post taken apart. `pictures` are the ones that we put below the text: addresses, or a platform's lines."""

    text: str
    key: str | None = None
    card: StatusCard | None = None
    pictures: tuple[str, ...] = ()


def encode_marker(marked: MarkedText) -> str:
    """Encode key, card and the number of pictures as one word."""
    facts = {
        "k": marked.key,
        "p": len(marked.pictures) or None,
        "c": facts_of(marked.card) if marked.card else None,
    }
    text = json.dumps({k: v for k, v in facts.items() if v is not None}, separators=(",", ":"), ensure_ascii=False)
    return base64.urlsafe_b64encode(text.encode()).decode()


def split_marker(raw: str, mark: re.Pattern[str], picture: re.Pattern[str], ours: bool = True) -> MarkedText:
    """Split a raw post into text, key, card and pictures. Never raises. Without a valid marker, all of it is text.

    The first group of `mark` is the code, that of `picture` the part of a picture's line to keep. If the post is not
    `ours` (by this account or a robot), the marker is removed without decoding: no key, no card, and as pictures the
    lines of pictures directly above it.
    """
    found = mark.search(raw)
    if found is None:
        return MarkedText(raw)
    facts = _decoded(found[1]) if ours else _Facts(pictures=MOST_PICTURES)
    if facts is None:
        return MarkedText(raw)
    lines = raw[: found.start()].rstrip().split("\n\n")
    pictures = _pictures(lines, picture, facts.pictures)
    if ours and len(pictures) != facts.pictures:
        pictures = ()
    text = "\n\n".join(lines[: len(lines) - len(pictures)])
    return MarkedText(text, facts.key, facts.card, pictures)


@dataclass(frozen=True, slots=True)
class _Facts:
    key: str | None = None
    card: StatusCard | None = None
    pictures: int = 0


def _decoded(code: str) -> _Facts | None:
    """Decode a code; None if `encode_marker` cannot have made it."""
    try:
        facts = json.loads(base64.urlsafe_b64decode(code), parse_constant=_no_number)
    except (ValueError, RecursionError):
        return None
    if not isinstance(facts, dict):
        return None
    key, count, card = facts.get("k"), facts.get("p", 0), facts.get("c")
    if type(count) is not int or not 0 <= count <= MOST_PICTURES or not isinstance(key, str | None):
        return None
    if card is not None and (card := card_of(card)) is None:
        return None
    return _Facts(key, card, count)


def _no_number(said: str) -> None:
    raise ValueError(f"{said} is not JSON")


def _pictures(lines: list[str], picture: re.Pattern[str], most: int) -> tuple[str, ...]:
    """Return the pictures in the last lines; the first line is never one of ours."""
    found: list[str] = []
    for line in reversed(lines[1:]):
        if len(found) == most or (match := picture.fullmatch(line)) is None:
            break
        found.insert(0, match[1])
    return tuple(found)
