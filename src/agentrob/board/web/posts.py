"""The pages of one post, and what forms ask for while somebody writes one: previews and names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated
from urllib.parse import quote

from fastapi import APIRouter, Form, Request
from sqlalchemy import and_, select
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response

from agentrob.board import access
from agentrob.board.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.command_reading import READ_CHARS
from agentrob.board.content import uploads
from agentrob.board.content.store import Store
from agentrob.board.db import schema as db
from agentrob.board.db.records import StoredPost
from agentrob.board.robots import approvals, reach, reading
from agentrob.board.robots import view as robot_view
from agentrob.board.robots.command_view import captions
from agentrob.board.services import AppServices, Services
from agentrob.board.web import forms
from agentrob.board.web.forms import Composed, PageForm, PostForm, Text
from agentrob.board.web.templating import error_page, error_text, redirect, render_page
from agentrob.errors import BoardError
from agentrob.model import Account

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

#: Posts on one page of a topic.
POSTS = 50
#: Names that are suggested while somebody writes one.
NAMES = 8
SentPost = Annotated[PostForm, Form(media_type="multipart/form-data")]


class PreviewForm(PageForm):
    body: Text = ""
    board: str = ""


@router.get("/p/{post_id}")
async def post(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    store = services.store
    return redirect(path_of(store, store.reader.post(post_id), request.query_params.get("done", "")))


@router.get("/p/{post_id}/fragment")
async def fragment(
    request: Request, services: AppServices, viewer: ReadingViewer, post_id: str, seen: bool = False
) -> Response:
    """`seen`: the post is added to a page that is visible now."""
    store, found = services.store, services.store.reader.post(post_id)
    if seen:
        services.marks.showed(store.reader, viewer.account, store.reader.topic(found.topic_id), found.id)
    data: dict[str, object] = {"post": found, "authors": named(store, [found.reply_to])}
    hidden = robot_view.hidden_cameras(services, viewer.account, [found])
    data |= {"hidden": hidden, "owners": robot_view.owners(services, [found])}
    data |= {"asking": approvals.in_thread(services, [found], viewer.account), "key": forms.nonce()}
    data["captions"] = captions(store.reader, [found])
    return render_page(request, viewer, "post.html", data)


@router.get("/p/{post_id}/raw")
async def raw(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    headers = {"X-Content-Type-Options": "nosniff", "Content-Security-Policy": "default-src 'none'; sandbox"}
    return PlainTextResponse(services.store.reader.post(post_id).raw, headers=headers)


@router.get("/p/{post_id}/history")
async def history(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    store = services.store
    found = store.reader.post(post_id)
    versions = () if found.removed else store.reader.versions(post_id)
    return render_page(request, viewer, "history.html", {"post": found, "versions": versions})


@router.get("/p/{post_id}/edit")
async def edit_form(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    found = services.store.reader.post(post_id)
    if found.author.id != access.account_of(viewer).id or found.removed:
        raise BoardError(403, "not_yours", "only the author of a post may edit it, until it is removed")
    return _edit(request, viewer, found, Composed(draft=found.raw))


@router.post("/p/{post_id}/edit")
async def edit(request: Request, services: AppServices, viewer: AnyViewer, post_id: str, form: SentPost) -> Response:
    typed = Composed(form.body)
    try:
        author = form.sender(viewer)
        typed = replace(typed, pictures=await form.all_pictures(services, author))
        if form.do == "preview":
            return _edit(request, viewer, services.store.reader.post(post_id), await previewed(services, typed, author))
        text, pictures = forms.body(typed.draft), [image.id for image in typed.pictures]
        key = form.idempotency_key(post_id, text)
        changed = await services.store.edit(author, post_id, text, key=key, images=pictures)
    except BoardError as e:
        if is_locked_out(viewer) or e.status == 404:
            return await error_page(request, e, draft=typed.draft)
        return _edit(request, viewer, services.store.reader.post(post_id), typed, e)
    return redirect(path_of(services.store, changed))


def _edit(
    request: Request, viewer: Viewer, found: StoredPost, typed: Composed, error: BoardError | None = None
) -> Response:
    typed = replace(typed, problem=error_text(error))
    data = {"post": found, "typed": typed, "key": forms.nonce(), "may_upload": uploads.may(viewer.account)}
    return render_page(request, viewer, "edit.html", data, status=error.status if error else 200)


@router.get("/p/{post_id}/remove")
async def remove_form(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    access.account_of(viewer)
    return render_page(request, viewer, "remove.html", {"post": services.store.reader.post(post_id)})


@router.post("/p/{post_id}/remove")
async def remove(services: AppServices, viewer: AnyViewer, post_id: str, form: Annotated[PageForm, Form()]) -> Response:
    store = services.store
    return redirect(path_of(store, await store.remove(form.sender(viewer), post_id)))


# ------------------------------------------------------------------ while somebody writes
@router.post("/preview")
async def preview(
    request: Request, services: AppServices, viewer: AnyViewer, form: Annotated[PreviewForm, Form()]
) -> Response:
    """The text as it would be shown, and whether a robot would answer it on that board; stores nothing."""
    shown = await previewed(services, Composed(draft=form.body), form.sender(viewer), form.board)
    return render_page(request, viewer, "preview.html", {"typed": shown})


async def previewed(services: Services, typed: Composed, by: Account, board_id: str = "") -> Composed:
    """The form with a preview of its text, which may be empty. 413 if it is too long, 422, 429, 503."""
    text = forms.body(typed.draft) if typed.draft.strip() else ""
    typed = replace(typed, preview=(await services.store.renderer.render(text, by)).html)
    if board_id and services.reading is not None and 0 < len(text) <= READ_CHARS:
        return replace(typed, reading=(await reading.read(services, by, text, board_id)).line)
    return replace(typed, hint=reach.hint(services, board_id, text) if board_id else "")


@router.get("/names")
async def names(request: Request, services: AppServices, viewer: ReadingViewer, q: str = "") -> Response:
    """Accounts whose names begin with `q`: robots with their state first, then people."""
    access.account_of(viewer)
    prefix = q.lower()[:32]
    robots = [r for r in robot_view.robots(services) if r.name.startswith(prefix)]
    found = [
        {"name": r.name, "robot": True, "live": r.live, "state": (r.state or "online") if r.live else "not connected"}
        for r in robots
    ]
    others = _names(services, prefix, NAMES + len(robots)) if prefix else ()
    taken = {r["name"] for r in found}
    found += [{"name": n, "robot": False, "live": False, "state": ""} for n in others if n not in taken]
    return JSONResponse(found[:NAMES], headers={"Cache-Control": "no-store"})


def _names(services: Services, prefix: str, limit: int) -> tuple[str, ...]:
    """Names of accounts that are not suspended, in alphabetical order."""
    a = db.accounts.c
    begins = and_(a.name >= prefix, a.name < prefix + "\x7f", a.suspended.is_(False))
    return tuple(r.name for r in services.store.reader.rows(select(a.name).where(begins).order_by(a.name).limit(limit)))


# ------------------------------------------------------------------ pieces
def named(store: Store, post_ids: Iterable[str | None]) -> dict[str, str]:
    """The authors of posts that others reply to, by post id; only of posts that the viewer may see."""
    ids = [int(post_id) for post_id in post_ids if post_id and post_id.isdigit()]
    return {post.id: post.author.name for post in store.reader.posts_by_id(ids)} if ids else {}


def path_of(store: Store, post: StoredPost, done: str = "") -> str:
    """The path of a post: the page of its topic that shows it."""
    cursor = store.reader.cursor_before(post.id, POSTS)
    query = "&".join(f"{k}={quote(v, safe='')}" for k, v in (("after", cursor), ("done", done)) if v)
    return f"/t/{post.topic_id}{'?' + query if query else ''}#post-{post.id}"


def is_locked_out(viewer: Viewer) -> bool:
    """Whether the viewer may not see the page of a form; then an error page returns what was typed."""
    return viewer.account is None or viewer.account.suspended
