"""The records that the store takes and returns: frozen, with string ids and aware UTC datetimes.

Paths are relative to the forum's address (`/t/12`): the JSON API prefixes the base URL, pages use them unchanged.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, TypeVar

from agentrob.model import Account, EventKind, Role

T = TypeVar("T")
#: Pixels of the longer side of a picture on a page, and in a list.
SMALL, THUMB = 960, 240
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def from_text(said: object) -> datetime | None:
    """A time from ISO 8601 with a zone; None for anything else, also for years that pages cannot show."""
    try:
        at = datetime.fromisoformat(said) if isinstance(said, str) else None
        return at.astimezone(UTC) if at is not None and at.tzinfo is not None else None
    except (ValueError, OverflowError):
        return None


def now_us() -> int:
    """Microseconds since 1970."""
    return time.time_ns() // 1000


def from_us(us: int) -> datetime:
    """An aware UTC datetime from microseconds since 1970, exact."""
    return _EPOCH + timedelta(microseconds=us)


@dataclass(frozen=True, slots=True)
class Board:
    """A category; `id` is its slug. The roles are the lowest ones that may read, post and command here."""

    id: str
    name: str
    description: str = ""
    read_role: Role = Role.GUEST
    post_role: Role = Role.MEMBER
    command_role: Role = Role.OPERATOR


@dataclass(frozen=True, slots=True)
class Topic:
    """A thread without its posts; `posts` counts those that are not removed, `last_post_id` may be removed."""

    id: str
    board_id: str
    title: str
    author: Account
    created_at: datetime
    last_post_at: datetime
    posts: int
    locked: bool = False
    tags: tuple[str, ...] = ()
    last_post_id: str = ""

    @property
    def path(self) -> str:
        return f"/t/{self.id}"


@dataclass(frozen=True, slots=True)
class Image:
    """A picture that was uploaded; `media_type` is image/jpeg, png, webp or gif."""

    id: str
    width: int
    height: int
    media_type: str = "image/jpeg"

    @property
    def path(self) -> str:
        return f"/images/{self.id}"

    @property
    def moving(self) -> bool:
        """Whether it may be a recording."""
        return self.media_type in ("image/webp", "image/gif")

    @property
    def shrinks(self) -> bool:
        """Whether pages show a smaller version."""
        return not self.moving and max(self.width, self.height) > SMALL

    @property
    def thumb(self) -> str:
        """The path of a still picture for lists."""
        return f"{self.path}/thumb"

    @property
    def small(self) -> str:
        """The path of what pages show: a smaller version of a large picture."""
        return f"{self.path}/small" if self.shrinks else self.path


@dataclass(frozen=True, slots=True)
class StoredPost:
    """A post as the board stores it; `model.Post` is a post as a forum delivers it.

    `html` is safe to put into a page as it is. Of a removed post `raw`, `html`, images and card are empty. `card` is
    the state of a command as the robot's agent sent it (fields of `model.StatusCard`).
    """

    id: str
    topic_id: str
    board_id: str
    author: Account
    raw: str
    html: str
    version: int
    created_at: datetime
    edited_at: datetime | None = None
    removed: bool = False
    mentions: tuple[str, ...] = ()
    reply_to: str | None = None
    key: str | None = None
    images: tuple[Image, ...] = ()
    card: Mapping[str, Any] | None = None

    @property
    def path(self) -> str:
        """Permalink: redirects to the page of the topic that shows the post."""
        return f"/p/{self.id}"


@dataclass(frozen=True, slots=True)
class Version:
    """An earlier text of a post: what it was until `until`."""

    version: int
    raw: str
    until: datetime


@dataclass(frozen=True, slots=True)
class StoredEvent:
    """An event, in order. `post` is the post as it is now, not as it was then."""

    id: str
    kind: EventKind
    at: datetime
    post: StoredPost | None = None
    robot: str | None = None
    account: Account | None = None


@dataclass(frozen=True, slots=True)
class Written:
    """A written post; `created` is False if its key was used before, with the earlier post."""

    topic: Topic
    post: StoredPost
    created: bool = True
