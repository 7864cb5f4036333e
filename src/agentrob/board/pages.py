"""The pages of the embedded forum: plain HTML and forms that work without scripts, and become live with them."""

from __future__ import annotations

import hashlib
import re
import secrets
from typing import Annotated, Any
from urllib.parse import quote

from fastapi import APIRouter, Depends, Request
from starlette.datastructures import FormData
from starlette.responses import HTMLResponse, PlainTextResponse, Response

from agentrob.board import access, buttons, rights, robot_view
from agentrob.board.access import Viewer
from agentrob.board.api_models import POST_BYTES
from agentrob.board.records import Post, Topic
from agentrob.board.services import Services, services
from agentrob.board.store import Store
from agentrob.board.templating import error_page, go, hint_of, own_path, sentence, show, static_file, with_receipt
from agentrob.board.topic_posts import posts_of_topic
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind

__all__ = ["error_page", "router"]

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

Reading = Annotated[Viewer, Depends(access.reader)]
Anybody = Annotated[Viewer, Depends(access.viewer)]
Data = dict[str, Any]

#: Posts on one page of a topic.
POSTS = 50
_LATEST = 10
TITLE_LENGTH = 200


# ------------------------------------------------------------------ boards and topics
@router.get("/")
async def home(request: Request, viewer: Reading, after: str | None = None) -> Response:
    known = services(request)
    boards = known.store.boards()
    data: Data = {"boards": boards, "names": {b.id: b.name for b in boards}, "robots": robot_view.robots(known)}
    return show(request, viewer, "home.html", data | {"topics": known.store.latest(after)}, here="home")


@router.get("/b/{board_id}")
async def board(request: Request, viewer: Reading, board_id: str, after: str | None = None) -> Response:
    known = services(request)
    newest = known.store.newest_event_id()  # before the topics are read, so that nothing falls between
    topics = known.store.topics(board_id, after)
    data: Data = {"board": known.store.board(board_id), "topics": topics, "robots": robot_view.robots(known)}
    return show(request, viewer, "board.html", data | {"after": newest}, here="home")


@router.get("/b/{board_id}/new")
async def new_topic(request: Request, viewer: Reading, board_id: str, to: str = "") -> Response:
    access.account_of(viewer)
    account = services(request).store.account(to)
    return _new_topic(request, viewer, board_id, draft=f"@{account.name} " if account else "")


@router.post("/b/{board_id}/new")
async def create_topic(request: Request, viewer: Anybody, board_id: str) -> Response:
    form = await _form(request)
    title, body = _field(form, "title"), _field(form, "body")
    try:
        access.check_form(viewer, form.get("csrf"))
        author = access.account_of(viewer)
        checked = _checked_title(title), _checked_body(body)
        written = await services(request).store.create_topic(author, board_id, *checked, key=_key(form, *checked))
    except BoardError as e:
        if _may_not_look(viewer) or e.code == "no_such_board":
            return await error_page(request, e, draft=body)
        return _new_topic(request, viewer, board_id, draft=body, title=title, error=e)
    return go(written.topic.path)


@router.get("/t/{topic_id}")
async def topic(request: Request, viewer: Reading, topic_id: str, after: str | None = None) -> Response:
    return _topic(request, viewer, topic_id, after)


@router.post("/t/{topic_id}/reply")
async def reply(request: Request, viewer: Anybody, topic_id: str) -> Response:
    form = await _form(request)
    body = _field(form, "body")
    store = services(request).store
    try:
        access.check_form(viewer, form.get("csrf"))
        author, text = access.account_of(viewer), _checked_body(body)
        written = await store.reply(author, topic_id, text, key=_key(form, topic_id, text))
    except BoardError as e:
        if _may_not_look(viewer) or e.code == "no_such_topic":
            return await error_page(request, e, draft=body)
        return _topic(request, viewer, topic_id, None, draft=body, error=e)
    return go(_path(store, written.post))


