"""One status post per command, edited in place: progress never waits for the forum, and the end is always written.

Two agents of one account may process the same post, by mistake or after a crash. The first post under the claim's key
is the claim, and only its owner shows progress and writes the end. Another agent writes an end only if the owner does
not (`left_open`). That end is a guess, a card without steps, and is replaced by a measured one.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import structlog

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound, ForumUnreachable
from agentrob.forums.protocol import Forum, KeyedEdits, Written
from agentrob.model import Command, CommandState, Post, StatusCard

T = TypeVar("T")
#: The maximum number of edits of a post on a forum that limits them; the last one is reserved for the end.
MAX_EDITS = 3
_BACKOFF_S = (0.2, 30.0)
#: A denial (401, 403) may be temporary, so the write is retried with these delays (first, longest): for a week if it
#: must arrive, for a minute if it is soon outdated.
_DENIED_S = (0.5, 30.0)
POST_WITHIN_S, SOON_S = 7 * 86400.0, 60.0
#: The most writes that wait until our account may write again; further ones are left to the next start.
MOST_DENIED = 1000
#: A status post is abandoned if it has not changed for this long and its command does not move.
LEFT_S, _LOOK_S = 5.0, 0.5
#: How long the end waits for an earlier edit of the status post.
EDIT_S = 10.0
#: After this many failures (about 50 s) the text is posted without pictures, in case they cause the failures.
PICTURE_TRIES = 9
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Shown:
    """The content of a status post: Markdown and the card beside it."""

    text: str
    card: StatusCard


async def nothing() -> None:
    """Do nothing."""


class StatusPost:
    """The status post of one command. Its first post is the claim (law 6), under the key `claim:<post>`."""

    def __init__(self, forum: Forum, command: Command) -> None:
        self._forum = forum
        self._command = command
        limited = forum.max_edits is not None
        self._edits_left = min(MAX_EDITS, forum.max_edits or 0) if limited else None
        self._limited = limited
        self._post_id: str | None = None
        self._asks_ids: set[str] = set()
        self._next: Shown | None = None
        self._last: Shown | None = None
        self._sending: asyncio.Task[None] | None = None
        self._editing: asyncio.Task[Post] | None = None
        self._shows = True

    @property
    def post_id(self) -> str | None:
        """Return the id of the status post, once it is written."""
        return self._post_id

    @property
    def limited(self) -> bool:
        """Return whether the forum limits edits, so that nothing is added to the report."""
        return self._limited

    @property
    def posts(self) -> frozenset[str]:
        """Return the agent's posts about this command; a reply to one of them refers to the command."""
        return frozenset(self._asks_ids if self._post_id is None else {self._post_id, *self._asks_ids})

    @property
    def shown(self) -> StatusCard | None:
        """Return the newest state, which the forum may not show yet."""
        newest = self._next or self._last
        return newest.card if newest else None

    async def claim(self, shown: Shown) -> Written:
        """Write the first status, trying until the forum answers.

        If `created` is False, the command was claimed before, and nothing is shown unless `adopt` takes over the claim.
        """
        key = f"claim:{self._command.key}"
        written = await retry_until_answered(
            lambda: self._forum.reply(
                self._command.topic_id, shown.text, key=key, reply_to=self._command.post_id, card=shown.card
            )
        )
        self._post_id = written.post.id
        self._last = shown
        self._shows = written.created
        return written

    def adopt(self, claimed: Post) -> None:
        """Continue an earlier claim of this agent. If that has ended, nothing more is shown."""
        self._shows = not is_final(claimed.card)

    def show(self, shown: Shown) -> None:
        """Show this as soon as the forum allows, instead of anything not shown yet. Ignored without the claim."""
        if shown == self._last or not self._shows:
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
                await self._edit(self._post_id, shown)
                self._last = shown
            except ForumError as e:
                _log.info("status not shown", post=self._command.post_id, error=str(e))

    async def _edit(self, post_id: str, shown: Shown, images: Sequence[bytes] = ()) -> Post:
        """Edit the status post, once the edit before it is answered: an edit whose caller was cancelled reaches the
        forum all the same, and must not replace a newer one."""
        while self._editing is not None and not self._editing.done():
            await asyncio.wait({self._editing})
        self._editing = asyncio.create_task(self._forum.edit(post_id, shown.text, images=images, card=shown.card))
        self._editing.add_done_callback(_retrieved)
        return await asyncio.shield(self._editing)

    async def ask(self, shown: Shown) -> None:
        """Write a question to people, trying until it is posted; as a separate reply if edits are limited. May be
        cancelled at any time: what is shown afterwards comes afterwards."""
        await self._write_question(shown, (), "waits", shown)

    async def ask_with(self, shown: Shown, images: Sequence[bytes], added: Shown, key: str) -> Post:
        """Replace the question by a longer one with pictures; if edits are limited, write what was `added` as another
        reply, under `key`. Return the post that was written."""
        return await self._write_question(shown, images, key, added)

    async def _write_question(self, shown: Shown, images: Sequence[bytes], key: str, alone: Shown) -> Post:
        self._next = None
        if self._sending is not None:
            await asyncio.wait({self._sending})
        post_id, command = self._post_id, self._command
        if post_id is None or self._limited:

            async def reply(pictures: Sequence[bytes]) -> Written:
                return await self._forum.reply(
                    command.topic_id, alone.text, key=f"{key}:{command.key}", reply_to=command.post_id,
                    images=pictures, card=alone.card,
                )  # fmt: skip

            written = (await _illustrated(reply, images)).post
            self._asks_ids.add(written.id)
        else:
            before = len((await retry_until_answered(lambda: self._forum.post(post_id))).images) if images else 0

            async def edit(pictures: Sequence[bytes]) -> Post:
                there = pictures and len((await self._forum.post(post_id)).images) > before  # the answer was lost
                return await self._edit(post_id, shown, () if there else pictures)

            written = await retry_while_denied(lambda: _illustrated(edit, images), SOON_S)
        self._last = shown
        return written

    async def has_ended(self) -> bool:
        """Return whether the status post shows a final state. Never raises a `ForumError`."""
        if self._post_id is None:
            return False
        try:
            return is_final((await self._forum.post(self._post_id)).card)
        except ForumError:
            return False

    async def close(
        self,
        final: Shown,
        images: Sequence[bytes] = (),
        short: str = "",
        *,
        measured: bool = False,
        before: Callable[[], Awaitable[None]] = nothing,
    ) -> bool:
        """Write the end once, trying until the forum answers. Return whether the end on the forum is this agent's.

        An end that another agent wrote is kept, unless it was a guess and this one was `measured`. `before` is called
        just before the status post becomes the report.

        Raises `ForumDenied` if neither an edit nor a reply is allowed, which may be temporary (see
        `retry_while_denied`). If edits are limited, the report is a separate reply, and the status post shows `short`.
        """
        self._next = None
        self._shows = False
        if under_way := {task for task in (self._sending, self._editing) if task is not None and not task.done()}:
            _, late = await asyncio.wait(under_way, timeout=EDIT_S)
            for task in late:
                task.cancel()
        if self._post_id is not None and not self._limited:
            with contextlib.suppress(ForumError):  # removed, or no longer editable
                return await _illustrated(lambda pictures: self._post_final(final, pictures, measured, before), images)
        return await self._post_final_reply(final, images, short, measured)

    async def add(self, final: Shown, images: Sequence[bytes]) -> bool:
        """Edit the final post once to add a late picture, if the forum does not limit edits. Return whether it is
        there."""
        if self._post_id is None or self._limited:
            return False
        try:
            await self._forum.edit(self._post_id, final.text, images=images, card=final.card)
        except ForumError as e:
            _log.info("what came late is not shown", post=self._command.post_id, error=str(e))
            return False
        return True

    async def _post_final(
        self, final: Shown, images: Sequence[bytes], measured: bool, before: Callable[[], Awaitable[None]]
    ) -> bool:
        assert self._post_id is not None
        now = await self._forum.post(self._post_id)
        # The end may be written already (lost answer, crash); writing it again would add the pictures twice.
        if (card := now.card) is not None and is_final(card) and not (measured and _guessed(card)):
            return card.trace_id == final.card.trace_id
        await before()
        await self._edit_once(self._post_id, final, images)
        return True

    async def _edit_once(self, post_id: str, final: Shown, images: Sequence[bytes]) -> None:
        """Write the end at most once. An earlier attempt, perhaps from before a restart, may still be under way and
        report other times, so the key does not depend on the text."""
        if not isinstance(self._forum, KeyedEdits):
            await self._forum.edit(post_id, final.text, images=images, card=final.card)
            return
        key = "end:guess" if _guessed(final.card) else "end"
        now = await self._forum.edit_once(post_id, final.text, key=key, images=images, card=final.card)
        if now.card is not None and not is_final(now.card):  # a delayed status update has replaced it
            await self._forum.edit(post_id, final.text, images=images, card=final.card)

    async def _post_final_reply(self, final: Shown, images: Sequence[bytes], short: str, measured: bool) -> bool:
        command, ours = self._command, True

        async def reply(key: str, pictures: Sequence[bytes]) -> Written:
            return await self._forum.reply(
                command.topic_id, final.text, key=key, reply_to=command.post_id, images=pictures, card=final.card
            )

        try:
            written = await _illustrated(partial(reply, f"reply:{command.key}"), images)
            if not written.created and (card := written.post.card) is not None:
                ours = card.trace_id == final.card.trace_id
                if measured and _guessed(card):
                    await _illustrated(partial(reply, f"measured:{command.key}"), images)
                    ours = True
        except ForumDenied:
            raise
        except ForumError as e:
            _log.warning("final reply not posted", post=command.post_id, error=str(e))
            return True
        if ours and self._post_id is not None and (self._edits_left or not self._limited):
            with contextlib.suppress(ForumError):
                await self._forum.edit(self._post_id, short or final.text, card=final.card)
        return ours


