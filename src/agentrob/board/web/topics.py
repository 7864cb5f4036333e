"""The pages of boards, topics and tags."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Form, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board import access
from agentrob.board.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.auth import visibility
from agentrob.board.command_reading import READ_CHARS
from agentrob.board.content import tags, uploads
from agentrob.board.content.unread import UnreadCount
from agentrob.board.db.reader import Reader, not_found
from agentrob.board.db.records import StoredPost, Topic
from agentrob.board.robots import approvals, commands, front, reach, reading
from agentrob.board.robots import view as robot_view
from agentrob.board.robots.abilities import example_commands
from agentrob.board.robots.command_view import captions
from agentrob.board.services import AppServices, Services, get_services
from agentrob.board.web import forms
from agentrob.board.web.forms import Composed, PageForm, Text
from agentrob.board.web.posts import POSTS, SentPost, is_locked_out, named, path_of, previewed
from agentrob.board.web.templating import error_page, error_text, redirect, render_fragment, render_page
from agentrob.errors import BoardError
from agentrob.language.previews.reading import asking_for_preview
from agentrob.model import Page, Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

Data = dict[str, Any]

#: Topics on one page of a tag.
TOPICS = 20
#: How long the author of the newest post is shown why no robot answers it.
JUST_NOW = timedelta(minutes=10)


class TagsForm(PageForm):
    tags: Text = ""


@dataclass(frozen=True, slots=True)
class ShownPosts:
    """The posts of a page as safe HTML, the cursor of the next page, the ids of the first and last post, and the
    accounts that wrote on it or are mentioned."""

    html: str
    next: str | None
    first: str = ""
    last: str = ""
    concerned: frozenset[str] = frozenset()


# ------------------------------------------------------------------ boards and topics
@router.get("/")
async def home(
    request: Request,
    services: AppServices,
    viewer: ReadingViewer,
    after: str | None = None,
    say: str = "",
    room: str = "",
) -> Response:
    """`say` is a command for the box, as in the links of the examples; `room` is the name of the room to show."""
    return _home(request, viewer, Composed(draft=say[:READ_CHARS]), after, room=room)


@router.post("/command")
async def command(request: Request, services: AppServices, viewer: AnyViewer, form: SentPost) -> Response:
    """Post a command as a new topic, on a board of the robot that it addresses; its title is made from it if none is
    given."""
    typed = form.composed
    try:
        author = form.sender(viewer)
        typed = replace(typed, pictures=await form.all_pictures(services, author))
        board_id = reading.board_of(services, form.body)
        if form.do == "preview":
            return _home(request, viewer, await previewed(services, typed, author, board_id))
        text = forms.body(asking_for_preview(form.body) if form.do == "rehearse" else form.body)
        title = forms.title(form.title.strip() or forms.title_of(text) or "A command")
        key, pictures = form.idempotency_key(title, text), [image.id for image in typed.pictures]
        written = await services.store.create_topic(author, board_id, title, text, key=key, images=pictures)
    except BoardError as e:
        if is_locked_out(viewer):
            return await error_page(request, e, draft=typed.draft)
        return _home(request, viewer, typed, error=e)
    return redirect(written.topic.path)


def _home(
    request: Request,
    viewer: Viewer,
    typed: Composed,
    after: str | None = None,
    error: BoardError | None = None,
    room: str = "",
) -> Response:
    services = get_services(request)
    boards = services.store.reader.boards()
    cards, topics = front.now(services, viewer.account), services.store.reader.topics(None, after)
    live = [card.robot for card in cards if card.robot.live] or [card.robot for card in cards]
    data: Data = {"boards": boards, "names": {b.id: b.name for b in boards}, "cards": cards, "first_page": not after}
    data |= {"topics": topics, "news": _news(services, viewer, topics.items), "feed": "/feed.atom"}
    data["answers"] = answers = front.outcomes(services, topics.items)
    data["hidden"] = robot_view.hidden_cameras(services, viewer.account, answers.values())
    data["room_name"] = room
    data["in_room"] = {card.robot.name for card in cards if card.robot.map is not None and card.robot.map.room == room}
    data["examples"] = example_commands([(robot.name, robot.can) for robot in live])
    data |= {"typed": replace(typed, problem=error_text(error)), "key": forms.nonce(), "box_path": "/"}
    data["invites"] = viewer.account is not None and viewer.account.role is Role.ADMIN
    return render_page(request, viewer, "home.html", data, status=error.status if error else 200, here="home")


@router.get("/b/{board_id}")
async def board(
    request: Request, services: AppServices, viewer: ReadingViewer, board_id: str, after: str | None = None
) -> Response:
    newest = services.store.reader.newest_event_id()  # before the topics are read, so that nothing falls between
    topics = services.store.reader.topics(board_id, after)
    data: Data = {
        "board": services.store.reader.board(board_id),
        "topics": topics,
        "robots": robot_view.robots(services),
    }
    data |= {
        "after": newest,
        "feed": f"/b/{board_id}/feed.atom",
        "news": _news(services, viewer, topics.items),
    }
    return render_page(request, viewer, "board.html", data, here="home")


@router.get("/b/{board_id}/new")
async def new_topic(
    request: Request, services: AppServices, viewer: ReadingViewer, board_id: str, to: str = ""
) -> Response:
    access.account_of(viewer)
    account = services.store.reader.account(to)
    return _new_topic(request, viewer, board_id, Composed(draft=f"@{account.name} " if account else ""))


@router.post("/b/{board_id}/new")
async def create_topic(
    request: Request, services: AppServices, viewer: AnyViewer, board_id: str, form: SentPost
) -> Response:
    typed = form.composed
    try:
        author = form.sender(viewer)
        typed = replace(typed, pictures=await form.all_pictures(services, author))
        if form.do == "preview":
            return _new_topic(request, viewer, board_id, await previewed(services, typed, author, board_id))
        checked, found = (forms.title(form.title), forms.body(form.body)), forms.tags_of(form.tags)
        key, pictures = form.idempotency_key(*checked), [image.id for image in typed.pictures]
        written = await services.store.create_topic(author, board_id, *checked, key=key, images=pictures, tags=found)
    except BoardError as e:
        if is_locked_out(viewer) or e.code == "no_such_board":
            return await error_page(request, e, draft=typed.draft)
        return _new_topic(request, viewer, board_id, typed, e)
    return redirect(written.topic.path)


@router.get("/t/{topic_id}")
async def topic(
    request: Request,
    services: AppServices,
    viewer: ReadingViewer,
    topic_id: str,
    after: str | None = None,
    reply_to: str = "",
    quote: str = "",
    again: str = "",
) -> Response:
    """`reply_to` and `quote` are posts to reply to; `quote` also puts the quoted text into the form. `again` is a post
    with a command, which is put into the form."""
    typed = Composed()
    if again and viewer.account:
        post = services.store.reader.post(again)
        typed = Composed(draft=post.raw) if post.topic_id == topic_id and not post.removed else typed
    if (answered := reply_to or quote) and viewer.account:
        post = services.store.reader.post(answered)
        if post.topic_id == topic_id and not post.removed:
            typed = Composed(draft=forms.quoted(post.raw) if quote else "", reply_to=post.id)
    return _topic(request, viewer, topic_id, after, typed)


@router.post("/t/{topic_id}/reply")
async def reply(request: Request, services: AppServices, viewer: AnyViewer, topic_id: str, form: SentPost) -> Response:
    typed, store = form.composed, services.store
    try:
        author = form.sender(viewer)
        typed = replace(typed, pictures=await form.all_pictures(services, author))
        if form.do == "preview":
            board_id = store.reader.topic(topic_id).board_id
            return _topic(request, viewer, topic_id, None, await previewed(services, typed, author, board_id))
        text, pictures = forms.body(form.body), [image.id for image in typed.pictures]
        key = form.idempotency_key(topic_id, text)
        written = await store.reply(author, topic_id, text, key=key, reply_to=form.reply_to or None, images=pictures)
    except BoardError as e:
        if is_locked_out(viewer) or e.code == "no_such_topic":
            return await error_page(request, e, draft=typed.draft)
        return _topic(request, viewer, topic_id, None, typed, e)
    return redirect(path_of(store, written.post))


# ------------------------------------------------------------------ tags
@router.get("/tags")
async def tag_list(request: Request, services: AppServices, viewer: ReadingViewer) -> Response:
    found = await services.store.beside(tags.listed)
    return render_page(request, viewer, "tags.html", {"found": found}, here="latest")


@router.get("/tags/{tag}")
async def tag_page(
    request: Request, services: AppServices, viewer: ReadingViewer, tag: str, after: str | None = None
) -> Response:
    named = tags.plain(tag)
    if not named:
        raise not_found("tag", tag)
    if named != tag:
        return redirect(f"/tags/{named}")
    page = await services.store.beside(Reader.topics, None, after, TOPICS, named)
    data: dict[str, Any] = {
        "tag": named,
        "topics": page,
        "names": services.store.reader.board_names(),
        "feed": f"/tags/{named}/feed.atom",
    }
    return render_page(request, viewer, "tag.html", data | {"news": _news(services, viewer, page.items)}, here="latest")


@router.get("/t/{topic_id}/tags")
async def tags_form(request: Request, services: AppServices, viewer: ReadingViewer, topic_id: str) -> Response:
    topic = services.store.reader.topic(topic_id)
    return _choose(request, viewer, topic, ", ".join(topic.tags))


@router.post("/t/{topic_id}/tags")
async def choose_tags(
    request: Request, services: AppServices, viewer: AnyViewer, topic_id: str, form: Annotated[TagsForm, Form()]
) -> Response:
    by, store, most = form.sender(viewer), services.store, services.settings.limits.posts
    topic = store.reader.topic(topic_id)
    try:
        found = forms.tags_of(form.tags)
        await store.do(lambda t: tags.change(t, by, topic_id, found, most))
    except BoardError as e:
        if e.status not in (422, 429):
            raise
        return _choose(request, viewer, topic, form.tags, e)
    return redirect(topic.path)


def _choose(request: Request, viewer: Viewer, topic: Topic, typed: str, error: BoardError | None = None) -> Response:
    if not tags.may_change(access.account_of(viewer), topic):
        raise BoardError(403, "not_yours", "only the author of a topic and moderators choose its tags")
    data = {"topic": topic, "typed": typed, "problem": error_text(error)}
    return render_page(request, viewer, "topic_tags.html", data, status=error.status if error else 200)


# ------------------------------------------------------------------ pieces
def _new_topic(
    request: Request, viewer: Viewer, board_id: str, typed: Composed, error: BoardError | None = None
) -> Response:
    services = get_services(request)
    data: Data = {
        "board": services.store.reader.board(board_id),
        "robots": robot_view.robots(services),
        "key": forms.nonce(),
    }
    data["acting"] = reach.acting_on(board_id, services)
    data |= {"typed": replace(typed, problem=error_text(error)), "may_upload": uploads.may(viewer.account)}
    return render_page(request, viewer, "new_topic.html", data, status=error.status if error else 200, here="home")


def _topic(
    request: Request,
    viewer: Viewer,
    topic_id: str,
    after: str | None,
    typed: Composed,
    error: BoardError | None = None,
) -> Response:
    services = get_services(request)
    newest = services.store.reader.newest_event_id()  # before the posts are read, so that nothing falls between
    found = services.store.reader.topic(topic_id)
    shown = _shown_posts(services, viewer, topic_id, after, POSTS)
    data: Data = {
        "topic": found,
        "shown": shown,
        "first_page": not after,
        "board": services.store.reader.board(found.board_id),
    }
    data |= {"after": newest, "robots": robot_view.robots(services), "key": forms.nonce()}
    data["cards"] = front.now(services, viewer.account, pictures=False)
    data |= {"typed": replace(typed, problem=error_text(error)), "may_upload": uploads.may(viewer.account)}
    answered = named(services.store, [typed.reply_to])
    data |= {"feed": f"/t/{found.id}/feed.atom", "authors": answered}
    data |= {
        "acting": reach.acting_on(found.board_id, services),
        "unreached": _unreached(services, viewer, found, shown),
    }
    data["news"] = services.marks.news(services.store.reader, viewer.account, (found,)).get(found.id)
    data["may_tag"] = viewer.account is not None and tags.may_change(viewer.account, found)
    services.marks.showed(services.store.reader, viewer.account, found, shown.last)  # from now on it counts as read
    return render_page(request, viewer, "topic.html", data, status=error.status if error else 200, here="home")


def _unreached(services: Services, viewer: Viewer, topic: Topic, shown: ShownPosts) -> str:
    """Why no robot will answer the post that this viewer has just written at the end of the topic; else empty."""
    if viewer.account is None or shown.next or not shown.last:
        return ""
    newest = services.store.reader.post(shown.last)
    just_now = datetime.now(UTC) - newest.created_at < JUST_NOW
    if newest.removed or newest.author.id != viewer.account.id or not just_now:
        return ""
    return reach.hint(services, topic.board_id, newest.raw)


def _news(services: Services, viewer: Viewer, topics: Collection[Topic]) -> dict[str, UnreadCount]:
    """Count the viewer's unread posts in these topics, by topic."""
    return services.marks.news(services.store.reader, viewer.account, topics)


