"""What we write into a NodeBB post besides its text, and how it is taken out again: key, status card, pictures (pure).

NodeBB has no idempotency keys and no cards, so both travel at the end of the raw text, in a link definition that no
reader sees and that does not stand in the page. A mark proves nothing: whoever reads it asks whose post it is.
"""

from __future__ import annotations

import base64
import json
import re
from dataclasses import asdict, dataclass, fields

from agentrob.model import StatusCard

_MARK = re.compile(r"\s*^\[//\]: # \(agentrob:([A-Za-z0-9_=-]{1,8192})\)\s*\Z", re.MULTILINE)
_PICTURE = re.compile(r"!\[[^\[\]\n]*\]\((\S+?)\)")
_CODE = re.compile(r"^(```|~~~).*?(^\1|\Z)|`[^`\n]*`", re.MULTILINE | re.DOTALL)
_MENTION = re.compile(r"(?<![\w@/.])@([\w-]+(?:\.[\w-]+)*)")
_CARD = frozenset(f.name for f in fields(StatusCard))


@dataclass(frozen=True, slots=True)
class Marked:
    """A raw post taken apart. `pictures` are addresses of pictures that stand below the text, put there by us."""

    text: str
    key: str | None = None
    card: StatusCard | None = None
    pictures: tuple[str, ...] = ()


def mark(marked: Marked) -> str:
    """The raw text that `unmark` takes apart."""
    facts = {
        "k": marked.key,
        "p": len(marked.pictures) or None,
        "c": {k: v for k, v in asdict(marked.card).items() if v not in (None, "", 0)} if marked.card else None,
    }
    told = json.dumps({k: v for k, v in facts.items() if v is not None}, separators=(",", ":"), ensure_ascii=False)
    coded = base64.urlsafe_b64encode(told.encode()).decode()
    shown = (f"![picture {n}]({url})" for n, url in enumerate(marked.pictures, 1))
    return "\n\n".join((marked.text.rstrip(), *shown, f"[//]: # (agentrob:{coded})"))


def unmark(raw: str) -> Marked:
    """Of a text without a mark, or with one that is not ours, everything is text."""
    found = _MARK.search(raw)
    if found is None:
        return Marked(raw)
    try:
        facts = json.loads(base64.urlsafe_b64decode(found[1]))
        key, card, count = facts.get("k"), facts.get("c"), int(facts.get("p", 0))
        shown = StatusCard(**{k: v for k, v in card.items() if k in _CARD}) if card else None
    except (ValueError, TypeError, AttributeError):
        return Marked(raw)
    lines = raw[: found.start()].split("\n\n")
    below = [_PICTURE.fullmatch(line) for line in lines[len(lines) - count :]] if 0 < count < len(lines) else []
    pictures = tuple(m[1] for m in below if m) if all(below) else ()
    text = "\n\n".join(lines[: len(lines) - len(pictures)])
    return Marked(text, key if isinstance(key, str) else None, shown, pictures)


def pictures_in(text: str) -> tuple[str, ...]:
    """Addresses of the pictures that a text shows; code is passed over."""
    return tuple(dict.fromkeys(_PICTURE.findall(_CODE.sub(" ", text))))


def names_in(text: str) -> tuple[str, ...]:
    """What may be mentions, lower case: the forum says which of them are accounts. Code and quotes are passed over."""
    own = "\n".join(line for line in _CODE.sub(" ", text).splitlines() if not line.lstrip().startswith(">"))
    return tuple(dict.fromkeys(m.lower() for m in _MENTION.findall(own)))