def is_final(card: StatusCard | None) -> bool:
    """Return whether this card shows a final state."""
    return card is not None and card.is_final


def _guessed(card: StatusCard) -> bool:
    """Return whether an agent wrote this end without knowing the result."""
    return card.state == CommandState.INTERRUPTED and card.steps == 0


async def left_open(forum: Forum, post: Post, moves: Callable[[str], Awaitable[bool]]) -> bool:
    """Wait until an open status post shows a final state (False) or is abandoned (True).

    It is abandoned after `LEFT_S` without a change or a motion of its command, which is found by its trace id.
    """
    since_s = time.monotonic()
    while time.monotonic() - since_s < LEFT_S:
        try:
            now = await retry_until_answered(partial(forum.post, post.id))
        except ForumNotFound:
            return True
        if now.removed or is_final(now.card):
            return False
        changed = (now.raw, now.card) != (post.raw, post.card)
        if changed or (now.card is not None and await moves(now.card.trace_id)):
            post, since_s = now, time.monotonic()
        await asyncio.sleep(_LOOK_S)
    return True


async def _illustrated(write: Callable[[Sequence[bytes]], Awaitable[T]], images: Sequence[bytes]) -> T:
    """Write with pictures. If the forum rejects them, write without the animations, then without any picture."""
    still = tuple(image for image in images if not image.startswith(b"RIFF"))
    for pictures in dict.fromkeys((tuple(images), still)) if images else ():
        try:
            return await retry_until_answered(partial(write, pictures), PICTURE_TRIES)
        except ForumUnreachable as e:
            _log.warning("posted without pictures", error=str(e))
            break
        except ForumError as e:
            _log.warning("pictures not taken", count=len(pictures), error=str(e))
    return await retry_until_answered(lambda: write(()))


