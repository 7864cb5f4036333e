"""One status post per command, edited in place: progress never waits for the forum, the end is told for certain."""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import structlog

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound, ForumUnreachable
from agentrob.forums.forum import Forum, Written
from agentrob.model import Command, StatusCard

T = TypeVar("T")
#: Where a forum limits edits, at most so many are used, the last of them for the end.
MAX_EDITS = 3
_BACKOFF_S = (0.2, 30.0)
#: A forum that fails so often (for some 50 s) with pictures is told without: it may be they that it cannot bear.
PICTURE_TRIES = 9
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Shown:
    """What a status post shows: Markdown and the card beside it."""

    text: str
    card: StatusCard


class StatusLine:
    """The status post of one command. Its first post is the claim (law 6), under the key `claim:<post>`."""

    def __init__(self, forum: Forum, command: Command) -> None:
        self._forum = forum
        self._command = command
        limited = forum.max_edits is not None
        self._edits_left = min(MAX_EDITS, forum.max_edits or 0) if limited else None
        self._limited = limited
        self._post_id: str | None = None
        self._asks_id: str | None = None
        self._next: Shown | None = None
        self._last: Shown | None = None
        self._sending: asyncio.Task[None] | None = None

    @property
    def post_id(self) -> str | None:
        """The status post, once it is there."""
        return self._post_id

    @property
    def posts(self) -> frozenset[str]:
        """Every post of ours by which somebody may answer this command."""
        return frozenset(post_id for post_id in (self._post_id, self._asks_id) if post_id is not None)

    @property
    def shown(self) -> StatusCard | None:
        """The newest state, which the forum may not show yet."""
        newest = self._next or self._last
        return newest.card if newest else None

    async def claim(self, shown: Shown) -> Written:
        """Put the first status there, trying until the forum answers. `created` False: somebody claimed it before."""
        key = f"claim:{self._command.post_id}"
        written = await insist(
            lambda: self._forum.reply(
                self._command.topic_id, shown.text, key=key, reply_to=self._command.post_id, card=shown.card
            )
        )
        self._post_id = written.post.id
        self._last = shown
        return written

    def show(self, shown: Shown) -> None:
        """Show this as soon as the forum allows; whatever was not shown yet is passed over."""
        if shown == self._last:
            return
        self._next = shown
        if self._sending is None or self._sending.done():
            self._sending = asyncio.create_task(self._send())

    async def _send(self) -> None:
        while (shown := self._next) is not None and self._post_id is not None:
            self._next = None
            if self._edits_left is not None:
                if self._edits_left <= 1:
                    return
                self._edits_left -= 1
            try:
                await self._forum.edit(self._post_id, shown.text, card=shown.card)
                self._last = shown
            except ForumError as e:
                _log.info("status not shown", post=self._command.post_id, error=str(e))

    async def ask(self, shown: Shown) -> None:
        """Put something there that people answer, trying until it is there.

        Where edits are limited it is a reply of its own.
        """
        self._next = None
        if self._sending is not None:
            await asyncio.wait({self._sending})
        post_id, command = self._post_id, self._command
        if post_id is not None and not self._limited:
            await insist(lambda: self._forum.edit(post_id, shown.text, card=shown.card))
        else:
            key = f"waits:{command.post_id}"
            written = await insist(
                lambda: self._forum.reply(
                    command.topic_id, shown.text, key=key, reply_to=command.post_id, card=shown.card
                )
            )
            self._asks_id = written.post.id
        self._last = shown

    async def close(self, final: Shown, images: Sequence[bytes] = (), short: str = "") -> None:
        """Tell the end, trying until it is told, once: a post that already tells an end is left alone.

        Where edits are limited the report is a reply of its own, and the status post says only `short`.
        """
        self._next = None
        if self._sending is not None:
            await asyncio.wait({self._sending}, timeout=10.0)
        if self._post_id is not None and not self._limited:
            with contextlib.suppress(ForumDenied, ForumNotFound):
                await _illustrated(lambda pictures: self._tell(final, pictures), images)
                return
        await self._tell_in_reply(final, images, short)

    async def add(self, final: Shown, images: Sequence[bytes]) -> None:
        """Put something that came too late for the end beside it, once, where the forum does not count edits."""
        if self._post_id is None or self._limited:
            return
        try:
            await self._forum.edit(self._post_id, final.text, images=images, card=final.card)
        except ForumError as e:
            _log.info("what came late is not shown", post=self._command.post_id, error=str(e))

    async def _tell(self, final: Shown, images: Sequence[bytes]) -> None:
        assert self._post_id is not None
        now = await self._forum.post(self._post_id)
        # A lost answer or a crash may have left the end told already; pictures would be added a second time.
        if now.card is None or now.card.state != final.card.state:
            await self._forum.edit(self._post_id, final.text, images=images, card=final.card)

    async def _tell_in_reply(self, final: Shown, images: Sequence[bytes], short: str) -> None:
        command = self._command
        key = f"reply:{command.post_id}"
        try:
            await _illustrated(
                lambda pictures: self._forum.reply(
                    command.topic_id, final.text, key=key, reply_to=command.post_id, images=pictures, card=final.card
                ),
                images,
            )
            if self._post_id is not None and self._edits_left:
                await self._forum.edit(self._post_id, short or final.text, card=final.card)
        except ForumError as e:
            _log.warning("final reply not told", post=command.post_id, error=str(e))


async def _illustrated(write: Callable[[Sequence[bytes]], Awaitable[T]], images: Sequence[bytes]) -> T:
    """Write with pictures; the words matter more, so where the forum does not take the pictures, without them: first
    without those that move, which not every forum knows."""
    still = tuple(image for image in images if not image.startswith(b"RIFF"))
    for pictures in dict.fromkeys((tuple(images), still)) if images else ():
        try:
            return await insist(partial(write, pictures), PICTURE_TRIES)
        except ForumUnreachable as e:
            _log.warning("told without pictures", error=str(e))
            break
        except ForumError as e:
            _log.warning("pictures not taken", count=len(pictures), error=str(e))
    return await insist(lambda: write(()))


async def insist(write: Callable[[], Awaitable[T]], tries: float = math.inf) -> T:
    """Repeat a write that is safe to repeat until the forum answers, or `tries` times. Other errors come through."""
    wait_s, longest_s = _BACKOFF_S
    while True:
        tries -= 1
        try:
            return await write()
        except ForumLimited as e:
            await asyncio.sleep(e.retry_after_s)
        except ForumUnreachable as e:
            if tries <= 0:
                raise
            _log.info("forum does not answer, trying again", after_s=wait_s, error=str(e))
            await asyncio.sleep(wait_s)
            wait_s = min(longest_s, wait_s * 2)
