"""Pages for finding things: search, the latest posts, notifications; and what forms ask while somebody writes."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

from fastapi import APIRouter, Form, Request
from sqlalchemy import and_, select
from starlette.responses import HTMLResponse, JSONResponse, Response

from agentrob.board.auth import access
from agentrob.board.auth.access import AnyViewer, ReadingViewer
from agentrob.board.content import notifications, reach, tags
from agentrob.board.content.store import SearchMode
from agentrob.board.db import schema as db
from agentrob.board.db.records import StoredPost, Topic
from agentrob.board.robots import view as robot_view
from agentrob.board.search import search
from agentrob.board.services import AppServices, Services
from agentrob.board.web import forms
from agentrob.board.web.forms import Composed
from agentrob.board.web.templating import go, show
from agentrob.errors import BoardError
from agentrob.model import Account, Page

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

_NO_STORE = {"Cache-Control": "no-store"}
#: Names that are offered while somebody writes one.
NAMES = 8


# ------------------------------------------------------------------ search and latest
@router.get("/search")
async def search_page(
    request: Request,
    services: AppServices,
    viewer: ReadingViewer,
    q: str = "",
    board: str = "",
    tag: str = "",
    after: str | None = None,
    by: SearchMode = "words",
) -> Response:
    """`board` and `tag` narrow it when they are not empty."""
    problem, status = "", 200
    page: Page[StoredPost] = Page(())
    try:
        query = search.checked(q)
        page = await services.store.search(query, after, board_id=board or None, mode=by, tag=tags.plain(tag) or None)
    except BoardError as e:
        query, problem, status = q[: search.MAX_QUERY], forms.problem(e), e.status
    found = [(topic, post, search.around(post.raw, query)) for topic, post in _with_topics(services, page.items)]
    data: dict[str, Any] = {"query": query, "found": found, "next": page.next, "problem": problem}
    data |= {"by": by, "modes": services.store.search_modes, "boards": services.store.boards()}
    data |= {"board": board, "tag": tags.plain(tag)}
    return show(request, viewer, "search.html", data, status=status, here="search")


@router.get("/latest")
async def latest(request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None) -> Response:
    page = services.store.reader.latest_posts(after, 30)
    data = {"latest": _with_topics(services, page.items), "next": page.next, "feed": "/feed.atom"}
    return show(request, viewer, "latest.html", data, here="latest")


def _with_topics(services: Services, posts: tuple[StoredPost, ...]) -> list[tuple[Topic, StoredPost]]:
    topics = {topic_id: services.store.topic(topic_id) for topic_id in {post.topic_id for post in posts}}
    return [(topics[post.topic_id], post) for post in posts]


# ------------------------------------------------------------------ notifications
@router.get("/notifications")
async def notifications_page(
    request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None
) -> Response:
    account = access.account_of(viewer)
    page = notifications.latest(services.store.reader, account, after)
    found = [(services.store.topic(n.post.topic_id), n) for n in page.items]
    data: dict[str, Any] = {
        "found": found,
        "next": page.next,
        "reasons": notifications.REASONS,
        "first_page": not after,
    }
    return show(request, viewer, "notifications.html", data, here="notifications")


@router.get("/notifications/count")
async def count(request: Request, viewer: ReadingViewer) -> Response:
    """The number at the bell."""
    return show(request, viewer, "bell.html", {})


@router.post("/notifications/seen")
async def seen(request: Request, services: AppServices, viewer: AnyViewer) -> Response:
    form = await forms.read_checked(request, viewer)
    account, up_to = access.account_of(viewer), forms.field(form, "up_to")
    if up_to.isascii() and up_to.isdigit() and len(up_to) < 19:
        await services.store.do(lambda t: notifications.mark_seen(t, account, int(up_to)))
    return go("/notifications")


# ------------------------------------------------------------------ while somebody writes
@router.post("/preview")
async def preview(
    request: Request,
    services: AppServices,
    viewer: AnyViewer,
    csrf: Annotated[str, Form()],
    body: Annotated[str, Form()],
    board: Annotated[str, Form()] = "",
) -> Response:
    """How a text would look, and whether a robot would answer it on that board; nothing is kept."""
    access.check_form(viewer, csrf)
    account = access.account_of(viewer)
    shown = await previewed(services, Composed(draft=body.replace("\r\n", "\n")), account, board)
    return show(request, viewer, "preview.html", {"typed": shown})


async def previewed(services: Services, typed: Composed, by: Account, board_id: str = "") -> Composed:
    """The form with its text as it would look. 413 when it is too long; an empty text looks empty. 422, 429, 503."""
    text = forms.body(typed.draft) if typed.draft.strip() else ""
    hint = reach.hint(services, board_id, text) if board_id else ""
    return replace(typed, preview=(await services.store.renderer.render(text, by)).html, hint=hint)


@router.get("/names")
async def names(request: Request, services: AppServices, viewer: ReadingViewer, q: str = "") -> Response:
    """Who may be meant by the beginning of a name: robots with their state first, then people."""
    access.account_of(viewer)
    begun = q.lower()[:32]
    robots = [r for r in robot_view.robots(services) if r.name.startswith(begun)]
    found = [
        {"name": r.name, "robot": True, "live": r.live, "state": (r.state or "online") if r.live else "not connected"}
        for r in robots
    ]
    others = _named(services, begun, NAMES + len(robots)) if begun else ()
    taken = {r["name"] for r in found}
    found += [{"name": n, "robot": False, "live": False, "state": ""} for n in others if n not in taken]
    return JSONResponse(found[:NAMES], headers=_NO_STORE)


def _named(services: Services, begun: str, limit: int) -> tuple[str, ...]:
    """Names of accounts that begin so and are not suspended, in their order."""
    a = db.accounts.c
    begins = and_(a.name >= begun, a.name < begun + "\x7f", a.suspended.is_(False))
    return tuple(r.name for r in services.store.reader.rows(select(a.name).where(begins).order_by(a.name).limit(limit)))
