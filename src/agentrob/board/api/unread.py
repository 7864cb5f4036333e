"""The JSON API of what is unread: by topic, of a board or of all, and saying what one has read.

It goes with looking, so every token is good for it, as for a page, which counts as read when it was shown.
"""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from starlette.responses import Response

from agentrob.board.admin.management import BOARD_ID
from agentrob.board.api.forum import Cursor, Limit, Reading, Stopper, out, shaper
from agentrob.board.api.models import ReadIn, TopicReadIn, UnreadOut, UnreadPage
from agentrob.board.api.problem import documented
from agentrob.board.auth.access import account_of
from agentrob.board.services import get_services
from agentrob.model import Account

router = APIRouter(prefix="/api/v1", responses=documented(404))

Board = Annotated[str | None, Query(pattern=rf"^{BOARD_ID.pattern}$", description="only of this board")]


@router.get("/unread", response_model=UnreadPage)
async def unread(
    request: Request, who: Reading, board: Board = None, cursor: Cursor = None, limit: Limit = 20
) -> Response:
    """Topics with posts of others that the caller has not read, latest activity first; a page may be short."""
    return _page(request, account_of(who), board, cursor, limit)


@router.put("/unread", response_model=UnreadPage)
async def read(request: Request, said: ReadIn, by: Stopper) -> Response:
    """All posts up to one count as read, of a board or of all; never fewer than before. What is unread still."""
    parts = get_services(request)
    board = parts.store.board(said.board).id if said.board is not None else None
    await parts.marks.all_read(parts.store, by, int(said.up_to), board)
    return _page(request, by, board, None, 20)


@router.put("/topics/{topic_id}/read", response_model=UnreadOut)
async def topic_read(request: Request, topic_id: str, said: TopicReadIn, by: Stopper) -> Response:
    """The posts of a topic up to one count as read, without it all of them; what is unread of it still."""
    parts = get_services(request)
    topic = parts.store.topic(topic_id)
    await parts.marks.topic_read(parts.store, by, topic, int(said.up_to or topic.last_post_id))
    return out(shaper(request, by).unread(topic, parts.marks.news(parts.store.reader, by, [topic]).get(topic.id)))


def _page(request: Request, account: Account, board: str | None, cursor: str | None, limit: int) -> Response:
    parts, shape = get_services(request), shaper(request, account)
    up_to = parts.store.reader.newest_post_id()
    page = parts.marks.unread(parts.store.reader, account, cursor, limit, board)
    items = tuple(shape.unread(topic, news) for topic, news in page.items)
    return out(UnreadPage(items=items, next=page.next, up_to=str(up_to)))
