"""Request and response models of the JSON API (see `docs/reference/interfaces.md`)."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Annotated, Any, Generic, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints

from agentrob.board.auth.rights import RobotSettings
from agentrob.board.content.unread import UnreadCount
from agentrob.board.db import records
from agentrob.model import Account, AccountKind, EventKind, Role

T = TypeVar("T")
POST_BYTES = 64 * 1024

Time = Annotated[str, Field(json_schema_extra={"format": "date-time"})]
#: At least one character that is not white space; no NUL, which databases do not store reliably.
Body = Annotated[
    str,
    StringConstraints(pattern=r"^[^\x00]*[^\x00\s][^\x00]*$"),
    Field(description="Markdown, at most 64 KiB in UTF-8 (413 beyond)"),
]
#: One line: no control characters.
_SHOWN = r"[^\x00-\x1f\x7f-\x9f]*"
Title = Annotated[
    str, StringConstraints(pattern=rf"^{_SHOWN}[^\x00-\x1f\x7f-\x9f\s]{_SHOWN}$", min_length=1, max_length=200)
]
Ids = Annotated[list[str], Field(max_length=32, description="ids from POST /images")]
Tags = Annotated[
    list[Annotated[str, StringConstraints(max_length=24)]],
    Field(max_length=5, description="converted to lower case, with `-` for characters that are not letters or digits"),
]


def whole(value: object) -> object:
    """JSON has one kind of number: 2.0 is 2."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


Count = Annotated[int, Field(ge=0, le=1000), BeforeValidator(whole)]


