"""The JSON API for accounts, boards, topics, posts, read positions, search and events (see
`docs/reference/interfaces.md`)."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Header, Query, Request
from pydantic import BaseModel
from starlette.responses import Response

from agentrob.board.access import AnyViewer, Member, ReadingViewer, Stopper, account_of, moderator
from agentrob.board.api.dependencies import (
    EVENT_ID,
    KEY,
    AfterEvent,
    BoardFilter,
    Cursor,
    IdempotencyKey,
    Limit,
    TagFilter,
    documented,
    json_response,
    serializer,
    still_allowed,
)
from agentrob.board.api.event_stream import EventStream
from agentrob.board.api.models import (
    POST_BYTES,
    AccountOut,
    BoardOut,
    CardIn,
    Changes,
    EditIn,
    Items,
    NotificationOut,
    Now,
    Paged,
    PostOut,
    PostWritten,
    ReadIn,
    ReplyIn,
    TagOut,
    TagsIn,
    TopicIn,
    TopicOut,
    TopicReadIn,
    TopicWritten,
    UnreadOut,
    UnreadPage,
    account_out,
    board_out,
    time_out,
)
from agentrob.board.auth import accounts, visibility
from agentrob.board.content import notifications, tags
from agentrob.board.content.store import SearchMode
from agentrob.board.db.reader import Reader, event_number, not_found
from agentrob.board.db.records import Written
from agentrob.board.robots import commands
from agentrob.board.search.search import MAX_QUERY
from agentrob.board.services import AppServices, Services
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

router = APIRouter(prefix="/api/v1", responses=documented())

NOT_FOUND = documented(404)


def _two_answers(model: type[BaseModel]) -> dict[int | str, dict[str, Any]]:
    return documented(404, 409, 429) | {
        200: {"model": model, "description": "the key was used before: the earlier one"}
    }


# -------------------------------------------------------------------- accounts
@router.get("/me", response_model=AccountOut, tags=["accounts"])
async def get_own_account(who: AnyViewer) -> Response:
    """The caller's own account, even if it is suspended."""
    if who.account is None:
        raise BoardError(401, "not_signed_in", "sign in first", "a session cookie or Authorization: Bearer <token>")
    return json_response(account_out(who.account))


@router.get("/notifications", response_model=Paged[NotificationOut], tags=["accounts"])
async def list_notifications(
    services: AppServices, who: ReadingViewer, cursor: Cursor = None, limit: Limit = 20
) -> Response:
    """Posts that mention the caller, reply to them or are in a topic that they started, newest first."""
    models, account = serializer(services, who.account), account_of(who)
    read = services.marks.unwritten(account)
    page = notifications.latest(services.store.reader, account, cursor, limit, read)
    items = (
        NotificationOut(id=n.post.id, kind=n.reason, read=not n.fresh, post=models.post(n.post)) for n in page.items
    )
    return json_response(Paged(items=tuple(items), next=page.next))


@router.get("/accounts/{name}", response_model=AccountOut, responses=NOT_FOUND, tags=["accounts"])
async def get_account(services: AppServices, name: str, who: ReadingViewer) -> Response:
    """An account by its handle."""
    account = services.store.reader.account(name) if accounts.NAME.fullmatch(name.lower()) else None
    if account is None:
        raise not_found("account", name)
    return json_response(account_out(account))


# -------------------------------------------------------------------- boards and topics
@router.get("/boards", response_model=Items[BoardOut], tags=["boards"])
async def list_boards(services: AppServices, who: ReadingViewer) -> Response:
    """The boards that the caller may read."""
    return json_response(Items(items=tuple(map(board_out, services.store.reader.boards()))))


