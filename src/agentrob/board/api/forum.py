"""The forum's JSON API for accounts, boards, topics, posts and events, as `docs/seams.md` says."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Header, Query, Request
from pydantic import BaseModel
from starlette.responses import Response

from agentrob.board.admin.management import BOARD_ID
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
    ReplyIn,
    Serializer,
    TopicIn,
    TopicOut,
    TopicWritten,
    account_out,
    board_out,
    time_out,
)
from agentrob.board.api.problem import documented
from agentrob.board.auth import accounts, visibility
from agentrob.board.auth.access import Viewer, account_of, member, moderator, reader, stopper, viewer
from agentrob.board.content import notifications, tags
from agentrob.board.content.store import SearchMode
from agentrob.board.db.reader import MAX_LIMIT, Reader, event_number, not_found
from agentrob.board.db.records import Written
from agentrob.board.events.hub import EventStream
from agentrob.board.robots import commands
from agentrob.board.search.search import MAX_QUERY
from agentrob.board.services import Services, get_services
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind

router = APIRouter(prefix="/api/v1", responses=documented())

KEY = r"^[!-~]{1,200}$"
EVENT_ID = r"^[0-9]{1,18}(-[0-9a-f]{1,16})?$"
Reading = Annotated[Viewer, Depends(reader)]
Member = Annotated[Account, Depends(member)]
Stopper = Annotated[Account, Depends(stopper)]
Key = Annotated[str | None, Header(alias="Idempotency-Key", pattern=KEY)]
Cursor = Annotated[str | None, Query(pattern=r"^[0-9a-f]{1,15}$", description="`next` of the page before")]
Words = Annotated[str, Query(max_length=MAX_QUERY)]
TagAsked = Annotated[str | None, Query(max_length=tags.LENGTH, description="only of topics with this tag")]
Limit = Annotated[int, Query(ge=1, le=MAX_LIMIT)]
After = Annotated[str | None, Query(pattern=EVENT_ID, description="an event id")]
NOT_FOUND = documented(404)


def out(model: BaseModel, status: int = 200) -> Response:
    """An answer in JSON. The endpoints say what it is by `response_model`."""
    return Response(model.model_dump_json(), status, media_type="application/json")


def shaper(request: Request, account: Account | None) -> Serializer:
    return Serializer(get_services(request).settings.base_url, account)


def _two_answers(model: type[BaseModel]) -> dict[int | str, dict[str, Any]]:
    return documented(404, 409, 429) | {200: {"model": model, "description": "the key had been used: the old one"}}


# -------------------------------------------------------------------- accounts
@router.get("/me", response_model=AccountOut)
async def me(request: Request) -> Response:
    """Who asks; also told to a suspended account."""
    who = await viewer(request)
    if who.account is None:
        raise BoardError(401, "not_signed_in", "sign in first", "a session cookie or Authorization: Bearer <token>")
    return out(account_out(who.account))


@router.get("/notifications", response_model=Paged[NotificationOut])
async def list_notifications(request: Request, who: Reading, cursor: Cursor = None, limit: Limit = 20) -> Response:
    """Posts that name the caller, answer them, or are in a topic of theirs, newest first."""
    shape, account = shaper(request, who.account), account_of(who)
    page = notifications.latest(get_services(request).store.reader, account, cursor, limit)
    found = (
        NotificationOut(id=n.post.id, kind=n.reason, read=not n.fresh, post=shape.post(n.post)) for n in page.items
    )
    return out(Paged(items=tuple(found), next=page.next))


@router.get("/accounts/{name}", response_model=AccountOut, responses=NOT_FOUND)
async def account(request: Request, name: str, who: Reading) -> Response:
    """Who somebody is now."""
    found = get_services(request).store.account(name) if accounts.NAME.fullmatch(name.lower()) else None
    if found is None:
        raise not_found("account", name)
    return out(account_out(found))


# -------------------------------------------------------------------- boards and topics
@router.get("/boards", response_model=Items[BoardOut])
async def boards(request: Request, who: Reading) -> Response:
    """All boards."""
    found = get_services(request).store.boards()
    return out(Items(items=tuple(map(board_out, found))))


@router.get("/boards/{board_id}/topics", response_model=Paged[TopicOut], responses=NOT_FOUND)
async def topics(
    request: Request, board_id: str, who: Reading, tag: TagAsked = None, cursor: Cursor = None, limit: Limit = 20
) -> Response:
    """Topics of a board, latest activity first."""
    store = get_services(request).store
    if tag is None:
        page = store.topics(board_id, cursor, limit)
    else:
        page = await store.beside(Reader.topics, board_id, cursor, limit, tags.plain(tag))
    shape = shaper(request, who.account)
    return out(Paged(items=tuple(map(shape.topic, page.items)), next=page.next))


@router.get("/topics/{topic_id}", response_model=TopicOut, responses=NOT_FOUND)
async def topic(request: Request, topic_id: str, who: Reading) -> Response:
    """One topic."""
    return out(shaper(request, who.account).topic(get_services(request).store.topic(topic_id)))


@router.post("/topics", response_model=TopicWritten, status_code=201, responses=_two_answers(TopicWritten))
async def create_topic(request: Request, new: TopicIn, by: Member, key: Key = None) -> Response:
    """A new topic with its first post."""
    _check_size(new.body)
    options: dict[str, Any] = {"key": key, "images": new.images, "tags": tags.checked(new.tags)}
    written = await get_services(request).store.create_topic(by, new.board, new.title.strip(), new.body, **options)
    shape = shaper(request, by)
    answer = TopicWritten(topic=shape.topic(written.topic), post=shape.post(written.post), created=written.created)
    return out(answer, 201 if written.created else 200)


# -------------------------------------------------------------------- posts
@router.get("/topics/{topic_id}/posts", response_model=Paged[PostOut], responses=NOT_FOUND)
async def posts(request: Request, topic_id: str, who: Reading, cursor: Cursor = None, limit: Limit = 50) -> Response:
    """Posts of a topic, oldest first; removed ones are there, empty."""
    parts, shape = get_services(request), shaper(request, who.account)

    def make() -> tuple[bytes, int]:
        page = parts.store.posts(topic_id, cursor, limit)
        made = Paged(items=tuple(map(shape.post, page.items)), next=page.next).model_dump_json().encode()
        return made, len(made)

    asked = (cursor, limit, shape.viewer_id, visibility.readable_boards())
    return Response(parts.topic_cache.of(parts.store.reader, topic_id, asked, make), media_type="application/json")


@router.post(
    "/topics/{topic_id}/posts", response_model=PostWritten, status_code=201, responses=_two_answers(PostWritten)
)
async def reply(request: Request, topic_id: str, new: ReplyIn, by: Member, key: Key = None) -> Response:
    """A new post in a topic."""
    _check_size(new.body)
    card = _card(by, new.card)
    written = await get_services(request).store.reply(
        by, topic_id, new.body, key=key, reply_to=new.reply_to, images=new.images, card=card
    )
    return post_written(request, by, written)


@router.get("/posts", response_model=Items[PostOut])
async def find(request: Request, who: Reading, key: Annotated[str, Query(pattern=KEY)]) -> Response:
    """The caller's own post written under a key."""
    found = get_services(request).store.find(who.account, key) if who.account else None
    return out(Items(items=(shaper(request, who.account).post(found),) if found else ()))


