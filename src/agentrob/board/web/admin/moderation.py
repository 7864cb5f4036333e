"""Pages for moderators: hide and show posts, lock and move topics; forms that do what the API does."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.admin import moderation
from agentrob.board.auth import access
from agentrob.board.auth.access import Viewer
from agentrob.board.services import get_services
from agentrob.board.web.admin import forms
from agentrob.board.web.templating import go, show
from agentrob.model import Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
Reading = Annotated[Viewer, Depends(access.reader)]
Anybody = Annotated[Viewer, Depends(access.viewer)]


@router.get("/t/{topic_id}/moderate")
async def moderate_topic(request: Request, viewer: Reading, topic_id: str) -> Response:
    access.has_role(access.account_of(viewer), Role.MODERATOR)
    store = get_services(request).store
    return show(request, viewer, "moderate.html", {"topic": store.topic(topic_id), "boards": store.boards()})


@router.post("/t/{topic_id}/lock")
async def lock_topic(request: Request, viewer: Anybody, topic_id: str) -> Response:
    form, by = await forms.sent(request, viewer, Role.MODERATOR)
    store = get_services(request).store
    store.topic(topic_id)
    locked, reason = "locked" in form, forms.field(form, "reason")[:200]
    await store.do(lambda t: moderation.lock(t, by, topic_id, locked, reason))
    return go(f"/t/{topic_id}")


@router.post("/t/{topic_id}/move")
async def move_topic(request: Request, viewer: Anybody, topic_id: str) -> Response:
    form, by = await forms.sent(request, viewer, Role.MODERATOR)
    store = get_services(request).store
    store.topic(topic_id)
    board_id, reason = store.board(forms.field(form, "board")).id, forms.field(form, "reason")[:200]
    await store.do(lambda t: moderation.move(t, by, topic_id, board_id, reason))
    return go(f"/t/{topic_id}")


@router.get("/p/{post_id}/moderate")
async def moderate_post(request: Request, viewer: Reading, post_id: str) -> Response:
    access.has_role(access.account_of(viewer), Role.MODERATOR)
    post, versions, hidden_by = moderation.hidden(get_services(request).store.reader, post_id)
    return show(request, viewer, "moderate_post.html", {"post": post, "versions": versions, "hidden_by": hidden_by})


@router.post("/p/{post_id}/moderate")
async def change_post(request: Request, viewer: Anybody, post_id: str) -> Response:
    form, by = await forms.sent(request, viewer, Role.MODERATOR)
    store = get_services(request).store
    store.post(post_id)
    reason = forms.field(form, "reason")[:200]
    if "show" in form:
        await store.do(lambda t: moderation.show(t, by, post_id, reason))
    else:
        await store.remove(by, post_id, reason)
    return go(f"/p/{post_id}")
