"""The pages of the embedded forum: plain HTML and forms that work without scripts, and become live with them."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

from fastapi import APIRouter, Request
from starlette.datastructures import FormData
from starlette.responses import HTMLResponse, Response

from agentrob.board.auth import access
from agentrob.board.auth.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.content import reach, tags, uploads
from agentrob.board.db.records import StoredPost, Topic
from agentrob.board.robots import view as robot_view
from agentrob.board.services import AppServices, Services, get_services
from agentrob.board.web import api_docs, feeds, find, forms
from agentrob.board.web import commands as pages_command
from agentrob.board.web import posts as pages_posts
from agentrob.board.web import robots as pages_robots
from agentrob.board.web import tags as pages_tags
from agentrob.board.web.find import previewed
from agentrob.board.web.forms import Composed
from agentrob.board.web.posts import POSTS, may_not_look, path_of
from agentrob.board.web.templating import error_page, go, own_path, show, static_file
from agentrob.board.web.topic_posts import Shown, posts_of_topic
from agentrob.errors import BoardError
from agentrob.model import Account

__all__ = ["error_page", "router"]

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

Data = dict[str, Any]

#: How long the author of the newest post is told that no robot answers it.
JUST_NOW = timedelta(minutes=10)


# ------------------------------------------------------------------ boards and topics
@router.get("/")
async def home(request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None) -> Response:
    boards = services.store.boards()
    data: Data = {"boards": boards, "names": {b.id: b.name for b in boards}, "robots": robot_view.robots(services)}
    topics = services.store.latest(after)
    data |= {"topics": topics, "news": pages_tags.news(services, viewer, topics.items), "feed": "/feed.atom"}
    return show(request, viewer, "home.html", data, here="home")


@router.get("/b/{board_id}")
async def board(
    request: Request, services: AppServices, viewer: ReadingViewer, board_id: str, after: str | None = None
) -> Response:
    newest = services.store.newest_event_id()  # before the topics are read, so that nothing falls between
    topics = services.store.topics(board_id, after)
    data: Data = {"board": services.store.board(board_id), "topics": topics, "robots": robot_view.robots(services)}
    data |= {
        "after": newest,
        "feed": f"/b/{board_id}/feed.atom",
        "news": pages_tags.news(services, viewer, topics.items),
    }
    return show(request, viewer, "board.html", data, here="home")


@router.get("/b/{board_id}/new")
async def new_topic(
    request: Request, services: AppServices, viewer: ReadingViewer, board_id: str, to: str = ""
) -> Response:
    access.account_of(viewer)
    account = services.store.account(to)
    return _new_topic(request, viewer, board_id, Composed(draft=f"@{account.name} " if account else ""))


@router.post("/b/{board_id}/new")
async def create_topic(request: Request, services: AppServices, viewer: AnyViewer, board_id: str) -> Response:
    form = await forms.read(request)
    typed = Composed(forms.field(form, "body"), forms.field(form, "title"), forms.field(form, "tags"))
    try:
        access.check_form(viewer, form.get("csrf"))
        author = access.account_of(viewer)
        typed = replace(typed, pictures=await forms.pictures(services, form, author))
        if form.get("do") == "preview":
            return _new_topic(request, viewer, board_id, await previewed(services, typed, author, board_id))
        checked, found = (forms.title(typed.title), forms.body(typed.draft)), forms.tags_of(form)
        key, pictures = forms.key(form, *checked), [image.id for image in typed.pictures]
        written = await services.store.create_topic(author, board_id, *checked, key=key, images=pictures, tags=found)
    except BoardError as e:
        if may_not_look(viewer) or e.code == "no_such_board":
            return await error_page(request, e, draft=typed.draft)
        return _new_topic(request, viewer, board_id, typed, e)
    return go(written.topic.path)


@router.get("/t/{topic_id}")
async def topic(
    request: Request,
    services: AppServices,
    viewer: ReadingViewer,
    topic_id: str,
    after: str | None = None,
    reply_to: str = "",
    quote: str = "",
) -> Response:
    """`reply_to` and `quote` are posts that are to be answered: then the form says so and has what is quoted."""
    typed = Composed()
    if (answered := reply_to or quote) and viewer.account:
        post = services.store.post(answered)
        if post.topic_id == topic_id and not post.removed:
            typed = Composed(draft=forms.quoted(post.raw) if quote else "", reply_to=post.id)
    return _topic(request, viewer, topic_id, after, typed)


@router.post("/t/{topic_id}/reply")
async def reply(request: Request, services: AppServices, viewer: AnyViewer, topic_id: str) -> Response:
    form = await forms.read(request)
    typed = Composed(forms.field(form, "body"), reply_to=forms.field(form, "reply_to"))
    try:
        access.check_form(viewer, form.get("csrf"))
        author = access.account_of(viewer)
        typed = replace(typed, pictures=await forms.pictures(services, form, author))
        if form.get("do") == "preview":
            board_id = services.store.topic(topic_id).board_id
            return _topic(request, viewer, topic_id, None, await previewed(services, typed, author, board_id))
        written = await _replied(request, author, topic_id, typed, form)
    except BoardError as e:
        if may_not_look(viewer) or e.code == "no_such_topic":
            return await error_page(request, e, draft=typed.draft)
        return _topic(request, viewer, topic_id, None, typed, e)
    return go(path_of(services.store, written))


async def _replied(request: Request, author: Account, topic_id: str, typed: Composed, form: FormData) -> StoredPost:
    text, pictures = forms.body(typed.draft), [image.id for image in typed.pictures]
    key = forms.key(form, topic_id, text)
    answered = typed.reply_to or None
    store = get_services(request).store
    return (await store.reply(author, topic_id, text, key=key, reply_to=answered, images=pictures)).post


# ------------------------------------------------------------------ coming and going
@router.get("/sign-in")
async def sign_in_form(request: Request, viewer: AnyViewer, next: str = "/") -> Response:
    if viewer.account:
        return go(own_path(next))
    return show(request, viewer, "sign_in.html", {"up": False, "next": own_path(next), "draft": ""}, here="sign-in")


@router.get("/sign-up")
async def sign_up_form(request: Request, services: AppServices, viewer: AnyViewer, next: str = "/") -> Response:
    if not services.settings.sign_up:
        raise BoardError(403, "sign_up_off", "this forum does not take new accounts by itself")
    return show(request, viewer, "sign_in.html", {"up": True, "next": own_path(next), "draft": ""}, here="sign-in")


@router.post("/sign-in")
async def sign_in(request: Request, viewer: AnyViewer) -> Response:
    return await _open_session(request, viewer, up=False)


@router.post("/sign-up")
async def sign_up(request: Request, viewer: AnyViewer) -> Response:
    return await _open_session(request, viewer, up=True)


@router.post("/sign-out")
async def sign_out(request: Request, services: AppServices, viewer: AnyViewer) -> Response:
    await forms.read_checked(request, viewer)
    response = go("/sign-in")
    await access.sign_out(services, viewer, response)
    return response


@router.get("/enter/{secret}")
async def enter_form(request: Request, viewer: AnyViewer, secret: str) -> Response:
    """Shows a button only: a prefetch of the link spends nothing."""
    return show(request, viewer, "enter.html", {"secret": secret}, here="sign-in")


@router.post("/enter/{secret}")
async def enter(request: Request, services: AppServices, viewer: AnyViewer, secret: str) -> Response:
    await forms.read_checked(request, viewer)
    response = go("/")
    access.set_session(response, services, await access.enter(services, secret))
    return response


@router.get("/static/{version}/{name}")
async def static(version: str, name: str) -> Response:
    return static_file(version, name)


@router.get("/favicon.ico")
async def favicon() -> Response:
    return static_file("", "logo.svg")


# ------------------------------------------------------------------ pieces
async def _open_session(request: Request, viewer: Viewer, *, up: bool) -> Response:
    form = await forms.read(request)
    name, password, path = forms.field(form, "name").strip(), forms.field(form, "password"), own_path(form.get("next"))
    services = get_services(request)
    try:
        access.check_form(viewer, form.get("csrf"))
        session = await (access.sign_up if up else access.sign_in)(services, name, password, forms.address(request))
    except BoardError as e:
        data = {"up": up, "next": path, "draft": name, "problem": forms.problem(e)}
        return show(request, viewer, "sign_in.html", data, status=e.status, here="sign-in")
    response = go(path)
    access.set_session(response, services, session)
    return response


def _new_topic(
    request: Request, viewer: Viewer, board_id: str, typed: Composed, error: BoardError | None = None
) -> Response:
    services = get_services(request)
    data: Data = {"board": services.store.board(board_id), "robots": robot_view.robots(services), "key": forms.nonce()}
    data["acting"] = reach.acting_on(board_id, services)
    data |= {"typed": replace(typed, problem=forms.problem(error)), "may_upload": uploads.may(viewer.account)}
    return show(request, viewer, "new_topic.html", data, status=error.status if error else 200, here="home")


def _topic(
    request: Request,
    viewer: Viewer,
    topic_id: str,
    after: str | None,
    typed: Composed,
    error: BoardError | None = None,
) -> Response:
    services = get_services(request)
    newest = services.store.newest_event_id()  # before the posts are read, so that nothing falls between
    found = services.store.topic(topic_id)
    shown = posts_of_topic(services, viewer, topic_id, after, POSTS)
    data: Data = {
        "topic": found,
        "shown": shown,
        "first_page": not after,
        "board": services.store.board(found.board_id),
    }
    data |= {"after": newest, "robots": robot_view.robots(services), "key": forms.nonce()}
    data |= {"typed": replace(typed, problem=forms.problem(error)), "may_upload": uploads.may(viewer.account)}
    answered = pages_posts.named(services.store, [typed.reply_to])
    data |= {"feed": f"/t/{found.id}/feed.atom", "authors": answered}
    data |= {
        "acting": reach.acting_on(found.board_id, services),
        "unreached": _unreached(services, viewer, found, shown),
    }
    data["news"] = services.marks.news(services.store.reader, viewer.account, (found,)).get(found.id)
    data["may_tag"] = viewer.account is not None and tags.may_change(viewer.account, found)
    services.marks.showed(services.store.reader, viewer.account, found, shown.last)  # from now on it is read
    return show(request, viewer, "topic.html", data, status=error.status if error else 200, here="home")


def _unreached(services: Services, viewer: Viewer, topic: Topic, shown: Shown) -> str:
    """Why no robot answers what this viewer has just posted at the end of the topic; empty otherwise."""
    if viewer.account is None or shown.next or not shown.last:
        return ""
    newest = services.store.post(shown.last)
    just_now = datetime.now(UTC) - newest.created_at < JUST_NOW
    if newest.removed or newest.author.id != viewer.account.id or not just_now:
        return ""
    return reach.hint(services, topic.board_id, newest.raw)


# last: a request tries one address after the other, and most ask for a topic
for part in (pages_posts, pages_robots, pages_command, find, pages_tags, feeds, api_docs):
    router.include_router(part.router)
