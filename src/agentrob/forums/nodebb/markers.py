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
    """Return the raw text that `unmark` takes apart; pictures are addresses."""
    shown = (f"![picture {n}]({url})" for n, url in enumerate(marked.pictures, 1))
    return "\n\n".join((marked.text.rstrip(), *shown, f"[//]: # (agentrob:{encode_marker(marked)})"))


def unmark(raw: str, ours: bool = True) -> MarkedText:
    """Take a raw text apart. Without a valid marker all of it is text.

    `ours`: the post is by this account or by a robot; otherwise the marker is removed without decoding.
    """
    return split_marker(raw, _MARK, _PICTURE, ours)


def pictures_in(text: str) -> tuple[str, ...]:
    """Return the addresses of the pictures in a text, without those in code."""
    return tuple(dict.fromkeys(_PICTURE.findall(_CODE.sub(" ", text))))


def names_in(text: str) -> tuple[str, ...]:
    """Return possible mentions in lower case, without those in code and quotes; the forum knows which are accounts."""
    own = "\n".join(line for line in _CODE.sub(" ", text).splitlines() if not line.lstrip().startswith(">"))
    return tuple(dict.fromkeys(m.lower() for m in _MENTION.findall(own)))
