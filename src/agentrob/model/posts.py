"""Posts as a forum delivers them, their status cards, and pages of results."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from datetime import datetime
from typing import Generic, TypeVar

from agentrob.model.accounts import Account
from agentrob.model.lifecycle import is_final_word

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class StatusCard:
    """The machine-readable state of one command, shown by a forum that can as a card on the status post.

    `state` is a `CommandState` of `CARD_STATES`; on the card of a newer agent it may be another word. `until` is when
    the approval that a waiting command needs lapses, as RFC 3339 with a zone; else empty.
    """

    robot: str
    state: str
    step: int = 0
    steps: int = 0
    doing: str = ""
    place: int | None = None
    trace_id: str = ""
    until: str = ""

    @property
    def is_final(self) -> bool:
        """Whether the command has ended."""
        return is_final_word(self.state)


@dataclass(frozen=True, slots=True)
class Post:
    """One post as a forum delivers it. `raw` is Markdown, `version` grows by one with each edit. `mentions` are the
    accounts that its page links as mentioned; `rendering_differs`: its page shows other words than those
    read from `raw`."""

    id: str
    topic_id: str
    board_id: str
    author: Account
    raw: str
    created_at: datetime
    version: int = 1
    edited_at: datetime | None = None
    removed: bool = False
    mentions: tuple[str, ...] = ()
    reply_to: str | None = None
    key: str | None = None
    url: str = ""
    images: tuple[str, ...] = ()
    card: StatusCard | None = None
    rendering_differs: bool = False

    @property
    def content_hash(self) -> str:
        """SHA-256 of the raw text, in hex; what a command is bound to."""
        return hashlib.sha256(self.raw.encode("utf-8", "surrogatepass")).hexdigest()


@dataclass(frozen=True, slots=True)
class Page(Generic[T]):
    """A page of results; `next` is the opaque cursor of the following page, None at the end."""

    items: tuple[T, ...]
    next: str | None = None