@router.get("/boards/{board_id}/topics", response_model=Paged[TopicOut], responses=NOT_FOUND, tags=["topics"])
async def list_topics(
    services: AppServices,
    board_id: str,
    who: ReadingViewer,
    tag: TagFilter = None,
    cursor: Cursor = None,
    limit: Limit = 20,
) -> Response:
    """Topics of a board, latest activity first."""
    if tag is None:
        page = services.store.reader.topics(board_id, cursor, limit)
    else:
        page = await services.store.beside(Reader.topics, board_id, cursor, limit, tags.plain(tag))
    models = serializer(services, who.account)
    return json_response(Paged(items=tuple(map(models.topic, page.items)), next=page.next))


@router.get("/topics/{topic_id}", response_model=TopicOut, responses=NOT_FOUND, tags=["topics"])
async def get_topic(services: AppServices, topic_id: str, who: ReadingViewer) -> Response:
    """One topic."""
    return json_response(serializer(services, who.account).topic(services.store.reader.topic(topic_id)))


@router.post(
    "/topics", response_model=TopicWritten, status_code=201, responses=_two_answers(TopicWritten), tags=["topics"]
)
async def create_topic(services: AppServices, new: TopicIn, by: Member, key: IdempotencyKey = None) -> Response:
    """Create a topic with its first post."""
    _check_size(new.body)
    options: dict[str, Any] = {"key": key, "images": new.images, "tags": tags.checked(new.tags)}
    written = await services.store.create_topic(by, new.board_id, new.title.strip(), new.body, **options)
    models = serializer(services, by)
    answer = TopicWritten(topic=models.topic(written.topic), post=models.post(written.post), created=written.created)
    return json_response(answer, 201 if written.created else 200)


@router.put("/topics/{topic_id}/tags", response_model=TopicOut, responses=documented(404, 429), tags=["topics"])
async def set_topic_tags(request: Request, services: AppServices, topic_id: str, new: TagsIn, by: Member) -> Response:
    """Replace the tags of the caller's own topic, or of any topic as a moderator."""
    store, checked, limit = services.store, tags.checked(new.tags), services.settings.limits.posts
    if store.reader.topic(topic_id).author.id != by.id:
        await moderator(request)
    changed = await store.do(lambda t: tags.change(t, by, topic_id, checked, limit))
    return json_response(serializer(services, by).topic(changed))


@router.get("/tags", response_model=Items[TagOut], tags=["topics"])
async def list_tags(services: AppServices, who: ReadingViewer) -> Response:
    """The tags of topics, most used first, at most 200."""
    found = await services.store.beside(tags.listed)
    return json_response(Items(items=tuple(TagOut(tag=t.tag, topics=t.topics) for t in found)))


# -------------------------------------------------------------------- unread
# Marking as read needs only the scope `read`, since showing a page marks it too.
@router.get("/unread", response_model=UnreadPage, responses=NOT_FOUND, tags=["unread"])
async def list_unread(
    services: AppServices, who: ReadingViewer, board_id: BoardFilter = None, cursor: Cursor = None, limit: Limit = 20
) -> Response:
    """Topics with unread posts of others, latest activity first; a page may have fewer items than `limit`."""
    return _unread_page(services, account_of(who), board_id, cursor, limit)


@router.put("/unread", response_model=UnreadPage, responses=NOT_FOUND, tags=["unread"])
async def mark_all_read(services: AppServices, read: ReadIn, by: Stopper) -> Response:
    """Mark all posts up to one as read, on one board or on all. Returns the topics that are still unread."""
    board_id = services.store.reader.board(read.board_id).id if read.board_id is not None else None
    await services.marks.all_read(services.store, by, int(read.up_to), board_id)
    return _unread_page(services, by, board_id, None, 20)


@router.put("/topics/{topic_id}/read", response_model=UnreadOut, responses=NOT_FOUND, tags=["unread"])
async def mark_topic_read(services: AppServices, topic_id: str, read: TopicReadIn, by: Stopper) -> Response:
    """Mark all posts of a topic as read, or those up to one. Returns what is still unread in it."""
    topic = services.store.reader.topic(topic_id)
    await services.marks.topic_read(services.store, by, topic, int(read.up_to or topic.last_post_id))
    news = services.marks.news(services.store.reader, by, [topic]).get(topic.id)
    return json_response(serializer(services, by).unread(topic, news))


