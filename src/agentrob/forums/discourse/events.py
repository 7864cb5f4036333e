"""Derive events from a Discourse's lists of posts; the message bus only says when to look.

Discourse has no list of changes. The newest posts of the site are compared with what was known before: new, edited
and missing posts become events. Content of bus messages is not trusted.

An event's id is a watermark that another process can resume from: the newest post, the time until which everything
was delivered, and two posts that identify the forum. Posts *removed* between two processes are not reported later;
whoever acts on a post reads it again first.
"""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import partial
from itertools import islice
from typing import Any, Protocol

import structlog

from agentrob.errors import ForumMalformed, ForumNotFound
from agentrob.forums.protocol import Event
from agentrob.forums.unreadable_posts import PostRetries
from agentrob.model import EventKind, Post

#: Posts per page of `/posts.json`; the most pages of the last minutes' posts to compare.
PAGE = 50
_RECENT = timedelta(minutes=15)
_RECENT_PAGES, _MISSED_PAGES = 4, 20
_KEPT_POSTS, _KEPT_EVENTS, _TOPICS = 400, 5_000, 30
RawPost = Mapping[str, Any]
_log = structlog.get_logger()


class Source(Protocol):
    """The forum, as needed for watching."""

    async def newest(self, before: int | None) -> Sequence[RawPost]:
        """Return a page of posts, newest first, with ids below `before`."""
        ...

    async def one(self, post_id: int) -> RawPost | None:
        """Return a post, or None if it is deleted or not visible to us."""
        ...

    async def build(self, raw: RawPost) -> Post: ...

    def clock(self) -> datetime:
        """Return the forum's estimated time."""
        ...


@dataclass(slots=True)
class _Seen:
    stamp: str
    created_ms: int
    post: Post
    gone: bool = False
    listed: bool = True


@dataclass(frozen=True, slots=True)
class Watermark:
    """An event's id: the newest post and the time until which everything was delivered; `anchor` is an older post."""

    newest: int
    newest_ms: int
    anchor: int
    anchor_ms: int
    at_ms: int
    number: int

    def __str__(self) -> str:
        return "-".join(map(str, (self.newest, self.newest_ms, self.anchor, self.anchor_ms, self.at_ms, self.number)))

    @classmethod
    def parse(cls, text: str) -> Watermark:
        parts = text.split("-")
        if len(parts) != 6 or not all(p.isascii() and p.isdigit() and len(p) < 20 for p in parts):
            raise ForumNotFound(f"{text!r} is not an event of this forum")
        return cls(*map(int, parts))