@router.get("/search/modes", response_model=Items[SearchMode])
async def search_modes(request: Request, who: Reading) -> Response:
    """How posts can be searched for: by their `words`, and by their `meaning` where this forum has it."""
    return out(Items[SearchMode](items=get_services(request).store.search_modes))


@router.get("/search", response_model=Paged[PostOut], responses=NOT_FOUND)
async def search(
    request: Request,
    who: Reading,
    q: Words,
    board: Annotated[str | None, Query(pattern=rf"^{BOARD_ID.pattern}$", description="only on this board")] = None,
    mode: Annotated[SearchMode, Query(description="by words, or by meaning where this forum has it")] = "words",
    tag: TagAsked = None,
    cursor: Cursor = None,
    limit: Limit = 20,
) -> Response:
    """Posts that have all the words of `q`, newest first; words between double quotes must stand together.

    By meaning: posts that say something like `q`, in any language, most alike first, 100 at most.
    """
    page = await get_services(request).store.search(
        q, cursor, limit, board, mode, None if tag is None else tags.plain(tag)
    )
    return out(Paged(items=tuple(map(shaper(request, who.account).post, page.items)), next=page.next))


@router.get("/posts/{post_id}", response_model=PostOut, responses=NOT_FOUND)
async def post(request: Request, post_id: str, who: Reading) -> Response:
    """One post as it is now."""
    return out(shaper(request, who.account).post(get_services(request).store.post(post_id)))


