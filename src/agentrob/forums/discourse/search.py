"""Full-text search on Discourse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from agentrob.forums.discourse.http import DiscourseClient
from agentrob.forums.http import translate_errors
from agentrob.model import Page, Post

#: Posts of a page of `/search.json`.
RESULTS_A_PAGE = 50
_JSON = Mapping[str, Any]


class Source(Protocol):
    """The part of the adapter that search needs."""

    async def category(self, board_id: str) -> tuple[int, str]: ...

    async def raw_posts(self, topic_id: int, post_ids: Sequence[int]) -> dict[int, _JSON]: ...

    async def build(self, raw: _JSON, fresh: bool = False) -> Post: ...


async def find_posts(
    source: Source, client: DiscourseClient, query: str, board_id: str | None, cursor: str | None, limit: int
) -> Page[Post]:
    """Posts that have the words, newest first. What would be more than words to Discourse (`in:`, `@`, `#`) is left
    out, so that nobody searches an account's private messages by a query."""
    words = [w for w in query.split() if ":" not in w and not w.startswith(("@", "#", "-"))]
    if not words:
        return Page(())
    place = "#" + (await source.category(board_id))[1].replace("/", ":") if board_id else ""
    start = int(cursor) if cursor and cursor.isdigit() else 0
    page, skip = divmod(start, RESULTS_A_PAGE)
    term = " ".join(filter(None, (*words, place, "order:latest")))
    found = (await client.get("/search.json", q=term, page=page + 1))["posts"] or []
    with translate_errors():
        hits = [(int(p["topic_id"]), int(p["id"])) for p in found]
    shown = hits[skip : skip + limit]
    posts: dict[int, _JSON] = {}
    for topic_id in dict.fromkeys(t for t, _ in shown):
        posts |= await source.raw_posts(topic_id, [n for t, n in shown if t == topic_id])
    items = [await source.build(posts[n]) for _, n in shown if n in posts]
    more = len(hits) > skip + limit or len(found) >= RESULTS_A_PAGE
    return Page(tuple(items), str(start + len(shown)) if more and shown else None)
