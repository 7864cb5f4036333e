"""The JSON API's moderation: hide, show, lock, move. Nothing is lost, and all of it is logged."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from agentrob.board.admin import moderation
from agentrob.board.api.admin_models import HiddenOut, LockIn, MoveIn, ReasonIn
from agentrob.board.api.forum import out, shaper
from agentrob.board.api.models import PostOut, TopicOut
from agentrob.board.api.problem import documented
from agentrob.board.auth.access import moderator
from agentrob.board.services import get_services
from agentrob.model import Account

router = APIRouter(prefix="/api/v1", responses=documented(404, 409))
Moderator = Annotated[Account, Depends(moderator)]


@router.get("/posts/{post_id}/hidden", response_model=HiddenOut)
async def hidden(request: Request, post_id: str, by: Moderator) -> Response:
    """A post with the text it had before it was hidden, and its earlier texts."""
    post, versions, hidden_by = moderation.hidden(get_services(request).store.reader, post_id)
    shown = shaper(request, by).post(post)
    return out(HiddenOut(post=shown, versions=tuple(v.raw for v in versions), hidden_by=hidden_by))


@router.post("/posts/{post_id}/hide", response_model=PostOut)
async def hide(request: Request, post_id: str, why: ReasonIn, by: Moderator) -> Response:
    """Hide a post; what it commanded and has not begun is cancelled."""
    store = get_services(request).store
    store.post(post_id)  # moderators too see only boards that they may read
    return out(shaper(request, by).post(await store.remove(by, post_id, why.reason)))


@router.post("/posts/{post_id}/show", response_model=PostOut)
async def show(request: Request, post_id: str, why: ReasonIn, by: Moderator) -> Response:
    """Show a hidden post again; it starts no motion."""
    store = get_services(request).store
    store.post(post_id)
    return out(shaper(request, by).post(await store.do(lambda t: moderation.show(t, by, post_id, why.reason))))


@router.post("/topics/{topic_id}/lock", response_model=TopicOut)
async def lock(request: Request, topic_id: str, how: LockIn, by: Moderator) -> Response:
    """Lock a topic or open it again; a stop is taken in a locked one too."""
    store = get_services(request).store
    store.topic(topic_id)
    changed = await store.do(lambda t: moderation.lock(t, by, topic_id, how.locked, how.reason))
    return out(shaper(request, by).topic(changed))


@router.post("/topics/{topic_id}/move", response_model=TopicOut)
async def move(request: Request, topic_id: str, where: MoveIn, by: Moderator) -> Response:
    """Put a topic on another board that the moderator may read."""
    store = get_services(request).store
    store.topic(topic_id)
    store.board(where.board)
    changed = await store.do(lambda t: moderation.move(t, by, topic_id, where.board, where.reason))
    return out(shaper(request, by).topic(changed))
