"""What we write into a post besides its text where a forum has neither idempotency keys nor cards (pure).

Key, card and the number of pictures are coded into one word, which stands at the end of the raw text in a form that
readers do not see; that form is the platform's. A mark proves nothing: whoever reads it asks whose post it is.
"""

from __future__ import annotations

import base64
import json
import re
from dataclasses import asdict, dataclass, fields

from agentrob.model import StatusCard

#: What `coded` makes, as a group of a platform's pattern of its mark.
CODE = r"([A-Za-z0-9_=-]{1,8192})"
_CARD = frozenset(f.name for f in fields(StatusCard))


@dataclass(frozen=True, slots=True)
class Marked:
    """A raw post taken apart. `pictures` stand below the text, put there by us: addresses, or a platform's lines."""

    text: str
    key: str | None = None
    card: StatusCard | None = None
    pictures: tuple[str, ...] = ()


def coded(marked: Marked) -> str:
    """Key, card and the number of pictures, as one word."""
    facts = {
        "k": marked.key,
        "p": len(marked.pictures) or None,
        "c": {k: v for k, v in asdict(marked.card).items() if v not in (None, "", 0)} if marked.card else None,
    }
    told = json.dumps({k: v for k, v in facts.items() if v is not None}, separators=(",", ":"), ensure_ascii=False)
    return base64.urlsafe_b64encode(told.encode()).decode()


def taken_apart(raw: str, mark: re.Pattern[str], picture: re.Pattern[str]) -> Marked:
    """Of a text without a mark, or with one that is not ours, everything is text. The first group of `mark` is the
    code, that of `picture` what is kept of the line of a picture."""
    found = mark.search(raw)
    if found is None:
        return Marked(raw)
    try:
        facts = json.loads(base64.urlsafe_b64decode(found[1]))
        key, card, count = facts.get("k"), facts.get("c"), int(facts.get("p", 0))
        shown = StatusCard(**{k: v for k, v in card.items() if k in _CARD}) if card else None
    except (ValueError, TypeError, AttributeError):
        return Marked(raw)
    lines = raw[: found.start()].split("\n\n")
    below = [picture.fullmatch(line) for line in lines[len(lines) - count :]] if 0 < count < len(lines) else []
    pictures = tuple(m[1] for m in below if m) if all(below) else ()
    text = "\n\n".join(lines[: len(lines) - len(pictures)])
    return Marked(text, key if isinstance(key, str) else None, shown, pictures)
