"""The JSON API of tags: which there are, and choosing those of a topic."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import Response

from agentrob.board.api.forum import Member, Reading, out, shaper
from agentrob.board.api.models import Items, TagOut, TagsIn, TopicOut
from agentrob.board.api.problem import documented
from agentrob.board.auth.access import moderator
from agentrob.board.content import tags
from agentrob.board.services import get_services

router = APIRouter(prefix="/api/v1", responses=documented())


@router.get("/tags", response_model=Items[TagOut])
async def listed(request: Request, who: Reading) -> Response:
    """The tags of topics, those of most topics first; at most 200."""
    found = await get_services(request).store.beside(tags.listed)
    return out(Items(items=tuple(TagOut(tag=t.tag, topics=t.topics) for t in found)))


@router.put("/topics/{topic_id}/tags", response_model=TopicOut, responses=documented(404, 429))
async def choose(request: Request, topic_id: str, new: TagsIn, by: Member) -> Response:
    """Other tags for a topic: one's own, or any for a moderator."""
    store, found, most = (
        get_services(request).store,
        tags.checked(new.tags),
        get_services(request).settings.limits.posts,
    )
    if store.topic(topic_id).author.id != by.id:
        await moderator(request)
    changed = await store.do(lambda t: tags.change(t, by, topic_id, found, most))
    return out(shaper(request, by).topic(changed))
