"""Retry posts that cannot be read a limited number of times, without blocking the others."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Concatenate, ParamSpec

import structlog

from agentrob.errors import ForumError, ForumMalformed

#: After this many failures in a row, an error of the connection or the forum is attributed to the post.
TRIES = 3
#: From then on the post is retried on every `SELDOM`th look, until `MOST_TRIES`.
SELDOM, MOST_TRIES = 8, 40
MOST_KEPT = 1_000
_P = ParamSpec("_P")
_log = structlog.get_logger()


class PostRetries:
    """Count the failed attempts to read each post."""

    def __init__(self) -> None:
        self._tries: dict[int, int] = {}

    async def read(
        self,
        post_id: int,
        reading: Callable[Concatenate[int, _P], Awaitable[None]],
        *args: _P.args,
        **more: _P.kwargs,
    ) -> bool:
        """Return whether the post was read.

        Errors of the connection are raised, so that later posts stay in order, until they happened too often in a row
        with this post: then the post counts as unreadable.
        """
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
