"""Reconcile a new journal with the forum: find earlier posts, and close claims that the journal does not know."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from dataclasses import replace
from datetime import datetime
from functools import partial

from agentrob.agent.reporting.status_post import left_open, retry_until_answered
from agentrob.agent.store.journal import Journal
from agentrob.errors import ForumError, ForumNotFound
from agentrob.forums.protocol import BEFORE_ALL, Forum
from agentrob.language.messages.catalog import say
from agentrob.model import Account, CommandState, Post


async def recent_posts(forum: Forum, boards: Iterable[str], since: datetime) -> AsyncIterator[Post]:
    """Yield posts written after `since` in the most recently active topics, oldest first in each."""
    for board in boards:
        for topic in (await retry_until_answered(partial(forum.topics, board))).items:
            cursor: str | None = None
            while True:
                page = await retry_until_answered(partial(forum.posts, topic.id, cursor))
                for post in page.items:
                    if post.created_at > since:
                        yield post
                if (cursor := page.next) is None:
                    break


def is_open(post: Post, me: Account) -> bool:
    """Whether this is a status post of ours whose command has not ended."""
    return post.author.id == me.id and post.card is not None and not post.card.is_final and not post.removed


async def gap_after(forum: Forum, journal: Journal) -> tuple[datetime, datetime] | None:
    """For a forum that does not know our last event: the time span of the events that it no longer keeps. None if the
    forum was replaced or restored from a backup: it does not know our newest claim, or it still keeps events older than
    our last one."""
    heard_at, newest = await journal.get_time("cursor_at"), await journal.newest_claim()
    if heard_at is None or newest is None:
        return None
    claimed = await retry_until_answered(partial(forum.find, f"claim:{newest.command.key}"))
    trace_id = newest.command.trace_id
    if claimed is None or trace_id not in (claimed.raw, claimed.card.trace_id if claimed.card else ""):
        return None
    try:
        oldest = await retry_until_answered(partial(forum.changes, BEFORE_ALL, 1))
    except ForumNotFound:
        return None
    return (heard_at, oldest[0].at) if oldest and oldest[0].at > heard_at else None


async def close_unknown(
    forum: Forum, journal: Journal, statuses: Iterable[Post], moves: Callable[[str], Awaitable[bool]]
) -> None:
    """Close open status posts whose command this journal does not know, unless another agent of this account still
    works on them. Never raises a `ForumError`."""

    async def close(post: Post) -> None:
        with contextlib.suppress(ForumError):
            if post.card is not None and await left_open(forum, post, moves):
                card = replace(post.card, state=CommandState.INTERRUPTED, place=None, doing="", step=0, steps=0)
                await forum.edit(post.id, say("agent.interrupted.claim", "en"), card=card)

    unknown = [post for post in statuses if not (post.reply_to and await journal.knows(post.reply_to))]
    await asyncio.gather(*map(close, unknown))
