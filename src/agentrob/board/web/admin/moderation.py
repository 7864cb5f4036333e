"""Pages for moderators: hide and show posts, lock and move topics; forms that do what the API does."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.admin import moderation
from agentrob.board.auth import access
from agentrob.board.auth.access import AnyViewer, ReadingViewer
from agentrob.board.services import AppServices
from agentrob.board.web import forms
from agentrob.board.web.templating import go, show
from agentrob.model import Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


@router.get("/t/{topic_id}/moderate")
async def moderate_topic(request: Request, services: AppServices, viewer: ReadingViewer, topic_id: str) -> Response:
    access.has_role(access.account_of(viewer), Role.MODERATOR)
    store = services.store
    return show(request, viewer, "moderate.html", {"topic": store.topic(topic_id), "boards": store.boards()})


@router.post("/t/{topic_id}/lock")
async def lock_topic(request: Request, services: AppServices, viewer: AnyViewer, topic_id: str) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.MODERATOR)
    store = services.store
    store.topic(topic_id)
    locked, reason = "locked" in form, forms.stripped(form, "reason")[:200]
    await store.do(lambda t: moderation.lock(t, by, topic_id, locked, reason))
    return go(f"/t/{topic_id}")


@router.post("/t/{topic_id}/move")
async def move_topic(request: Request, services: AppServices, viewer: AnyViewer, topic_id: str) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.MODERATOR)
    store = services.store
    store.topic(topic_id)
    board_id, reason = store.board(forms.stripped(form, "board")).id, forms.stripped(form, "reason")[:200]
    await store.do(lambda t: moderation.move(t, by, topic_id, board_id, reason))
    return go(f"/t/{topic_id}")


@router.get("/p/{post_id}/moderate")
async def moderate_post(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    access.has_role(access.account_of(viewer), Role.MODERATOR)
    post, versions, hidden_by = moderation.hidden(services.store.reader, post_id)
    return show(request, viewer, "moderate_post.html", {"post": post, "versions": versions, "hidden_by": hidden_by})


@router.post("/p/{post_id}/moderate")
async def change_post(request: Request, services: AppServices, viewer: AnyViewer, post_id: str) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.MODERATOR)
    store = services.store
    store.post(post_id)
    reason = forms.stripped(form, "reason")[:200]
    if "show" in form:
        await store.do(lambda t: moderation.show(t, by, post_id, reason))
    else:
        await store.remove(by, post_id, reason)
    return go(f"/p/{post_id}")
