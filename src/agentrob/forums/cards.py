"""Parse status cards from untrusted input (pure).

Every adapter passes cards through `card_by`: not every forum rejects a card that a stranger wrote, or one that names
another robot.
"""

from __future__ import annotations

import re
from dataclasses import asdict, fields
from typing import Any

from agentrob.model import Account, StatusCard

#: The longest text and the largest number in a card.
LONGEST = 2_000
LARGEST = 1_000_000
_SURROGATE = re.compile("[\ud800-\udfff]")
NUMBERS = frozenset(
    {"step", "steps", "place", "part", "parts", "bid_s", "bid_cm", "near_cm", "battery", "ahead", "takes"}
)
TEXTS = frozenset(f.name for f in fields(StatusCard)) - NUMBERS


def facts_of(card: StatusCard) -> dict[str, Any]:
    """Return a card as JSON, without empty fields."""
    return {name: value for name, value in asdict(card).items() if value not in (None, "", 0)}


def card_of(given: object) -> StatusCard | None:
    """Return the card in a JSON value, or None if it is not one. Unknown fields are ignored."""
    if not isinstance(given, dict):
        return None
    facts = {name: given[name] for name in (*TEXTS, *NUMBERS) if given.get(name) is not None}
    texts = [facts[name] for name in TEXTS if name in facts]
    numbers = [facts[name] for name in NUMBERS if name in facts]
    if not all(isinstance(t, str) and len(t) <= LONGEST and not _SURROGATE.search(t) for t in texts):
        return None
    if not all(type(n) is int and 0 <= n <= LARGEST for n in numbers):
        return None
    return StatusCard(**facts) if {"robot", "state"} <= facts.keys() else None


def card_by(author: Account, card: StatusCard | None) -> StatusCard | None:
    """Return the card of a post by this author, or None if the author is not the robot that it names (law 1)."""
    return card if card is not None and author.speaks_for(card.robot) else None