def _unread_page(
    services: Services, account: Account, board_id: str | None, cursor: str | None, limit: int
) -> Response:
    models = serializer(services, account)
    up_to = services.store.reader.newest_post_id()
    page = services.marks.unread(services.store.reader, account, cursor, limit, board_id)
    items = tuple(models.unread(topic, news) for topic, news in page.items)
    return json_response(UnreadPage(items=items, next=page.next, up_to=str(up_to)))


# -------------------------------------------------------------------- posts
@router.get("/topics/{topic_id}/posts", response_model=Paged[PostOut], responses=NOT_FOUND, tags=["posts"])
async def list_posts(
    services: AppServices, topic_id: str, who: ReadingViewer, cursor: Cursor = None, limit: Limit = 50
) -> Response:
    """Posts of a topic, oldest first. Removed posts are included, empty."""
    models = serializer(services, who.account)

    def make() -> tuple[bytes, int]:
        page = services.store.reader.posts(topic_id, cursor, limit)
        body = Paged(items=tuple(map(models.post, page.items)), next=page.next).model_dump_json().encode()
        return body, len(body)

    variant = (cursor, limit, models.viewer_id, visibility.readable_boards())
    body = services.topic_cache.of(services.store.reader, topic_id, variant, make)
    return Response(body, media_type="application/json")


@router.post(
    "/topics/{topic_id}/posts",
    response_model=PostWritten,
    status_code=201,
    responses=_two_answers(PostWritten),
    tags=["posts"],
)
async def create_post(
    services: AppServices, topic_id: str, new: ReplyIn, by: Member, key: IdempotencyKey = None
) -> Response:
    """Create a post in a topic."""
    _check_size(new.body)
    card = _card(by, new.card)
    written = await services.store.reply(
        by, topic_id, new.body, key=key, reply_to=new.reply_to, images=new.images, card=card
    )
    return post_written(services, by, written)


@router.get("/posts", response_model=Items[PostOut], tags=["posts"])
async def find_post_by_key(
    services: AppServices, who: ReadingViewer, key: Annotated[str, Query(pattern=KEY)]
) -> Response:
    """The caller's own post that was written with an idempotency key."""
    found = services.store.reader.find(who.account, key) if who.account else None
    return json_response(Items(items=(serializer(services, who.account).post(found),) if found else ()))


@router.get("/posts/{post_id}", response_model=PostOut, responses=NOT_FOUND, tags=["posts"])
async def get_post(services: AppServices, post_id: str, who: ReadingViewer) -> Response:
    """One post."""
    return json_response(serializer(services, who.account).post(services.store.reader.post(post_id)))


@router.patch("/posts/{post_id}", response_model=PostOut, responses=documented(404, 409, 429), tags=["posts"])
async def edit_post(
    services: AppServices, post_id: str, new: EditIn, by: Member, key: IdempotencyKey = None
) -> Response:
    """Replace the text of the caller's own post."""
    _check_size(new.body)
    card: dict[str, Any] | Literal["keep"] | None = "keep"
    if "card" in new.model_fields_set:
        card = _card(by, new.card)
    changed = await services.store.edit(by, post_id, new.body, key=key, images=new.images, card=card)
    return json_response(serializer(services, by).post(changed))


@router.delete("/posts/{post_id}", response_model=PostOut, responses=NOT_FOUND, tags=["posts"])
async def delete_post(request: Request, services: AppServices, post_id: str, by: Member) -> Response:
    """Hide the caller's own post, or any post as a moderator."""
    if services.store.reader.post(post_id).author.id != by.id:
        await moderator(request)
    return json_response(serializer(services, by).post(await services.store.remove(by, post_id)))


def _check_size(body: str) -> None:
    if len(body) * 4 > POST_BYTES and len(body.encode()) > POST_BYTES:
        raise BoardError(413, "post_too_large", "the post is too long", f"at most {POST_BYTES} bytes of UTF-8")