class _In(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Out(BaseModel):
    model_config = ConfigDict(frozen=True)


# -------------------------------------------------------------------- in
class CardIn(BaseModel):
    """The state of one command; only robot agents send it. Unknown fields, of newer agents, are ignored."""

    model_config = ConfigDict(extra="ignore", strict=True)

    robot: str = Field(max_length=64)
    state: str = Field(max_length=32)
    step: Count = 0
    steps: Count = 0
    doing: str = Field("", max_length=500)
    place: Count | None = None
    trace_id: str = Field("", max_length=64)
    until: str = Field("", max_length=40, description="RFC 3339 with a zone: until when it may be approved, or waits")
    part: Count = 0
    parts: Count = 0
    post: str = Field("", max_length=64)
    content_hash: str = Field("", max_length=64)
    bid_s: Count = 0
    bid_cm: Count = 0
    near_cm: Count = 0
    room: str = Field("", max_length=40)
    battery: Count = 0
    ahead: Count = 0
    takes: Count = 0
    left_to: str = Field("", max_length=64)

    def stored(self) -> dict[str, Any]:
        """The card as it is stored: only that of a part of a post has the fields of parts."""
        base = {"robot", "state", "step", "steps", "doing", "place", "trace_id", "until"}
        return {name: value for name, value in self.model_dump().items() if name in base or value}


class TopicIn(_In):
    board_id: str = Field(max_length=32)
    title: Title
    body: Body
    images: Ids = []
    tags: Tags = []


class TagsIn(_In):
    """All tags of a topic."""

    tags: Tags


#: The id of a post, which may no longer exist.
PostId = Annotated[str, StringConstraints(pattern=r"^[0-9]{1,18}$")]


class ReadIn(_In):
    """`up_to` as in the unread page; `board_id` for one board only."""

    up_to: PostId
    board_id: str | None = Field(None, max_length=32)


class TopicReadIn(_In):
    up_to: PostId | None = Field(None, description="the last post that was read; without it the whole topic")


class ReplyIn(_In):
    body: Body
    reply_to: str | None = None
    images: Ids = []
    card: CardIn | None = None


class DecisionIn(_In):
    """Which robot's waiting command is approved or denied."""

    robot: Annotated[str, Field(max_length=64)]


class EditIn(_In):
    """`images` are added to those of the post. Without `card` the card stays; null removes it."""

    body: Body
    images: Ids = []
    card: CardIn | None = None


class RobotIn(_In):
    card: dict[str, Any] = Field(description="model, ops, limits, state, …; shown unchanged")


class CommandIn(_In):
    """A robot agent's record of a command; `reply_id` is its own post that reports it."""

    reply_id: str | None = None
    record: dict[str, Any] = Field(description="at most 64 KiB; stored unchanged")


class DraftIn(_In):
    """A text that is being written, for the robots of a topic or a board; without either, for all robots."""

    text: str = Field(max_length=2_000, pattern=r"^[^\x00]*$")
    board_id: str = Field("", max_length=32)
    topic_id: str = Field("", max_length=20)


# -------------------------------------------------------------------- out
class RobotReadingOut(_Out):
    """How a robot reads the text. `outcome` is would, needs_approval, refuse, ask_back, stop, answer or nothing;
    `steps` are the operations that it understood."""

    robot: str
    line: str
    outcome: str
    rule: str = ""
    steps: tuple[dict[str, Any], ...] = ()


class ReadingOut(_Out):
    """`line` says in words what would happen; `robots` has the reading of each robot that the text addresses."""

    line: str
    robots: tuple[RobotReadingOut, ...] = ()


class AccountOut(_Out):
    id: str
    name: str
    display_name: str
    kind: AccountKind
    role: Role
    suspended: bool
    commands_simulated: bool


class BoardOut(_Out):
    id: str
    name: str
    description: str
    post_role: Role
    command_role: Role


class TopicOut(_Out):
    id: str
    board_id: str
    title: str
    url: str
    author: AccountOut
    created_at: Time
    last_post_at: Time
    posts: int
    locked: bool
    tags: tuple[str, ...]


class TagOut(_Out):
    """A tag and the number of topics with it that the caller may read."""

    tag: str
    topics: int


class UnreadOut(_Out):
    """A topic, its number of unread posts of others (100 means more than 99), and the first of them."""

    topic: TopicOut
    new: int
    first_post_id: str | None


class ImageOut(_Out):
    id: str
    url: str
    width: int
    height: int


class PostOut(_Out):
    id: str
    topic_id: str
    board_id: str
    author: AccountOut
    raw: str
    html: str
    version: int
    created_at: Time
    edited_at: Time | None
    removed: bool
    mentions: tuple[str, ...]
    reply_to: str | None
    key: str | None = Field(description="own posts only")
    url: str
    images: tuple[ImageOut, ...]
    card: dict[str, Any] | None


class NotificationOut(_Out):
    id: str
    kind: str = Field(description="approve, mention, reply or topic")
    read: bool
    post: PostOut


class EventOut(_Out):
    id: str
    kind: EventKind
    at: Time
    post: PostOut | None = None
    robot: str | None = None
    account: AccountOut | None = None


class RobotOut(_Out):
    name: str
    url: str = Field(description="the robot's page, with its buttons")
    card: dict[str, Any]
    seen_at: Time | None
    viewers: int
    has_frame: bool


class ScheduleOut(_Out):
    post_id: str = Field(description="the post with the schedule; a reply `cancel` to it ends the schedule")
    url: str
    author: str
    text: str = Field(description="the command in the robot's words")
    time_zone: str
    runs: tuple[Time, ...] = Field(description="all further runs")
    until: Time | None = Field(description="when it ends at the latest")
    renewable: bool = Field(description="whether its author may renew it when it ends by the limit of runs or days")


class RightsOut(_Out):
    """The input of `screening.rights`: each right is the lowest role that has it, `owner` or `nobody`."""

    owner: str
    command: dict[str, str] = Field(description="by class of action: photo, gesture, move, risky")
    approve: str
    release: str
    command_role: str = Field(description="the lowest role that may command on the requested board")
    approval: tuple[str, ...] = Field(description="classes of action that need approval")
    approve_own: bool = Field(description="whether approvers may approve their own commands")
    closed_until: Time | None = Field(description="the end of the robot's maintenance, if it is closed now")


class CommandOut(_Out):
    robot: str
    post_id: str
    reply_id: str | None
    at: Time
    url: str
    record: dict[str, Any]


class Items(_Out, Generic[T]):
    items: tuple[T, ...]


class CommandsOut(Items[CommandOut]):
    url: str = Field(description="the page of the command, even before there are records")


class Paged(_Out, Generic[T]):
    items: tuple[T, ...]
    next: str | None


class UnreadPage(Paged[UnreadOut]):
    up_to: str = Field(description="the newest post; send it back to mark all of this as read")


class TopicWritten(_Out):
    topic: TopicOut
    post: PostOut
    created: bool


class PostWritten(_Out):
    post: PostOut
    created: bool


class Now(_Out):
    id: str
    at: Time


class Changes(_Out):
    items: tuple[EventOut, ...]
    now: Now


class Viewers(_Out):
    viewers: int


class PoseViewers(_Out):
    """`every_s`: after how many seconds the viewers get the next pose; `body`: whether some see the 3D view."""

    viewers: int
    every_s: float
    body: bool


class MapOut(_Out):
    """`map` as the robot's agent describes it, in metres and degrees of the room; `geometry` names its shape."""

    robot: str
    map: dict[str, Any]
    geometry: str | None


class GeometryOut(_Out):
    name: str


# -------------------------------------------------------------------- records to models
def time_out(at: datetime) -> str:
    return at.astimezone(UTC).isoformat(timespec="microseconds").replace("+00:00", "Z")


def account_out(a: Account) -> AccountOut:
    return AccountOut(
        id=a.id, name=a.name, display_name=a.display_name, kind=a.kind, role=a.role, suspended=a.suspended,
        commands_simulated=a.commands_simulated,
    )  # fmt: skip


def board_out(b: records.Board) -> BoardOut:
    roles = {"post_role": b.post_role, "command_role": b.command_role}
    return BoardOut(id=b.id, name=b.name, description=b.description, **roles)


class Serializer:
    """Converts records to models for one viewer: URLs begin with `base_url`, keys are shown to their owner only."""

    def __init__(self, base_url: str, viewer: Account | None = None) -> None:
        self.base_url = base_url
        self.viewer_id = viewer.id if viewer else None

    def topic(self, t: records.Topic) -> TopicOut:
        return TopicOut(
            id=t.id,
            board_id=t.board_id,
            title=t.title,
            url=self.base_url + t.path,
            author=account_out(t.author),
            created_at=time_out(t.created_at),
            last_post_at=time_out(t.last_post_at),
            posts=t.posts,
            locked=t.locked,
            tags=t.tags,
        )

    def unread(self, t: records.Topic, news: UnreadCount | None) -> UnreadOut:
        return UnreadOut(topic=self.topic(t), new=news.count if news else 0, first_post_id=news.first if news else None)

    def image(self, i: records.Image) -> ImageOut:
        return ImageOut(id=i.id, url=self.base_url + i.path, width=i.width, height=i.height)

    def post(self, p: records.StoredPost) -> PostOut:
        return PostOut(
            id=p.id,
            topic_id=p.topic_id,
            board_id=p.board_id,
            author=account_out(p.author),
            raw=p.raw,
            html=p.html,
            version=p.version,
            created_at=time_out(p.created_at),
            edited_at=time_out(p.edited_at) if p.edited_at else None,
            removed=p.removed,
            mentions=p.mentions,
            reply_to=p.reply_to,
            key=p.key if p.author.id == self.viewer_id else None,
            url=self.base_url + p.path,
            images=tuple(map(self.image, p.images)),
            card=dict(p.card) if p.card is not None else None,
        )

    def event(self, e: records.StoredEvent) -> EventOut:
        return EventOut(
            id=e.id,
            kind=e.kind,
            at=time_out(e.at),
            post=self.post(e.post) if e.post else None,
            robot=e.robot,
            account=account_out(e.account) if e.account else None,
        )


def robot_out(
    name: str, url: str, card: Mapping[str, Any], seen_at: datetime | None, viewers: int, has_frame: bool
) -> RobotOut:
    seen = time_out(seen_at) if seen_at else None
    return RobotOut(name=name, url=url, card=dict(card), seen_at=seen, viewers=viewers, has_frame=has_frame)


def rights_out(kept: RobotSettings, board: records.Board, now: datetime) -> RightsOut:
    closed = kept.closed_until(now)
    return RightsOut(
        owner=kept.owner,
        command=dict(kept.command),
        approve=kept.approve,
        release=kept.release,
        command_role=str(board.command_role),
        approval=kept.approval,
        approve_own=kept.approve_own,
        closed_until=time_out(closed) if closed else None,
    )