# ------------------------------------------------------------------ one post
@router.get("/p/{post_id}")
async def post(request: Request, viewer: Reading, post_id: str) -> Response:
    store = services(request).store
    return go(_path(store, store.post(post_id), request.query_params.get("done", "")))


@router.get("/p/{post_id}/fragment")
async def fragment(request: Request, viewer: Reading, post_id: str) -> Response:
    return show(request, viewer, "post.html", {"post": services(request).store.post(post_id)})


@router.get("/p/{post_id}/raw")
async def raw(request: Request, viewer: Reading, post_id: str) -> Response:
    headers = {"X-Content-Type-Options": "nosniff", "Content-Security-Policy": "default-src 'none'; sandbox"}
    return PlainTextResponse(services(request).store.post(post_id).raw, headers=headers)


@router.get("/p/{post_id}/history")
async def history(request: Request, viewer: Reading, post_id: str) -> Response:
    store = services(request).store
    found = store.post(post_id)
    versions = () if found.removed else store.versions(post_id)
    return show(request, viewer, "history.html", {"post": found, "versions": versions})


@router.get("/p/{post_id}/edit")
async def edit_form(request: Request, viewer: Reading, post_id: str) -> Response:
    found = services(request).store.post(post_id)
    if found.author.id != access.account_of(viewer).id or found.removed:
        raise BoardError(403, "not_yours", "only its author may edit a post, and only while it is there")
    return show(request, viewer, "edit.html", {"post": found, "draft": found.raw, "key": _nonce()})


@router.post("/p/{post_id}/edit")
async def edit(request: Request, viewer: Anybody, post_id: str) -> Response:
    form = await _form(request)
    body = _field(form, "body")
    store = services(request).store
    try:
        access.check_form(viewer, form.get("csrf"))
        author, text = access.account_of(viewer), _checked_body(body)
        changed = await store.edit(author, post_id, text, key=_key(form, post_id, text))
    except BoardError as e:
        if _may_not_look(viewer) or e.status == 404:
            return await error_page(request, e, draft=body)
        data = {"post": store.post(post_id), "draft": body, "key": _nonce(), "problem": _problem(e)}
        return show(request, viewer, "edit.html", data, status=e.status)
    return go(_path(store, changed))


@router.get("/p/{post_id}/remove")
async def remove_form(request: Request, viewer: Reading, post_id: str) -> Response:
    access.account_of(viewer)
    return show(request, viewer, "remove.html", {"post": services(request).store.post(post_id)})


@router.post("/p/{post_id}/remove")
async def remove(request: Request, viewer: Anybody, post_id: str) -> Response:
    form = await _form(request)
    access.check_form(viewer, form.get("csrf"))
    store = services(request).store
    return go(_path(store, await store.remove(access.account_of(viewer), post_id)))


# ------------------------------------------------------------------ robots and people
@router.get("/robots")
async def robots(request: Request, viewer: Reading, part: str = "") -> Response:
    data = {"robots": robot_view.robots(services(request))}
    return show(request, viewer, "robot_cards.html" if part == "cards" else "robots.html", data, here="robots")


@router.get("/robots/{name}")
async def robot(request: Request, viewer: Reading, name: str) -> Response:
    known = services(request)
    account, view = robot_view.robot(known, name)
    latest = _latest(known.store, account, once=True)
    data = {"robot": view, "account": account, "latest": latest, "administers": _administers(known, viewer, name)}
    return show(request, viewer, "robot.html", data, here="robots")


def _administers(known: Services, viewer: Viewer, robot: str) -> bool:
    owner = rights.settings_of(known.store.reader, robot).owner
    return viewer.account is not None and rights.reaches(viewer.account, "owner", owner)


@router.get("/robots/{name}/fragment")
async def robot_fragment(request: Request, viewer: Reading, name: str) -> Response:
    return show(request, viewer, "robot_facts.html", {"robot": robot_view.robot(services(request), name)[1]})