@router.patch("/posts/{post_id}", response_model=PostOut, responses=documented(404, 409, 429))
async def edit(request: Request, post_id: str, new: EditIn, by: Member, key: Key = None) -> Response:
    """A new text for one's own post."""
    _check_size(new.body)
    card: dict[str, Any] | Literal["keep"] | None = "keep"
    if "card" in new.model_fields_set:
        card = _card(by, new.card)
    changed = await get_services(request).store.edit(by, post_id, new.body, key=key, images=new.images, card=card)
    return out(shaper(request, by).post(changed))


@router.delete("/posts/{post_id}", response_model=PostOut, responses=NOT_FOUND)
async def remove(request: Request, post_id: str, by: Member) -> Response:
    """Hide a post: one's own, or any for a moderator."""
    store = get_services(request).store
    if store.post(post_id).author.id != by.id:
        await moderator(request)
    return out(shaper(request, by).post(await store.remove(by, post_id)))


def _check_size(body: str) -> None:
    if len(body) * 4 > POST_BYTES and len(body.encode()) > POST_BYTES:
        raise BoardError(413, "post_too_large", "the post is too long", f"at most {POST_BYTES} bytes of UTF-8")


def _card(by: Account, card: CardIn | None) -> dict[str, Any] | None:
    if card is None:
        return None
    if by.kind is not AccountKind.ROBOT_AGENT:
        raise BoardError(403, "not_a_robot", "only robot agents send cards", "leave out `card`")
    commands.check_robot(by, card.robot, "card")
    return card.model_dump()


def post_written(request: Request, by: Account, written: Written) -> Response:
    answer = PostWritten(post=shaper(request, by).post(written.post), created=written.created)
    return out(answer, 201 if written.created else 200)


# -------------------------------------------------------------------- events
@router.get("/changes", response_model=Changes, responses=NOT_FOUND)
async def changes(request: Request, who: Reading, after: After = None, limit: Limit = 100) -> Response:
    """What happened after an event; without `after` only where "now" is."""
    store = get_services(request).store
    items = store.events(after, limit) if after is not None else ()
    shape = shaper(request, who.account)
    now = Now(id=store.newest_event_id(), at=time_out(datetime.now(UTC)))
    return out(Changes(items=tuple(map(shape.event, items)), now=now))


@router.get(
    "/events",
    response_class=Response,
    responses=documented(404, 429) | {200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}}},
)
async def events(
    request: Request,
    who: Reading,
    after: After = None,
    heartbeat: Annotated[float, Query(ge=0.25, le=30.0, allow_inf_nan=False)] = 15.0,
    topic: str | None = None,
    last_event_id: Annotated[str | None, Header(pattern=EVENT_ID)] = None,
) -> Response:
    """Server-sent events, from after an event on or from now on; of one topic or of all."""
    parts = get_services(request)
    resume = last_event_id if last_event_id is not None else after
    read = parts.store.reader
    start = read.known_event(resume) if resume is not None else event_number(read.newest_event_id())
    topic_id = parts.store.topic(topic).id if topic is not None else None
    listener = parts.hub.listen(topic_id, who.account.id if who.account else None, visibility.readable_boards())
    return EventStream(parts.hub, listener, who.account, start, heartbeat, still_allowed(parts, who))


def still_allowed(
    parts: Services, who: Viewer, check: Callable[[Account | None], None] = lambda account: None
) -> Callable[[], bool]:
    """Whether whoever opened a stream still sees all that it saw then: not signed out, not suspended, the token not
    revoked, no board closed to it.

    `check` is what else was asked when the stream was opened: it is asked again of the account as it is by then, and
    raises `BoardError` when that may not look any more.
    """
    saw = visibility.readable_boards()

    def allowed() -> bool:
        account = None
        if who.account is not None:
            signed_in = accounts.by_token if who.by_token else accounts.by_session
            account = signed_in(parts.store.reader, who.secret)
            if account is None or account.suspended:
                return False
        check(account)
        sees = visibility.boards_readable_by(parts.store.everything.all_boards(), account, parts.settings.public_read)
        return saw <= sees

    def asked() -> bool:
        try:
            return allowed()
        except BoardError:
            return False

    return asked
