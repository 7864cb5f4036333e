"""The JSON API for moderation: hide and show posts, lock and move topics. Nothing is lost, and all of it is logged."""

from __future__ import annotations

from fastapi import APIRouter
from starlette.responses import Response

from agentrob.board.access import Moderator
from agentrob.board.admin import moderation
from agentrob.board.api.admin_models import HiddenOut, LockIn, MoveIn, ReasonIn
from agentrob.board.api.dependencies import documented, json_response, serializer
from agentrob.board.api.models import PostOut, TopicOut
from agentrob.board.services import AppServices

router = APIRouter(prefix="/api/v1", responses=documented(404, 409), tags=["moderation"])


@router.get("/posts/{post_id}/hidden", response_model=HiddenOut)
async def get_hidden_post(services: AppServices, post_id: str, by: Moderator) -> Response:
    """A post with the text it had before it was hidden, and its earlier texts."""
    post, versions, hidden_by = moderation.hidden(services.store.reader, post_id)
    shown = serializer(services, by).post(post)
    return json_response(HiddenOut(post=shown, versions=tuple(v.raw for v in versions), hidden_by=hidden_by))


@router.post("/posts/{post_id}/hide", response_model=PostOut)
async def hide_post(services: AppServices, post_id: str, why: ReasonIn, by: Moderator) -> Response:
    """Hide a post; a command in it that has not begun is cancelled."""
    services.store.reader.post(post_id)  # 404 for a board that the moderator may not read
    return json_response(serializer(services, by).post(await services.store.remove(by, post_id, why.reason)))


@router.post("/posts/{post_id}/show", response_model=PostOut)
async def show_post(services: AppServices, post_id: str, why: ReasonIn, by: Moderator) -> Response:
    """Show a hidden post again; it starts no motion."""
    services.store.reader.post(post_id)
    shown = await services.store.do(lambda t: moderation.show(t, by, post_id, why.reason))
    return json_response(serializer(services, by).post(shown))


@router.post("/topics/{topic_id}/lock", response_model=TopicOut)
async def lock_topic(services: AppServices, topic_id: str, how: LockIn, by: Moderator) -> Response:
    """Lock or unlock a topic; a stop is accepted in a locked one too."""
    services.store.reader.topic(topic_id)
    changed = await services.store.do(lambda t: moderation.lock(t, by, topic_id, how.locked, how.reason))
    return json_response(serializer(services, by).topic(changed))


@router.post("/topics/{topic_id}/move", response_model=TopicOut)
async def move_topic(services: AppServices, topic_id: str, where: MoveIn, by: Moderator) -> Response:
    """Move a topic to another board that the moderator may read."""
    services.store.reader.topic(topic_id)
    services.store.reader.board(where.board_id)
    changed = await services.store.do(lambda t: moderation.move(t, by, topic_id, where.board_id, where.reason))
    return json_response(serializer(services, by).topic(changed))
