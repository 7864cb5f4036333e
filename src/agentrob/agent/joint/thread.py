"""The statuses that robots show of the parts of posts, in the order of the thread: read from the forum, or received
as events."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

import structlog

from agentrob.agent.joint.evidence import part_posts
from agentrob.errors import ForumError
from agentrob.forums.bounded import BoundedDict
from agentrob.forums.protocol import Forum
from agentrob.model import Command, Post

#: The most posts about parts that are remembered, and the most pages of a thread that are read.
MOST_POSTS, MOST_PAGES = 500, 40
#: How long the forum may take to show a thread.
READ_S = 10.0
_log = structlog.get_logger()


class PartThreads:
    """The robots' posts about parts. `on_change` is called when one was heard."""

    def __init__(self, forum: Forum, on_change: Callable[[], None]) -> None:
        self._forum, self._on_change = forum, on_change
        self._posts: BoundedDict[str, Post] = BoundedDict(MOST_POSTS)
        self._order: BoundedDict[str, dict[str, int]] = BoundedDict(MOST_POSTS)
        #: Grows with each post that was heard.
        self.heard = 0

    def receive(self, post: Post) -> None:
        """Note a post of an event, if a robot shows a part by it."""
        if post.card is None or not post.card.part:
            return
        self._keep(post)
        self.heard += 1
        self._on_change()

    def _keep(self, post: Post) -> None:
        before = self._posts.get(post.id)
        if before is None or before.version <= post.version:
            self._posts[post.id] = post

    def known(self, command: Command) -> list[Post]:
        """The posts about the parts of a command's post that were heard or read so far, in the order of the thread as
        far as it was read."""
        found = part_posts(self._posts.values(), command)
        order = self._order.get(command.topic_id, {})
        return sorted(found, key=lambda post: order.get(post.id, len(order)))

    async def read(self, command: Command) -> list[Post]:
        """Read the thread of a command and return the posts about the parts of its post. Raises `ForumError`."""
        posts = await self._thread(command.topic_id)
        shown = [post for post in posts if post.card is not None and post.card.part]
        self._order[command.topic_id] = {post.id: place for place, post in enumerate(shown)}
        for post in shown:
            self._keep(post)
        return self.known(command)

    async def read_or_known(self, command: Command) -> list[Post]:
        """Like `read`; what is known if the forum does not answer."""
        try:
            async with asyncio.timeout(READ_S):
                return await self.read(command)
        except (ForumError, TimeoutError) as e:
            _log.info("thread of a part not read", post=command.post_id, error=str(e) or type(e).__name__)
            return self.known(command)

    async def _thread(self, topic_id: str) -> Sequence[Post]:
        posts: list[Post] = []
        cursor: str | None = None
        for _ in range(MOST_PAGES):
            page = await self._forum.posts(topic_id, cursor)
            posts += page.items
            if (cursor := page.next) is None:
                break
        return posts
