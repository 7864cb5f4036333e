"""The pages of one post: where it is, its Markdown, its earlier texts, editing and removing it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from urllib.parse import quote

from fastapi import APIRouter, Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response

from agentrob.board.auth import access
from agentrob.board.auth.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.content import uploads
from agentrob.board.content.store import Store
from agentrob.board.db.records import StoredPost
from agentrob.board.robots import approvals
from agentrob.board.robots import view as robot_view
from agentrob.board.services import AppServices
from agentrob.board.web import forms
from agentrob.board.web.find import previewed
from agentrob.board.web.forms import Composed
from agentrob.board.web.templating import error_page, go, show
from agentrob.errors import BoardError

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


#: Posts on one page of a topic.
POSTS = 50


@router.get("/p/{post_id}")
async def post(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    store = services.store
    return go(path_of(store, store.post(post_id), request.query_params.get("done", "")))


@router.get("/p/{post_id}/fragment")
async def fragment(
    request: Request, services: AppServices, viewer: ReadingViewer, post_id: str, seen: bool = False
) -> Response:
    """`seen`: it is put at the end of a page that somebody looks at."""
    store, found = services.store, services.store.post(post_id)
    if seen:
        services.marks.showed(store.reader, viewer.account, store.topic(found.topic_id), found.id)
    data: dict[str, object] = {"post": found, "authors": named(store, [found.reply_to])}
    hidden = robot_view.hidden_cameras(services, viewer.account, [found])
    data |= {"hidden": hidden, "owners": robot_view.owners(services, [found])}
    data |= {"asking": approvals.in_thread(services, [found], viewer.account), "key": forms.nonce()}
    return show(request, viewer, "post.html", data)


@router.get("/p/{post_id}/raw")
async def raw(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    headers = {"X-Content-Type-Options": "nosniff", "Content-Security-Policy": "default-src 'none'; sandbox"}
    return PlainTextResponse(services.store.post(post_id).raw, headers=headers)


@router.get("/p/{post_id}/history")
async def history(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    store = services.store
    found = store.post(post_id)
    versions = () if found.removed else store.versions(post_id)
    return show(request, viewer, "history.html", {"post": found, "versions": versions})


@router.get("/p/{post_id}/edit")
async def edit_form(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    found = services.store.post(post_id)
    if found.author.id != access.account_of(viewer).id or found.removed:
        raise BoardError(403, "not_yours", "only its author may edit a post, and only while it is there")
    return _edit(request, viewer, found, Composed(draft=found.raw))


@router.post("/p/{post_id}/edit")
async def edit(request: Request, services: AppServices, viewer: AnyViewer, post_id: str) -> Response:
    form = await forms.read(request)
    typed = Composed(forms.field(form, "body"))
    try:
        access.check_form(viewer, form.get("csrf"))
        author = access.account_of(viewer)
        typed = replace(typed, pictures=await forms.pictures(services, form, author))
        if form.get("do") == "preview":
            return _edit(request, viewer, services.store.post(post_id), await previewed(services, typed, author))
        text, pictures = forms.body(typed.draft), [image.id for image in typed.pictures]
        key = forms.key(form, post_id, text)
        changed = await services.store.edit(author, post_id, text, key=key, images=pictures)
    except BoardError as e:
        if may_not_look(viewer) or e.status == 404:
            return await error_page(request, e, draft=typed.draft)
        return _edit(request, viewer, services.store.post(post_id), typed, e)
    return go(path_of(services.store, changed))


def _edit(
    request: Request, viewer: Viewer, found: StoredPost, typed: Composed, error: BoardError | None = None
) -> Response:
    typed = replace(typed, problem=forms.problem(error))
    data = {"post": found, "typed": typed, "key": forms.nonce(), "may_upload": uploads.may(viewer.account)}
    return show(request, viewer, "edit.html", data, status=error.status if error else 200)


@router.get("/p/{post_id}/remove")
async def remove_form(request: Request, services: AppServices, viewer: ReadingViewer, post_id: str) -> Response:
    access.account_of(viewer)
    return show(request, viewer, "remove.html", {"post": services.store.post(post_id)})


@router.post("/p/{post_id}/remove")
async def remove(request: Request, services: AppServices, viewer: AnyViewer, post_id: str) -> Response:
    await forms.read_checked(request, viewer)
    store = services.store
    return go(path_of(store, await store.remove(access.account_of(viewer), post_id)))


# ------------------------------------------------------------------ pieces
def named(store: Store, post_ids: Iterable[str | None]) -> dict[str, str]:
    """Who wrote posts that are answered; of those that are not to be seen, nothing."""
    ids = [int(post_id) for post_id in post_ids if post_id and post_id.isdigit()]
    return {post.id: post.author.name for post in store.reader.posts_by_id(ids)} if ids else {}


def path_of(store: Store, post: StoredPost, done: str = "") -> str:
    """Where a post is to be seen: the page of its topic that shows it."""
    cursor = store.cursor_before(post.id, POSTS)
    query = "&".join(f"{k}={quote(v, safe='')}" for k, v in (("after", cursor), ("done", done)) if v)
    return f"/t/{post.topic_id}{'?' + query if query else ''}#post-{post.id}"


def may_not_look(viewer: Viewer) -> bool:
    """Then a form that failed cannot be shown again on its page; what was typed is given back on an error page."""
    return viewer.account is None or viewer.account.suspended