def _retrieved(edit: asyncio.Task[Post]) -> None:
    """Retrieve the error of an edit that nobody awaits, so that asyncio does not report it."""
    if not edit.cancelled():
        edit.exception()


async def retry_until_answered(write: Callable[[], Awaitable[T]], tries: float = math.inf) -> T:
    """Repeat a write that is safe to repeat until the forum answers, or `tries` times. Other errors are raised."""
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


async def retry_while_denied(
    write: Callable[[], Awaitable[T]],
    limit_s: float = POST_WITHIN_S,
    wait: Callable[[float], Awaitable[object]] = asyncio.sleep,
) -> T:
    """Repeat a write while the forum denies it, because the account may be suspended temporarily.

    Raises the denial after `limit_s`, and other errors at once.
    """
    wait_s, longest_s = _DENIED_S
    until_s = time.monotonic() + limit_s
    while True:
        try:
            return await write()
        except ForumDenied as e:
            if time.monotonic() >= until_s:
                raise
            _log.warning("the forum denies us a write, trying again", after_s=wait_s, error=str(e))
        await wait(wait_s)
        wait_s = min(longest_s, wait_s * 2)


class DeniedWrites:
    """Writes that the forum denies our account for now: they wait until it may write again."""

    def __init__(self) -> None:
        #: The tasks that wait.
        self.tasks: set[asyncio.Task[Any]] = set()

    async def when_allowed(
        self, write: Callable[[], Awaitable[T]], wait: Callable[[float], Awaitable[object]] = asyncio.sleep
    ) -> T:
        """Write as soon as our account may: a suspension can end. Raises `ForumDenied` if too many wait for that; the
        next start continues them."""
        task = asyncio.current_task()
        assert task is not None

        async def waits(seconds: float) -> None:
            self.tasks.add(task)
            await wait(seconds)

        try:
            return await retry_while_denied(write, POST_WITHIN_S if len(self.tasks) < MOST_DENIED else 0.0, waits)
        finally:
            self.tasks.discard(task)
