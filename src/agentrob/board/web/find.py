"""Pages for finding posts: search, latest, unread and notifications."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Form, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board import access
from agentrob.board.access import AnyViewer, ReadingViewer
from agentrob.board.content import excerpts, notifications, tags
from agentrob.board.content.store import SearchMode
from agentrob.board.db.records import StoredPost, Topic
from agentrob.board.search import search
from agentrob.board.services import AppServices, Services
from agentrob.board.web.forms import Line, PageForm, post_number
from agentrob.board.web.templating import error_text, redirect, render_page
from agentrob.errors import BoardError
from agentrob.model import Page

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

#: Topics on a page of unread ones.
TOPICS = 20


class UpToForm(PageForm):
    """Marks everything up to a post as read or seen."""

    up_to: Line = ""


SentUpTo = Annotated[UpToForm, Form()]


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
    """`board` and `tag` narrow the search unless they are empty."""
    problem, status = "", 200
    page: Page[StoredPost] = Page(())
    try:
        query = search.checked(q)
        page = await services.store.search(query, after, board_id=board or None, mode=by, tag=tags.plain(tag) or None)
    except BoardError as e:
        query, problem, status = q[: search.MAX_QUERY], error_text(e), e.status
    found = [(topic, post, excerpts.around(post.html, query)) for topic, post in _with_topics(services, page.items)]
    data: dict[str, Any] = {"query": query, "found": found, "next": page.next, "problem": problem}
    data |= {"by": by, "modes": services.store.search_modes, "boards": services.store.reader.boards()}
    data |= {"board": board, "tag": tags.plain(tag)}
    return render_page(request, viewer, "search.html", data, status=status, here="search")


@router.get("/latest")
async def latest(request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None) -> Response:
    page = services.store.reader.latest_posts(after, 30)
    data = {"latest": _with_topics(services, page.items), "next": page.next, "feed": "/feed.atom"}
    return render_page(request, viewer, "latest.html", data, here="latest")


def _with_topics(services: Services, posts: tuple[StoredPost, ...]) -> list[tuple[Topic, StoredPost]]:
    topics = {topic_id: services.store.reader.topic(topic_id) for topic_id in {post.topic_id for post in posts}}
    return [(topics[post.topic_id], post) for post in posts]


# ------------------------------------------------------------------ notifications
@router.get("/notifications")
async def notifications_page(
    request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None
) -> Response:
    account = access.account_of(viewer)
    page = notifications.latest(services.store.reader, account, after, read=services.marks.unwritten(account))
    found = [(services.store.reader.topic(n.post.topic_id), n) for n in page.items]
    data: dict[str, Any] = {
        "found": found,
        "next": page.next,
        "reasons": notifications.REASONS,
        "first_page": not after,
    }
    return render_page(request, viewer, "notifications.html", data, here="notifications")


@router.get("/notifications/count")
async def count(request: Request, viewer: ReadingViewer) -> Response:
    """The number of unread notifications."""
    return render_page(request, viewer, "bell.html", {})


@router.post("/notifications/seen")
async def seen(services: AppServices, viewer: AnyViewer, form: SentUpTo) -> Response:
    account, up_to = form.sender(viewer), post_number(form.up_to)
    if up_to is not None:
        await services.store.do(lambda t: notifications.mark_seen(t, account, up_to))
    return redirect("/notifications")


# ------------------------------------------------------------------ unread topics
@router.get("/unread")
async def unread(request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None) -> Response:
    account = access.account_of(viewer)
    store = services.store
    newest = store.reader.newest_post_id()
    page = services.marks.unread(store.reader, account, after, TOPICS)
    data: dict[str, Any] = {"topics": [topic for topic, _ in page.items], "next": page.next, "newest": newest}
    data |= {"news": {topic.id: new for topic, new in page.items}, "names": services.store.reader.board_names()}
    return render_page(request, viewer, "unread.html", data, here="latest")


@router.post("/unread/all-read")
async def all_read(services: AppServices, viewer: AnyViewer, form: SentUpTo) -> Response:
    account, up_to = form.sender(viewer), post_number(form.up_to)
    if up_to is not None:
        await services.marks.all_read(services.store, account, up_to)
    return redirect("/unread")
