"""The pages of moderators: hide and show posts, lock and move topics."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Form, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board import access
from agentrob.board.access import AnyViewer, ReadingViewer
from agentrob.board.admin import moderation
from agentrob.board.services import AppServices
from agentrob.board.web.forms import Checkbox, Line, PageForm
from agentrob.board.web.templating import redirect, render_page
from agentrob.model import Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


class ModerationForm(PageForm):
    """The forms of moderators; each sends some of these fields. `locked` and `show` say which of two is wanted."""

    reason: Line = ""
    locked: Checkbox = False
    board: Line = ""
    show: Checkbox = False

    @property
    def short_reason(self) -> str:
        return self.reason[:200]


SentForm = Annotated[ModerationForm, Form()]


@router.get("/t/{topic_id}/moderate")
async def moderate_topic(request: Request, services: AppServices, viewer: ReadingViewer, topic_id: str) -> Response:
    access.has_role(access.account_of(viewer), Role.MODERATOR)
    store = services.store
    return render_page(
        request, viewer, "moderate.html", {"topic": store.reader.topic(topic_id), "boards": store.reader.boards()}
    )


@router.post("/t/{topic_id}/lock")
async def lock_topic(services: AppServices, viewer: AnyViewer, topic_id: str, form: SentForm) -> Response:
    by, store = form.sender(viewer, Role.MODERATOR), services.store
    store.reader.topic(topic_id)
    await store.do(lambda t: moderation.lock(t, by, topic_id, form.locked, form.short_reason))
    return redirect(f"/t/{topic_id}")


@router.post("/t/{topic_id}/move")
async def move_topic(services: AppServices, viewer: AnyViewer, topic_id: str, form: SentForm) -> Response:
    by, store = form.sender(viewer, Role.MODERATOR), services.store
    store.reader.topic(topic_id)
    board_id = store.reader.board(form.board).id
    await store.do(lambda t: moderation.move(t, by, topic_id, board_id, form.short_reason))
    return redirect(f"/t/{topic_id}")


@router.get("/p/{post_id}/moderate")
async def moderate_post(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    access.has_role(access.account_of(viewer), Role.MODERATOR)
    post, versions, hidden_by = moderation.hidden(services.store.reader, post_id)
    return render_page(
        request, viewer, "moderate_post.html", {"post": post, "versions": versions, "hidden_by": hidden_by}
    )


@router.post("/p/{post_id}/moderate")
async def change_post(services: AppServices, viewer: AnyViewer, post_id: str, form: SentForm) -> Response:
    by, store = form.sender(viewer, Role.MODERATOR), services.store
    store.reader.post(post_id)
    if form.show:
        await store.do(lambda t: moderation.show(t, by, post_id, form.short_reason))
    else:
        await store.remove(by, post_id, form.short_reason)
    return redirect(f"/p/{post_id}")
