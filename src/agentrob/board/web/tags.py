"""Pages that order topics: by tag, and by what is new for whoever looks; and the form for a topic's tags."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from fastapi import APIRouter, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.auth import access
from agentrob.board.auth.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.content import tags
from agentrob.board.content.unread import UnreadCount
from agentrob.board.db.reader import Reader, not_found
from agentrob.board.db.records import Topic
from agentrob.board.services import AppServices, Services
from agentrob.board.web import forms
from agentrob.board.web.templating import go, show
from agentrob.errors import BoardError

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

#: Topics on one page.
TOPICS = 20


def news(services: Services, viewer: Viewer, topics: Collection[Topic]) -> dict[str, UnreadCount]:
    """What is new in topics for whoever looks, by topic."""
    return services.marks.news(services.store.reader, viewer.account, topics)


# ------------------------------------------------------------------ what is new
@router.get("/unread")
async def unread(request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None) -> Response:
    account = access.account_of(viewer)
    store = services.store
    newest = store.reader.newest_post_id()
    page = services.marks.unread(store.reader, account, after, TOPICS)
    data: dict[str, Any] = {"topics": [topic for topic, _ in page.items], "next": page.next, "newest": newest}
    data |= {"news": {topic.id: new for topic, new in page.items}, "names": _boards(services)}
    return show(request, viewer, "unread.html", data, here="latest")


@router.post("/unread/all-read")
async def all_read(request: Request, services: AppServices, viewer: AnyViewer) -> Response:
    form = await forms.read_checked(request, viewer)
    account, up_to = access.account_of(viewer), forms.field(form, "up_to")
    if up_to.isascii() and up_to.isdigit() and len(up_to) < 19:
        await services.marks.all_read(services.store, account, int(up_to))
    return go("/unread")


# ------------------------------------------------------------------ tags
@router.get("/tags")
async def listed(request: Request, services: AppServices, viewer: ReadingViewer) -> Response:
    found = await services.store.beside(tags.listed)
    return show(request, viewer, "tags.html", {"found": found}, here="latest")


@router.get("/tags/{tag}")
async def tagged(
    request: Request, services: AppServices, viewer: ReadingViewer, tag: str, after: str | None = None
) -> Response:
    named = tags.plain(tag)
    if not named:
        raise not_found("tag", tag)
    if named != tag:
        return go(f"/tags/{named}")
    page = await services.store.beside(Reader.topics, None, after, TOPICS, named)
    data: dict[str, Any] = {
        "tag": named,
        "topics": page,
        "names": _boards(services),
        "feed": f"/tags/{named}/feed.atom",
    }
    return show(request, viewer, "tag.html", data | {"news": news(services, viewer, page.items)}, here="latest")


@router.get("/t/{topic_id}/tags")
async def choose(request: Request, services: AppServices, viewer: ReadingViewer, topic_id: str) -> Response:
    topic = services.store.topic(topic_id)
    return _choose(request, viewer, topic, ", ".join(topic.tags))


@router.post("/t/{topic_id}/tags")
async def chosen(request: Request, services: AppServices, viewer: AnyViewer, topic_id: str) -> Response:
    form, store, most = (
        await forms.read(request),
        services.store,
        services.settings.limits.posts,
    )
    access.check_form(viewer, form.get("csrf"))
    by, topic = access.account_of(viewer), store.topic(topic_id)
    try:
        found = forms.tags_of(form)
        await store.do(lambda t: tags.change(t, by, topic_id, found, most))
    except BoardError as e:
        if e.status not in (422, 429):
            raise
        return _choose(request, viewer, topic, forms.field(form, "tags"), e)
    return go(topic.path)


def _choose(request: Request, viewer: Viewer, topic: Topic, typed: str, error: BoardError | None = None) -> Response:
    if not tags.may_change(access.account_of(viewer), topic):
        raise BoardError(403, "not_yours", "only who began a topic and moderators choose its tags")
    data = {"topic": topic, "typed": typed, "problem": forms.problem(error)}
    return show(request, viewer, "topic_tags.html", data, status=error.status if error else 200)


def _boards(services: Services) -> dict[str, str]:
    return {board.id: board.name for board in services.store.boards()}
