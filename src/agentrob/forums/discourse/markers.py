"""Write and read the hidden marker at the end of a Discourse post: key, card, pictures (pure).

Discourse has no idempotency keys and no cards, so both are stored at the end of the raw text in an empty element that
readers do not see. It is not an HTML comment, because Discourse does not count comments towards the minimum length of
a post (`StrippedLengthValidator`), and robots' posts are short. The marker also makes each text unique, so that
Discourse neither rejects it as too similar nor answers with an older post of the same words. A marker proves nothing:
check the post's author.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from contextlib import suppress
from html.parser import HTMLParser
from urllib.parse import unquote

from agentrob.forums.markers import CODE, MarkedText, encode_marker, split_marker

__all__ = ["MarkedText", "external_id", "mark", "mentions_and_images", "picture", "unmark"]

_MARK = re.compile(rf'<div data-agentrob="{CODE}"></div>\s*\Z')
_PICTURE = re.compile(r"(!\[[^\[\]\n]*\]\(upload://[A-Za-z0-9_.-]+\))")


def mark(marked: MarkedText) -> str:
    """Return the raw text that `unmark` takes apart; pictures are Markdown lines by `picture`."""
    return "\n\n".join((marked.text.rstrip(), *marked.pictures, f'<div data-agentrob="{encode_marker(marked)}"></div>'))


def unmark(raw: str, ours: bool = True) -> MarkedText:
    """Take a raw text apart. Without a valid marker all of it is text.

    `ours`: the post is by this account or by a robot; otherwise the marker is removed without decoding.
    """
    return split_marker(raw, _MARK, _PICTURE, ours)


def picture(short_url: str, number: int) -> str:
    """Return the line that shows an uploaded picture."""
    return f"![{number}]({short_url})"


def external_id(account_id: str, key: str) -> str:
    """Return a topic's `external_id`, at most 50 of `[A-Za-z0-9_-]`: one for each account and key."""
    return "agentrob-" + hashlib.sha256(f"{account_id}\0{key}".encode()).hexdigest()[:40]


# ---------------------------------------------------------------- what the forum made of the text
class _Cooked(HTMLParser):
    """Collects resolved mentions and uploaded pictures."""

    def __init__(self) -> None:
        super().__init__()
        self.mentions: list[str] = []
        self.pictures: list[str] = []
        self._quoted = 0
        self._boxed = False

    def handle_starttag(self, tag: str, attrs: Sequence[tuple[str, str | None]]) -> None:
        has = {k: v or "" for k, v in attrs}
        classes = has.get("class", "").split()
        if tag == "aside" and (self._quoted or "quote" in classes):
            self._quoted += 1
        if self._quoted:
            return
        if tag == "a":
            self._boxed = "lightbox" in classes
            if "mention" in classes:
                self.mentions.append(unquote(has.get("href", "").rstrip("/").rpartition("/")[2]).lower())
            elif self._boxed:
                self._add(has.get("href", ""))
        elif tag == "img" and not self._boxed and not {"emoji", "avatar"} & set(classes):
            self._add(has.get("src", ""))

    def handle_endtag(self, tag: str) -> None:
        if tag == "aside" and self._quoted:
            self._quoted -= 1
        elif tag == "a":
            self._boxed = False

    def _add(self, url: str) -> None:
        if "/uploads/" in url:
            self.pictures.append(url)


def mentions_and_images(cooked: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the mentioned names (lower case) and the addresses of pictures in a post's HTML, without quotes."""
    reader = _Cooked()
    with suppress(Exception):  # the parser fails on some malformed declarations; keep what it found before
        reader.feed(cooked)
    return tuple(dict.fromkeys(n for n in reader.mentions if n)), tuple(reader.pictures)
