"""The state of a forum in memory, and the actions of moderators and failures on it."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from typing import Any

from agentrob.errors import ForumNotFound
from agentrob.forums.cards import card_by
from agentrob.forums.protocol import Board, Event, Topic
from agentrob.language.visible_text import mentions, visible_text
from agentrob.model import Account, AccountKind, EventKind, Post, Role
from agentrob.semantic.encoder import TextEncoder


@dataclass
class MemoryRecords:
    """Accounts, topics, posts and events; for the fields see `MemoryWorld`."""

    max_edits: int | None = None
    live: bool = True
    fastest_poll_s: float = 0.0
    clock_offset_s: float = 0.0
    limited_s: float = 0.0
    encoder: TextEncoder | None = None
    boards: dict[str, Board] = field(default_factory=lambda: {"robots": Board("robots", "Robots")})
    accounts: dict[str, Account] = field(default_factory=dict)
    topics: dict[str, Topic] = field(default_factory=dict)
    posts: dict[str, Post] = field(default_factory=dict)
    pictures: dict[str, bytes] = field(default_factory=dict)
    events: list[Event] = field(default_factory=list)
    robots: dict[str, dict[str, Any]] = field(default_factory=dict)
    frames: dict[str, bytes] = field(default_factory=dict)
    viewers: dict[str, int] = field(default_factory=dict)
    edits: set[tuple[str, str, str]] = field(default_factory=set)
    #: How many calls failed because it was not reachable.
    unanswered: int = 0
    _keys: dict[tuple[str, str], str] = field(default_factory=dict)
    _waiting: set[asyncio.Event] = field(default_factory=set)
    _reachable: bool = True

    def add_account(self, name: str, kind: AccountKind, role: Role, display_name: str = "") -> None:
        """Add an account unless it exists."""
        if name not in self.accounts:
            account = Account(f"a{len(self.accounts) + 1}", name, kind, role, display_name=display_name or name)
            self.accounts[name] = account

    def now(self) -> datetime:
        return datetime.now(UTC) + timedelta(seconds=self.clock_offset_s)

    # ---------------------------------------------------------------- what moderators and bad days do
    def suspend(self, name: str, suspended: bool = True) -> None:
        self.accounts[name] = replace(self.accounts[name], suspended=suspended)

    def set_role(self, name: str, role: Role) -> None:
        self.accounts[name] = replace(self.accounts[name], role=role)

    def remove(self, post_id: str) -> None:
        """Hide a post, like its author or a moderator."""
        post = replace(self.fresh(post_id), removed=True)
        self.posts[post_id] = post
        self.emit(EventKind.POST_REMOVED, post=post)

    def move(self, topic_id: str, board_id: str) -> None:
        """Move a topic to another board, like a moderator; there is no event for it."""
        self.topics[topic_id] = replace(self.topics[topic_id], board_id=board_id)
        for post in [p for p in self.posts.values() if p.topic_id == topic_id]:
            self.posts[post.id] = replace(post, board_id=board_id)

    def give(self, post_id: str, name: str) -> None:
        """Give a post to another account, as moderators of some forums can; there is no event for it."""
        self.posts[post_id] = replace(self.posts[post_id], author=self.accounts[name])

    def watch(self, robot: str, viewers: int) -> None:
        """Set the number of people who watch the robot's camera."""
        first = viewers > 0 and self.viewers.get(robot, 0) == 0
        self.viewers[robot] = viewers
        if first:
            self.emit(EventKind.ROBOT_WATCH, robot=robot)

    @property
    def reachable(self) -> bool:
        return self._reachable

    @reachable.setter
    def reachable(self, value: bool) -> None:
        self._reachable = value
        self._wake()

    # ---------------------------------------------------------------- inside
    def fresh(self, post_id: str) -> Post:
        """Return the post with its author's current account."""
        if post_id not in self.posts:
            raise ForumNotFound(f"there is no post {post_id}")
        post = self.posts[post_id]
        author = self.accounts[post.author.name]
        return post if post.author is author else replace(post, author=author)

    def written_under(self, name: str, key: str) -> Post | None:
        post_id = self._keys.get((name, key))
        return self.fresh(post_id) if post_id else None

    def add_post(self, topic: Topic, name: str, body: str, key: str, images: Sequence[bytes], **more: Any) -> Post:
        number = str(len(self.posts) + 1)
        more["card"] = card_by(self.accounts[name], more.get("card"))
        post = Post(
            number, topic.id, topic.board_id, self.accounts[name], body, self.now(), key=key,
            mentions=self.mentioned(body), url=f"{topic.url}#{number}", images=self.keep(number, images), **more,
        )  # fmt: skip
        self.posts[number] = post
        self._keys[name, key] = number
        self.emit(EventKind.POST_CREATED, post=post)
        return post

    def keep(self, post_id: str, images: Sequence[bytes]) -> tuple[str, ...]:
        names = tuple(f"memory:{post_id}/{len(self.pictures) + n}" for n in range(len(images)))
        self.pictures.update(zip(names, images, strict=True))
        return names

    def mentioned(self, body: str) -> tuple[str, ...]:
        return tuple(name for name in mentions(visible_text(body)) if name in self.accounts)

    def emit(self, kind: EventKind, **more: Any) -> None:
        self.events.append(Event(str(len(self.events) + 1), kind, self.now(), **more))
        self._wake()

    def after(self, event_id: str, limit: int) -> tuple[Event, ...]:
        start = int(event_id or 0) if event_id.isdecimal() or not event_id else -1
        if not 0 <= start <= len(self.events):
            raise ForumNotFound(f"there is no event {event_id}; the newest is {len(self.events)}")
        return tuple(self._delivered(e) for e in self.events[start : start + limit])

    def _delivered(self, event: Event) -> Event:
        """Return the event with its post as it is at delivery, like the board."""
        return replace(event, post=self.fresh(event.post.id)) if event.post else event

    def _wake(self) -> None:
        for waiting in self._waiting:
            waiting.set()

    async def wait(self, seconds: float) -> bool:
        """Wait until something happens; return False if nothing does in time."""
        waiting = asyncio.Event()
        self._waiting.add(waiting)
        try:
            async with asyncio.timeout(seconds):  # wait_for of Python 3.11 may swallow a cancellation
                await waiting.wait()
        except TimeoutError:
            return False
        finally:
            self._waiting.discard(waiting)
        return True