@router.post("/robots/{name}/stop")
async def stop(request: Request, viewer: Anybody, name: str) -> Response:
    """Anybody signed in, at any rate, whatever the robot's agent last said."""
    form = await _form(request)
    access.check_form(viewer, form.get("csrf"))
    await buttons.stop(services(request), name, access.account_of(viewer))
    if request.headers.get("x-live"):
        return Response(status_code=204)
    return go(with_receipt(own_path(form.get("back"), f"/robots/{name}"), viewer, "stop", name))


@router.post("/robots/{name}/reset")
async def reset(request: Request, viewer: Anybody, name: str) -> Response:
    form = await _form(request)
    access.check_form(viewer, form.get("csrf"))
    await buttons.reset(services(request), name, access.account_of(viewer))
    return go(with_receipt(f"/robots/{name}", viewer, "reset", name))


@router.get("/u/{name}")
async def person(request: Request, viewer: Reading, name: str) -> Response:
    store = services(request).store
    found = store.account(name)
    if found is None:
        raise BoardError(404, "no_such_account", f"there is no account {name[:64]!r}")
    if found.kind is AccountKind.ROBOT_AGENT:
        return go(f"/robots/{found.name}")
    mine = viewer.account is not None and viewer.account.id == found.id
    latest = _latest(store, found)
    data = {"account": found, "mine": mine, "latest": latest}
    return show(request, viewer, "account.html", data, here="me" if mine else "")


# ------------------------------------------------------------------ coming and going
@router.get("/sign-in")
async def sign_in_form(request: Request, viewer: Anybody, next: str = "/") -> Response:
    if viewer.account:
        return go(own_path(next))
    return show(request, viewer, "sign_in.html", {"up": False, "next": own_path(next), "draft": ""}, here="sign-in")


@router.get("/sign-up")
async def sign_up_form(request: Request, viewer: Anybody, next: str = "/") -> Response:
    if not services(request).settings.sign_up:
        raise BoardError(403, "sign_up_off", "this forum does not take new accounts by itself")
    return show(request, viewer, "sign_in.html", {"up": True, "next": own_path(next), "draft": ""}, here="sign-in")


@router.post("/sign-in")
async def sign_in(request: Request, viewer: Anybody) -> Response:
    return await _open_session(request, viewer, up=False)


@router.post("/sign-up")
async def sign_up(request: Request, viewer: Anybody) -> Response:
    return await _open_session(request, viewer, up=True)


@router.post("/sign-out")
async def sign_out(request: Request, viewer: Anybody) -> Response:
    access.check_form(viewer, (await _form(request)).get("csrf"))
    response = go("/sign-in")
    await access.sign_out(services(request), viewer, response)
    return response


@router.get("/enter/{secret}")
async def enter_form(request: Request, viewer: Anybody, secret: str) -> Response:
    """Shows a button only: a prefetch of the link spends nothing."""
    return show(request, viewer, "enter.html", {"secret": secret}, here="sign-in")


@router.post("/enter/{secret}")
async def enter(request: Request, viewer: Anybody, secret: str) -> Response:
    access.check_form(viewer, (await _form(request)).get("csrf"))
    known = services(request)
    response = go("/")
    access.set_session(response, known, await access.enter(known, secret))
    return response


@router.get("/static/{version}/{name}")
async def static(version: str, name: str) -> Response:
    return static_file(version, name)


@router.get("/favicon.ico")
async def favicon() -> Response:
    return static_file("", "logo.svg")


# ------------------------------------------------------------------ pieces
async def _open_session(request: Request, viewer: Viewer, *, up: bool) -> Response:
    form = await _form(request)
    name, password, path = _field(form, "name").strip(), _field(form, "password"), own_path(form.get("next"))
    known = services(request)
    address = request.client.host if request.client else ""
    try:
        access.check_form(viewer, form.get("csrf"))
        session = await (access.sign_up if up else access.sign_in)(known, name, password, address)
    except BoardError as e:
        data = {"up": up, "next": path, "draft": name, "problem": _problem(e)}
        return show(request, viewer, "sign_in.html", data, status=e.status, here="sign-in")
    response = go(path)
    access.set_session(response, known, session)
    return response