def _shown_posts(services: Services, viewer: Viewer, topic_id: str, after: str | None, limit: int) -> ShownPosts:
    """The posts of one page as HTML, cached until one of them changes: most of the time of a page is spent on them.

    404, and 422 for a bad cursor.
    """

    def make() -> tuple[ShownPosts, int]:
        page: Page[StoredPost] = services.store.reader.posts(topic_id, after, limit)
        hidden = robot_view.hidden_cameras(services, viewer.account, page.items)
        authors = {post.id: post.author.name for post in page.items}
        data: dict[str, object] = {"posts": page.items, "viewer": viewer, "authors": authors, "hidden": hidden}
        data["owners"] = robot_view.owners(services, page.items)
        data |= {"asking": approvals.in_thread(services, page.items, viewer.account), "key": forms.nonce()}
        data["captions"] = captions(services.store.reader, page.items)
        html = render_fragment("topic_posts.html", data)
        first, last = (page.items[0].id, page.items[-1].id) if page.items else ("", "")
        concerned = frozenset(name for post in page.items for name in (post.author.name, *post.mentions))
        return ShownPosts(html, page.next, first, last, concerned), len(html)

    form = viewer.csrf if viewer.account else ""  # in the buttons
    recorded = commands.newest_record_us(services.store.reader, topic_id)  # records are not events
    return services.topic_cache.of(
        services.store.reader, topic_id, (after, viewer.account, form, visibility.readable_boards(), recorded), make
    )