class ChangeTracker:
    """All changes seen by one process. Calls of several tasks run one after another."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._seen: dict[int, _Seen] = {}
        self._log: list[Event] = []
        self._dropped = 0
        self._places: dict[str, int] = {}
        self._floor: int | None = None
        self._newest = (0, 0)
        #: The latest time of a post; not the forum's clock, which has whole seconds.
        self._until_ms = 0
        self._count = 0
        self._failing = PostRetries()
        self._turn = asyncio.Lock()

    async def now(self) -> tuple[str, datetime]:
        """Return the id of the newest event and the forum's clock."""
        async with self._turn:
            await self._look(())
            if self._log:
                return self._log[-1].id, self._source.clock()
            beginning = str(self._mark())
            self._places[beginning] = 0
            return beginning, self._source.clock()

    async def changes(self, after: str, limit: int = 100, hints: Iterable[int] = ()) -> tuple[Event, ...]:
        """Return events after one. `hints` may have changed but are too old for the list of newest posts."""
        async with self._turn:
            await self._look(hints)
            mark = Watermark.parse(after)
            if (place := self._places.get(after)) is not None:
                return tuple(self._log[max(0, place - self._dropped) :][:limit])
            return (await self._missed(mark))[:limit]

    def topics(self) -> tuple[str, ...]:
        """Return the recently active threads."""
        newest = sorted(self._seen, reverse=True)
        return tuple(islice(dict.fromkeys(self._seen[n].post.topic_id for n in newest), _TOPICS))

    def heartbeat(self) -> Event:
        """Return a heartbeat; its id is empty."""
        return Event("", EventKind.HEARTBEAT, self._source.clock())

    def last_known(self, post_id: int) -> Post | None:
        """Return a post as it was before it was removed."""
        seen = self._seen.get(post_id)
        return seen.post if seen else None

    # ---------------------------------------------------------------- looking
    async def _look(self, hints: Iterable[int]) -> None:
        """Compare the newest posts with the known ones and record changes. A failed look is repeated next time."""
        first = self._floor is None
        window = await self._read()
        if first:
            self._floor = min(window, default=0)
        for _, post_id in sorted((self._changed_at(n, raw), n) for n, raw in window.items()):
            await self._failing.read(post_id, partial(self._compare, silent=first), window[post_id])
        oldest = min(window, default=0)
        vanished = [n for n, s in self._seen.items() if n >= oldest and n not in window and s.listed and not s.gone]
        for post_id in sorted({*vanished, *(n for n in hints if n not in window and n <= self._newest[0])}):
            await self._failing.read(post_id, self._look_at)
        self._forget()

    async def _look_at(self, post_id: int) -> None:
        await self._compare(post_id, await self._source.one(post_id), listed=False)

    async def _read(self) -> dict[int, RawPost]:
        """Read pages of newest posts, back to the last known post and over the last minutes."""
        found: dict[int, RawPost] = {}
        since = self._source.clock() - _RECENT
        known = self._newest[0]
        for number in range(_MISSED_PAGES):
            page = await self._source.newest(min(found) if found else None)
            found |= {int(p["id"]): p for p in page if _readable(p)}
            if len(page) < PAGE or (known and min(found) > known):
                if len(page) < PAGE:
                    break
                continue
            if number + 1 >= _RECENT_PAGES or _time(page[-1]["created_at"]) < since:
                break
        return found

    def _changed_at(self, post_id: int, raw: RawPost) -> datetime:
        """Return when a known post was edited, or a new one written."""
        return _time(raw["updated_at" if post_id in self._seen else "created_at"])

    async def _compare(self, post_id: int, raw: RawPost | None, *, silent: bool = False, listed: bool = True) -> None:
        seen = self._seen.get(post_id)
        if raw is None or removed(raw):
            if seen is not None and not seen.gone:
                seen.gone = True
                gone = replace(
                    seen.post, raw="", removed=True, images=(), mentions=(), card=None, rendering_differs=False
                )
                self._note(EventKind.POST_REMOVED, gone, self._source.clock())
            return
        stamp = _stamp(raw)
        if seen is not None and seen.stamp == stamp and not seen.gone:
            seen.listed = listed
            return
        post = await self._source.build(raw)
        created_ms = _ms(post.created_at)
        self._seen[post_id] = _Seen(stamp, created_ms, post, listed=listed)
        self._newest = max(self._newest, (post_id, created_ms))
        self._until_ms = max(self._until_ms, created_ms, _ms(post.edited_at) if post.edited_at else 0)
        if silent:
            return
        if seen is not None or (not listed and post.version > 1):
            self._note(EventKind.POST_EDITED, post, post.edited_at or self._source.clock())
        elif listed and post_id >= (self._floor or 0):
            # Also below the newest: posts written at the same time may appear out of order.
            self._note(EventKind.POST_CREATED, post, post.created_at)

    def _note(self, kind: EventKind, post: Post, at: datetime) -> None:
        event = Event(str(self._mark()), kind, at, post=post)
        self._log.append(event)
        self._places[event.id] = self._dropped + len(self._log)

    def _mark(self) -> Watermark:
        self._count += 1
        anchors = sorted(self._seen)[-5:-1]
        anchor = (anchors[0], self._seen[anchors[0]].created_ms) if anchors else (0, 0)
        return Watermark(*self._newest, *anchor, self._until_ms, self._count)

    def _forget(self) -> None:
        for post_id in sorted(self._seen)[:-_KEPT_POSTS]:
            del self._seen[post_id]
            self._floor = max(self._floor or 0, post_id + 1)
        if (excess := len(self._log) - _KEPT_EVENTS) > 0:
            del self._log[:excess]
            self._dropped += excess
        if len(self._places) > 2 * _KEPT_EVENTS:
            self._places = {k: v for k, v in self._places.items() if v >= self._dropped}

    # ---------------------------------------------------------------- after another process
    async def _missed(self, mark: Watermark) -> tuple[Event, ...]:
        """Return the events after another process's watermark: posts written or edited since."""
        posts = {n: s.post for n, s in self._seen.items() if not s.gone}
        while posts and min(posts) > mark.newest and len(posts) < PAGE * _MISSED_PAGES:
            page = await self._source.newest(min(posts))
            for raw in filter(_readable, page):
                with suppress(ForumMalformed):
                    posts[int(raw["id"])] = await self._source.build(raw)
            if len(page) < PAGE:
                break
        await self._recognise(mark, posts)
        after = datetime.fromtimestamp(mark.at_ms / 1000, UTC)
        found: list[tuple[datetime, int, EventKind, Post]] = []
        for number, post in posts.items():
            if number > mark.newest or post.created_at > after + timedelta(milliseconds=1):
                found.append((post.created_at, number, EventKind.POST_CREATED, post))
            elif post.edited_at is not None and post.edited_at > after + timedelta(milliseconds=1):
                found.append((post.edited_at, number, EventKind.POST_EDITED, post))
        events, newest = [], (mark.newest, mark.newest_ms)
        for at, number, kind, post in sorted(found, key=lambda f: f[:2]):
            if kind is EventKind.POST_CREATED:
                newest = max(newest, (number, _ms(post.created_at)))
            at_ms = max(mark.at_ms, _ms(at))
            reached = replace(mark, newest=newest[0], newest_ms=newest[1], at_ms=at_ms, number=number)
            events.append(Event(str(reached), kind, at, post=post))
        gone = (e for e in self._log if e.kind is EventKind.POST_REMOVED and _ms(e.at) > mark.at_ms)
        return tuple(sorted((*events, *gone), key=lambda e: e.at))

    async def _recognise(self, mark: Watermark, posts: Mapping[int, Post]) -> None:
        """Raise `ForumNotFound` if this is another forum, or one restored to before the watermark."""
        missing = []
        for number, created_ms in ((mark.newest, mark.newest_ms), (mark.anchor, mark.anchor_ms)):
            if number == 0:
                continue
            known = posts[number].created_at if number in posts else None
            if known is None and (raw := await self._source.one(number)) is not None:
                known = _time(raw["created_at"])
            if known is None:
                missing.append(number)
            elif _ms(known) != created_ms:
                raise ForumNotFound("that event is of another forum, or the forum was restored from a backup")
        newest = max(posts, default=0)
        if mark.newest in missing and newest < mark.newest and (mark.anchor in missing or mark.anchor == 0):
            raise ForumNotFound(f"that event is not of this forum, which has no post {mark.newest}")


def removed(raw: RawPost) -> bool:
    """Return whether a post was deleted by a moderator (`deleted_at`) or its author (`user_deleted`), or hidden by
    flags."""
    return bool(raw.get("deleted_at") or raw.get("user_deleted") or raw.get("hidden"))


def _readable(raw: RawPost) -> bool:
    """Return whether a listed post has the necessary fields; one that has not does not block the others."""
    try:
        return type(raw["id"]) is int and all(_time(raw[at]) for at in ("created_at", "updated_at"))
    except Exception as e:
        _log.warning("a listed post is not as Discourse tells posts", error=repr(e)[:200])
        return False


def _stamp(raw: RawPost | None) -> str:
    """Return what changes with each edit. An edit within the grace period keeps the version, but not the text."""
    if raw is None:
        return ""
    version = f"{raw.get('version')} {raw.get('raw')}"
    return hashlib.sha256(version.encode("utf-8", "replace")).hexdigest()


def _time(text: str) -> datetime:
    return datetime.fromisoformat(text).astimezone(UTC)


def _ms(at: datetime) -> int:
    return round(at.timestamp() * 1000)
