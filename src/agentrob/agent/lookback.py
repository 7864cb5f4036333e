"""What an agent finds on the forum when its journal is new: posts that came before it, claims that nobody remembers."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from dataclasses import replace
from datetime import datetime

from agentrob.agent.journal import Journal
from agentrob.agent.sentences import say
from agentrob.agent.status import is_final, left_open
from agentrob.errors import ForumError
from agentrob.forums.forum import Forum
from agentrob.model import Account, Post


async def recent_posts(forum: Forum, boards: Iterable[str], since: datetime) -> AsyncIterator[Post]:
    """Posts written after `since` in the threads that were active last, oldest first in each."""
    for board in boards:
        for topic in (await forum.topics(board)).items:
            cursor: str | None = None
            while True:
                page = await forum.posts(topic.id, cursor)
                for post in page.items:
                    if post.created_at > since:
                        yield post
                if (cursor := page.next) is None:
                    break


def is_open(post: Post, me: Account) -> bool:
    """Whether this is a status post of ours that promises more to come."""
    return post.author.id == me.id and post.card is not None and not is_final(post.card) and not post.removed


async def close_unknown(
    forum: Forum, journal: Journal, statuses: Iterable[Post], moves: Callable[[str], Awaitable[bool]]
) -> None:
    """End open status posts whose command this journal does not know: what they promised does not come any more. Not
    those that another agent of this account still brings to their end. Never raises a `ForumError`."""

    async def close(post: Post) -> None:
        with contextlib.suppress(ForumError):
            if post.card is not None and await left_open(forum, post, moves):
                card = replace(post.card, state="interrupted", place=None, doing="", step=0, steps=0)
                await forum.edit(post.id, say("interrupted.claim", "en"), card=card)

    unknown = [post for post in statuses if not (post.reply_to and await journal.knows(post.reply_to))]
    await asyncio.gather(*map(close, unknown))
