"""The embedded forum's memory: short synchronous reads on the event loop, writes through one thread that batches them.

Reads answer in well under a millisecond and may be called anywhere on the event loop's thread. Writes are awaited; each
becomes a job with a savepoint of its own, and every change is an event row in the same transaction. Everything raises
`BoardError` with the HTTP status that fits: 404 for what is not there, 503 when the database cannot be used now.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from agentrob.board.records import Board, Event, EventKind, Image, Page, Post, Topic, Version, Written
from agentrob.board.settings import BoardSettings
from agentrob.model import Account


class Store:
    """One open database. Made once per process by `server.create_app`; pages get it as `services(request).store`."""

    def __init__(self, settings: BoardSettings) -> None:
        raise NotImplementedError

    # ---------------------------------------------------------------- reads, synchronous
    def boards(self) -> tuple[Board, ...]:
        raise NotImplementedError

    def board(self, board_id: str) -> Board:
        raise NotImplementedError

    def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]:
        """Latest activity first."""
        raise NotImplementedError

    def latest(self, cursor: str | None = None, limit: int = 20) -> Page[Topic]:
        """Topics of all boards, latest activity first."""
        raise NotImplementedError

    def topic(self, topic_id: str) -> Topic:
        raise NotImplementedError

    def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]:
        """Oldest first, removed ones among them (empty). 404 when there is no such topic."""
        raise NotImplementedError

    def cursor_before(self, post_id: str, limit: int = 50) -> str | None:
        """The cursor of the page of `posts(limit=limit)` that shows this post; None for the first page."""
        raise NotImplementedError

    def post(self, post_id: str) -> Post:
        raise NotImplementedError

    def versions(self, post_id: str) -> tuple[Version, ...]:
        """Earlier texts, oldest first."""
        raise NotImplementedError

    def find(self, author: Account, key: str) -> Post | None:
        """The author's own post written under `key`."""
        raise NotImplementedError

    def account(self, name: str) -> Account | None:
        raise NotImplementedError

    def robots(self) -> tuple[Account, ...]:
        """All accounts of robot agents."""
        raise NotImplementedError

    def image(self, image_id: str) -> Image:
        raise NotImplementedError

    def newest_event_id(self) -> str:
        raise NotImplementedError

    def events(self, after: str, limit: int = 100, topic_id: str | None = None) -> tuple[Event, ...]:
        raise NotImplementedError

    # ---------------------------------------------------------------- writes, awaited
    async def create_topic(
        self,
        author: Account,
        board_id: str,
        title: str,
        body: str,
        *,
        key: str | None = None,
        images: Sequence[str] = (),
    ) -> Written:
        raise NotImplementedError

    async def reply(
        self,
        author: Account,
        topic_id: str,
        body: str,
        *,
        key: str | None = None,
        reply_to: str | None = None,
        images: Sequence[str] = (),
        card: Mapping[str, Any] | None = None,
    ) -> Written:
        raise NotImplementedError

    async def edit(
        self,
        editor: Account,
        post_id: str,
        body: str,
        *,
        key: str | None = None,
        images: Sequence[str] = (),
        card: Mapping[str, Any] | Literal["keep"] | None = "keep",
    ) -> Post:
        """Replace the text; images given are added; the card stays unless given. Only the author may (403)."""
        raise NotImplementedError

    async def remove(self, by: Account, post_id: str) -> Post:
        """Hide a post for everybody; its author and admins may (403). Again does nothing."""
        raise NotImplementedError

    async def record(self, kind: EventKind, robot: str, by: Account | None, *, key: str | None = None) -> Event:
        """A robot event: stop, reset, watch."""
        raise NotImplementedError
