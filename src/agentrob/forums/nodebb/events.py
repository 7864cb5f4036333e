"""Derive events from the latest posts of a NodeBB, which keeps no list of events.

A `ChangeTracker` compares the latest posts with what it saw before and records new, edited and missing ones. Event
ids are `<newest post>.<its time>.<edits known until>.<number>`: a tracker that has the event resumes after it;
another one (after a restart) finds from the first three parts what was written and edited since. It cannot find posts
removed in the meantime; whoever acts on a post reads it again first.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from agentrob.errors import ForumNotFound
from agentrob.forums.protocol import Event
from agentrob.forums.unreadable_posts import PostRetries
from agentrob.model import EventKind, Post

_ID = re.compile(r"(\d{1,15})\.(\d{1,15})\.(\d{1,15})\.(\d{1,15})")
#: Pages of latest posts that are watched for edits: the first at each look, the others at every fourth.
WATCHED_PAGES = 3
SELDOM = 4
#: The most pages to read for catching up, and the most events to keep.
MOST_PAGES = 50
MOST_EVENTS = 2_000

Summary = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Source:
    """The forum, as needed here: a page of latest posts, newest first; one current post (`ForumNotFound` if deleted);
    the stored fields of a post; the forum's clock."""

    recent: Callable[[int], Awaitable[Sequence[Summary]]]
    post: Callable[[str], Awaitable[Post]]
    stored: Callable[[str], Awaitable[Summary]]
    clock: Callable[[], datetime]


