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
    the approval that a waiting command needs lapses, or until when a queued part of a post waits for others, as RFC
    3339 with a zone; else empty.

    The card of a part of a post to several robots also has its number `part`, counted from 1, of `parts`, the id of the
    `post` and the hash of its text. A robot that may be chosen for a part bids: in `bid_s` it would be done, of which
    it walks `bid_cm`, with `battery` percent (0: not known) and `ahead` commands before it. If the nearest to something
    is wanted, it is `near_cm` away in the room `room`; 0 and empty if it does not know. `takes` is 1 on the post by
    which a robot takes such a part; the first one in the thread counts. `left_to` is the robot to which another left
    it.
    """

    robot: str
    state: str
    step: int = 0
    steps: int = 0
    doing: str = ""
    place: int | None = None
    trace_id: str = ""
    until: str = ""
    part: int = 0
    parts: int = 0
    post: str = ""
    content_hash: str = ""
    bid_s: int = 0
    bid_cm: int = 0
    near_cm: int = 0
    room: str = ""
    battery: int = 0
    ahead: int = 0
    takes: int = 0
    left_to: str = ""

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