def _new_topic(
    request: Request,
    viewer: Viewer,
    board_id: str,
    *,
    draft: str = "",
    title: str = "",
    error: BoardError | None = None,
) -> Response:
    known = services(request)
    data: Data = {"board": known.store.board(board_id), "robots": robot_view.robots(known), "key": _nonce()}
    data |= {"draft": draft, "draft_title": title, "problem": _problem(error)}
    return show(request, viewer, "new_topic.html", data, status=error.status if error else 200, here="home")


def _topic(
    request: Request,
    viewer: Viewer,
    topic_id: str,
    after: str | None,
    *,
    draft: str = "",
    error: BoardError | None = None,
) -> Response:
    known = services(request)
    newest = known.store.newest_event_id()  # before the posts are read, so that nothing falls between
    found = known.store.topic(topic_id)
    shown = posts_of_topic(known, viewer, topic_id, after, POSTS)
    data: Data = {"topic": found, "shown": shown, "first_page": not after, "board": known.store.board(found.board_id)}
    data |= {"after": newest, "robots": robot_view.robots(known), "key": _nonce()}
    data |= {"draft": draft, "problem": _problem(error)}
    return show(request, viewer, "topic.html", data, status=error.status if error else 200, here="home")


def _may_not_look(viewer: Viewer) -> bool:
    """Then a form that failed cannot be shown again on its page; what was typed is given back on an error page."""
    return viewer.account is None or viewer.account.suspended


def _latest(store: Store, author: Account, *, once: bool = False) -> list[tuple[Topic, Post]]:
    """An account's latest posts, each with its topic; with `once` only the latest one of each topic."""
    posts = store.posts_by(author, 5 * _LATEST if once else _LATEST)
    newest: dict[str, Post] = {}
    for post in posts:
        newest.setdefault(post.topic_id if once else post.id, post)
    return [(store.topic(post.topic_id), post) for post in list(newest.values())[:_LATEST]]


def _path(store: Store, post: Post, done: str = "") -> str:
    """Where a post is to be seen: the page of its topic that shows it."""
    cursor = store.cursor_before(post.id, POSTS)
    query = "&".join(f"{k}={quote(v, safe='')}" for k, v in (("after", cursor), ("done", done)) if v)
    return f"/t/{post.topic_id}{'?' + query if query else ''}#post-{post.id}"


def _problem(error: BoardError | None) -> str:
    """What went wrong and what would be right, in a line."""
    return f"{sentence(str(error))} {sentence(hint_of(error))}".strip() if error else ""


async def _form(request: Request) -> FormData:
    """The form that was sent; how large it may be is for `gate` to say."""
    return await request.form(max_files=0)


def _field(form: FormData, name: str) -> str:
    """A field as text, with the line ends that people use (browsers send others)."""
    value = form.get(name)
    return value.replace("\r\n", "\n") if isinstance(value, str) else ""


def _checked_title(title: str) -> str:
    """The title on one line. 422 when there is none."""
    line = " ".join("".join(c for c in title if c.isprintable() or c.isspace()).split())
    if not line or len(line) > TITLE_LENGTH:
        raise BoardError(422, "bad_title", "a topic needs a title", f"at most {TITLE_LENGTH} characters")
    return line


def _checked_body(body: str) -> str:
    """The text of a post. 422 when there is none, 413 when it is too long."""
    text = body.replace("\0", "")
    if not text.strip():
        raise BoardError(422, "empty", "a post needs a text")
    if len(text.encode()) > POST_BYTES:
        raise BoardError(413, "post_too_large", "the post is too long", f"at most {POST_BYTES // 1024} KiB")
    return text


def _nonce() -> str:
    return secrets.token_urlsafe(9)


def _key(form: FormData, *content: str) -> str:
    """The same form sent twice with the same content is one post; changed content (after going back) is another."""
    digest = hashlib.sha256("\0".join(content).encode("utf-8", "replace")).hexdigest()[:24]
    nonce = re.sub(r"[^A-Za-z0-9_-]", "", _field(form, "key"))[:32]
    return f"form:{nonce}:{digest}"