class ChangeTracker:
    """Events of one forum, as seen by one account."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._seen: dict[int, tuple[object, ...]] = {}
        self._gone: set[int] = set()
        self._events: list[Event] = []
        self._first = ""
        self._newest = (0, 0)
        self._floor = 0
        self._edited_ms = 0
        self._number = 0
        self._looks = 0
        self._failing = PostRetries()
        self._lock = asyncio.Lock()

    async def newest(self) -> str:
        """Return the id of the newest event; later events come after it."""
        async with self._lock:
            await self._look()
            return self._events[-1].id if self._events else self._first

    async def after(self, event_id: str, limit: int) -> tuple[Event, ...]:
        """Return the events after one. Raises `ForumNotFound` if it is not of this forum."""
        async with self._lock:
            if not self._knows(event_id):
                await self._begin_at(event_id)
            await self._look()
            ids = [e.id for e in self._events]
            start = ids.index(event_id) + 1 if event_id in ids else 0
            return tuple(self._events[start : start + limit])

    def _knows(self, event_id: str) -> bool:
        return bool(self._first) and (event_id == self._first or any(e.id == event_id for e in self._events))

    # ---------------------------------------------------------------- beginning
    async def _begin_at(self, event_id: str) -> None:
        """Resume after an event of another tracker, for example one from before a restart."""
        latest = await self._source.recent(1)
        found = _ID.fullmatch(event_id)
        if found is None:
            raise ForumNotFound(f"there is no event {event_id!r}")
        pid, written_ms, edited_ms, _ = (int(part) for part in found.groups())
        if pid and int((await self._source.stored(str(pid)))["timestamp"]) != written_ms:
            raise ForumNotFound(f"event {event_id} is of another forum: its post {pid} was written at another time")
        if not pid and not latest and edited_ms:
            raise ForumNotFound(f"event {event_id} is of another forum")
        self._seen, self._gone, self._events, self._first = {}, set(), [], event_id
        self._newest, self._edited_ms = (pid, written_ms), edited_ms
        pages = await self._pages(until=pid, at_least=WATCHED_PAGES)
        self._floor = pid + 1
        for number in sorted(n for n in pages if n <= pid):
            self._seen[number] = _fingerprint(pages[number])
            await self._failing.read(number, self._note_if_edited, edited_ms)

    async def _note_if_edited(self, number: int, since_ms: int) -> None:
        with contextlib.suppress(ForumNotFound):
            if int((await self._source.stored(str(number))).get("edited") or 0) > since_ms:
                await self._note_change(number)

    async def _pages(self, until: int, at_least: int) -> dict[int, Summary]:
        """Yield latest posts, back to a known one."""
        found: dict[int, Summary] = {}
        for page in range(1, MOST_PAGES + 1):
            summaries = await self._source.recent(page)
            found.update((int(s["pid"]), s) for s in summaries)
            if not summaries or (page >= at_least and min(found) <= until):
                break
        return found

    # ---------------------------------------------------------------- looking
    async def _look(self) -> None:
        seldom = self._looks % SELDOM == 0
        self._looks += 1
        if not self._first:
            await self._look_first()
            return
        found = await self._pages(self._newest[0], WATCHED_PAGES if seldom else 1)
        for number in sorted(set(found) - set(self._seen)):
            if number < self._floor:  # older than all watched posts; it is listed because newer ones were removed
                self._seen[number] = _fingerprint(found[number])
            else:
                await self._failing.read(number, self._note_new, found[number])
        for number in sorted(set(found) & set(self._seen)):
            changed = _fingerprint(found[number]) != self._seen[number]
            if changed and await self._failing.read(number, self._note_change):
                self._seen[number] = _fingerprint(found[number])
        oldest = min(found, default=0)
        for number in [n for n in self._seen if n >= oldest and n not in found and n not in self._gone]:
            await self._failing.read(number, self._note_change)
        self._forget()

    async def _look_first(self) -> None:
        found = await self._pages(until=2**53, at_least=WATCHED_PAGES)
        self._seen = {number: _fingerprint(summary) for number, summary in found.items()}
        if found:
            newest = max(found)
            written_ms = found[newest].get("timestamp")
            self._newest, self._floor = (newest, written_ms if type(written_ms) is int else 0), newest + 1
        self._edited_ms = int(self._source.clock().timestamp() * 1000)
        self._first = self._next_id()

    async def _note_new(self, number: int, summary: Summary) -> None:
        try:
            post = await self._source.post(str(number))
        except ForumNotFound:
            return  # removed already; if it is restored it counts as new
        self._seen[number] = _fingerprint(summary)
        if number > self._newest[0]:
            self._newest = number, int(summary["timestamp"])
        if post.removed:
            self._gone.add(number)
            return
        self._append(EventKind.POST_CREATED, post, post.created_at)

    async def _note_change(self, number: int) -> None:
        """Record whether a post was edited, removed or restored."""
        try:
            post = await self._source.post(str(number))
        except ForumNotFound:
            self._gone.add(number)
            return
        if post.removed:
            if number not in self._gone:
                self._gone.add(number)
                self._append(EventKind.POST_REMOVED, post, self._source.clock())
            return
        if number in self._gone or post.edited_at is not None:
            self._gone.discard(number)
            self._append(EventKind.POST_EDITED, post, post.edited_at or self._source.clock())

    def _append(self, kind: EventKind, post: Post, at: datetime) -> None:
        self._edited_ms = max(self._edited_ms, int((post.edited_at or post.created_at).timestamp() * 1000))
        self._events.append(Event(self._next_id(), kind, at.astimezone(UTC), post=post))

    def _next_id(self) -> str:
        pid, written_ms = self._newest
        self._number += 1
        return f"{pid}.{written_ms}.{self._edited_ms}.{self._number}"

    def _forget(self) -> None:
        """Keep the watched posts and some older ones."""
        if len(self._events) > MOST_EVENTS:
            dropped = self._events[: -MOST_EVENTS // 2]
            self._first, self._events = dropped[-1].id, self._events[-MOST_EVENTS // 2 :]
        if len(self._seen) > 40 * WATCHED_PAGES:
            kept = sorted(self._seen)[-20 * WATCHED_PAGES :]
            self._seen = {number: self._seen[number] for number in kept}
            self._gone &= set(kept)
            self._floor = max(self._floor, kept[0])


def _fingerprint(summary: Summary) -> tuple[object, ...]:
    """Return the fields by which a change of a post is noticed."""
    return str(summary.get("content")), bool(summary.get("deleted")), str(summary.get("tid"))
