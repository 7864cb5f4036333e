"""Retry posts that cannot be read a limited number of times, without blocking the others."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Concatenate, ParamSpec

import structlog

from agentrob.errors import ForumError, ForumMalformed

#: An error of the connection or the forum is believed to be one of this post after so many tries in a row.
TRIES = 3
#: Then it is tried again at every so many looks, and not any more after that many tries.
SELDOM, MOST_TRIES = 8, 40
MOST_KEPT = 1_000
_P = ParamSpec("_P")
_log = structlog.get_logger()


class PostRetries:
    """Which posts could not be read, and how often."""

    def __init__(self) -> None:
        self._tries: dict[int, int] = {}

    async def read(
        self,
        post_id: int,
        reading: Callable[Concatenate[int, _P], Awaitable[None]],
        *args: _P.args,
        **more: _P.kwargs,
    ) -> bool:
        """Whether the post was read. An error of the connection is raised, so that what follows keeps its order, unless
        it keeps happening to this post: then it is the post's."""
        tries = self._tries.get(post_id, 0)
        if tries >= TRIES and (tries % SELDOM or tries >= MOST_TRIES):
            self._tries[post_id] = min(tries + 1, MOST_TRIES)
            return False
        try:
            await reading(post_id, *args, **more)
        except Exception as e:
            self._tries[post_id] = tries + 1
            if tries < TRIES and isinstance(e, ForumError) and not isinstance(e, ForumMalformed):
                raise
            if tries in (0, TRIES):
                _log.error("a post cannot be read and is passed over", post=post_id, error=repr(e)[:300])
            for old in sorted(self._tries)[:-MOST_KEPT]:
                del self._tries[old]
            return False
        self._tries.pop(post_id, None)
        return True