def _card(by: Account, card: CardIn | None) -> dict[str, Any] | None:
    if card is None:
        return None
    if by.kind is not AccountKind.ROBOT_AGENT:
        raise BoardError(403, "not_a_robot", "only robot agents can send cards", "omit `card`")
    commands.check_robot(by, card.robot, "card")
    return card.stored()


def post_written(services: Services, by: Account, written: Written) -> Response:
    """The answer to a new post: 201, or 200 when its key was used before."""
    answer = PostWritten(post=serializer(services, by).post(written.post), created=written.created)
    return json_response(answer, 201 if written.created else 200)


# -------------------------------------------------------------------- search
@router.get("/search/modes", response_model=Items[SearchMode], tags=["search"])
async def list_search_modes(services: AppServices, who: ReadingViewer) -> Response:
    """The search modes of this forum: `words`, and `meaning` where it has a model."""
    return json_response(Items[SearchMode](items=services.store.search_modes))


@router.get("/search", response_model=Paged[PostOut], responses=NOT_FOUND, tags=["search"])
async def search_posts(
    services: AppServices,
    who: ReadingViewer,
    q: Annotated[str, Query(max_length=MAX_QUERY)],
    board_id: BoardFilter = None,
    mode: Annotated[SearchMode, Query(description="by words, or by meaning if this forum has a model")] = "words",
    tag: TagFilter = None,
    cursor: Cursor = None,
    limit: Limit = 20,
) -> Response:
    """Posts that contain all words of `q`, newest first; words in double quotes must be adjacent.

    By meaning: posts that say something like `q`, in any language, most similar first, at most 100.
    """
    named = None if tag is None else tags.plain(tag)
    page = await services.store.search(q, cursor, limit, board_id, mode, named)
    return json_response(Paged(items=tuple(map(serializer(services, who.account).post, page.items)), next=page.next))


# -------------------------------------------------------------------- events
@router.get("/changes", response_model=Changes, responses=NOT_FOUND, tags=["events"])
async def list_changes(
    services: AppServices, who: ReadingViewer, after: AfterEvent = None, limit: Limit = 100
) -> Response:
    """Events after an event id; without `after` only `now`, the newest id."""
    store = services.store
    items = store.events(after, limit) if after is not None else ()
    models = serializer(services, who.account)
    now = Now(id=store.reader.newest_event_id(), at=time_out(datetime.now(UTC)))
    return json_response(Changes(items=tuple(map(models.event, items)), now=now))


@router.get(
    "/events",
    response_class=Response,
    responses=documented(404, 429) | {200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}}},
    tags=["events"],
)
async def stream_events(
    services: AppServices,
    who: ReadingViewer,
    after: AfterEvent = None,
    heartbeat: Annotated[float, Query(ge=0.25, le=30.0, allow_inf_nan=False, description="seconds")] = 15.0,
    topic_id: Annotated[str | None, Query(description="only of this topic")] = None,
    last_event_id: Annotated[str | None, Header(pattern=EVENT_ID)] = None,
) -> Response:
    """Server-sent events after an event id, or from now on. `Last-Event-ID` takes precedence over `after`."""
    resume = last_event_id if last_event_id is not None else after
    read = services.store.reader
    start = read.known_event(resume) if resume is not None else event_number(read.newest_event_id())
    topic = services.store.reader.topic(topic_id).id if topic_id is not None else None
    account_id, role = (who.account.id, who.account.role) if who.account else (None, Role.GUEST)

    def check_role(account: Account | None) -> None:
        if account is not None and account.role is not role:
            raise BoardError(403, "role_changed", "the role of this account has changed", "open the stream again")

    listener = services.hub.listen(topic, account_id, role)
    allowed = still_allowed(services, who, check_role)
    return EventStream(services.hub, listener, who.account, start, heartbeat, allowed)
