"""Write and read the hidden marker at the end of a NodeBB post: key, status card, pictures (pure).

NodeBB has no idempotency keys and no cards, so both are stored at the end of the raw text in a link definition, which
is not rendered. A marker proves nothing: check the post's author.
"""

from __future__ import annotations

import re

from agentrob.forums.markers import CODE, MarkedText, encode_marker, split_marker

__all__ = ["MarkedText", "mark", "names_in", "pictures_in", "unmark"]

_MARK = re.compile(rf"^\[//\]: # \(agentrob:{CODE}\)\s*\Z", re.MULTILINE)
_PICTURE = re.compile(r"!\[[^\[\]\n]*\]\((\S{1,1000}?)\)")
_CODE = re.compile(r"^(```|~~~).*?(^\1|\Z)|`[^`\n]*`", re.MULTILINE | re.DOTALL)
_MENTION = re.compile(r"(?<![\w@/.])@([\w-]+(?:\.[\w-]+)*)")


def mark(marked: MarkedText) -> str:
    """The raw text that `unmark` takes apart; pictures are addresses."""
    shown = (f"![picture {n}]({url})" for n, url in enumerate(marked.pictures, 1))
    return "\n\n".join((marked.text.rstrip(), *shown, f"[//]: # (agentrob:{encode_marker(marked)})"))


def unmark(raw: str, ours: bool = True) -> MarkedText:
    """Of a text without a mark, or with one that is not ours, everything is text. `ours`: the post is by this account
    or by a robot; else the mark is cut off unread."""
    return split_marker(raw, _MARK, _PICTURE, ours)


def pictures_in(text: str) -> tuple[str, ...]:
    """Addresses of the pictures that a text shows; code is passed over."""
    return tuple(dict.fromkeys(_PICTURE.findall(_CODE.sub(" ", text))))


def names_in(text: str) -> tuple[str, ...]:
    """What may be mentions, lower case: the forum says which of them are accounts. Code and quotes are passed over."""
    own = "\n".join(line for line in _CODE.sub(" ", text).splitlines() if not line.lstrip().startswith(">"))
    return tuple(dict.fromkeys(m.lower() for m in _MENTION.findall(own)))
