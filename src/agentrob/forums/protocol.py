"""The protocols that a forum adapter implements.

Every forum is a `Reader`, a `Writer`, `Accounts` and `Events`. The other protocols are optional: a forum without such a
feature has no such method, or its method raises `ForumUnoffered`. All calls are asynchronous and raise subclasses of
`agentrob.errors.ForumError`, never exceptions of the transport.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Protocol, TypeVar, runtime_checkable

from agentrob.model import Account, AccountKind, EventKind, Page, Post, RobotRights, Role, StatusCard

T = TypeVar("T")

#: The trace id of what is done now, for a forum that can put it into its own log; empty outside of a trace.
TRACE_ID: ContextVar[str] = ContextVar("TRACE_ID", default="")


@dataclass(frozen=True, slots=True)
class Board:
    """A category. `id` is what the forum calls it by."""

    id: str
    name: str
    description: str = ""


@dataclass(frozen=True, slots=True)
class Topic:
    """A thread without its posts."""

    id: str
    board_id: str
    title: str
    url: str
    author: Account
    created_at: datetime


@dataclass(frozen=True, slots=True)
class Written:
    """A post that was written. `created` is False when the same key had been used before: then it is the old post."""

    post: Post
    created: bool = True


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened, in order. `id` resumes the stream after it; ids compare by the forum only.

    `post` is set for post events (as it was when the event was delivered), `robot` and `account` for robot events:
    who pressed which button (an emergency stop also locks the robot), or that somebody watches.
    """

    id: str
    kind: EventKind
    at: datetime
    post: Post | None = None
    robot: str | None = None
    account: Account | None = None


class Reader(Protocol):
    """Read boards, topics and posts, always as they are now."""

    async def boards(self) -> Sequence[Board]: ...

    async def topic(self, topic_id: str) -> Topic: ...

    async def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]: ...

    async def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]: ...

    async def post(self, post_id: str) -> Post:
        """The post as it is now; `removed` when hidden or deleted. `ForumNotFound` when it never was."""
        ...

    async def download(self, url: str) -> bytes:
        """A picture of a post, by its address as in `Post.images`."""
        ...


class Writer(Protocol):
    """Write as the signed-in account. `key` makes a write idempotent: the same key twice is one post.

    `images` are JPEG, PNG or WebP bytes (these may move) shown below the text, in order; a forum that cannot take one
    raises `ForumError`, and the same write may be tried with fewer. `card` is the machine-readable status.
    """

    #: How often a post may be edited, or None when there is no limit.
    max_edits: int | None

    async def create_topic(
        self, board_id: str, title: str, body: str, *, key: str, images: Sequence[bytes] = ()
    ) -> Written: ...

    async def reply(
        self,
        topic_id: str,
        body: str,
        *,
        key: str,
        reply_to: str | None = None,
        images: Sequence[bytes] = (),
        card: StatusCard | None = None,
    ) -> Written: ...

    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        """Replace the text; images given are added to those the post has."""
        ...

    async def find(self, key: str) -> Post | None:
        """The post that this account wrote under `key`, if any."""
        ...


class Accounts(Protocol):
    """Who am I, and who is somebody else now (rights are asked again before motion)."""

    async def me(self) -> Account: ...

    async def account(self, name: str) -> Account | None: ...


#: What all events come after that a forum keeps. One that lets go of none need not know it.
BEFORE_ALL = "0"


class Events(Protocol):
    """What changed, oldest first, each event once."""

    #: Whether `stream` works; otherwise the agent polls `changes`.
    live: bool
    #: The shortest interval, in seconds, at which `changes` may be asked for.
    fastest_poll_s: float

    async def now(self) -> tuple[str, datetime]:
        """The id of the newest event (a watermark) and the forum's clock."""
        ...

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        """Events after one, or after `BEFORE_ALL`; `ForumNotFound` when it is none of this forum's history, or of one
        that is not kept any more. So is `stream`."""
        ...

    def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        """Events as they happen, and a heartbeat when nothing does. Ends with `ForumUnreachable` when cut."""
        ...


@runtime_checkable
class RobotPages(Protocol):
    """A forum that has a page per robot with its state and a live picture."""

    async def publish_robot(self, robot: str, card: dict[str, Any]) -> None:
        """Tell the page about the robot: model, ops, state, battery, board, queue."""
        ...

    async def publish_frame(self, robot: str, jpeg: bytes) -> int:
        """Show a live picture; returns how many people watch."""
        ...


@runtime_checkable
class RobotControls(Protocol):
    """A forum whose page of a robot has buttons: emergency stop for everybody, release and home for its owner. They
    come as events."""

    async def robot_page(self, robot: str) -> str:
        """The address of the robot's page."""
        ...


@runtime_checkable
class RobotRightsSource(Protocol):
    """A forum that keeps who may do what with each robot, besides the roles of accounts."""

    async def robot_rights(self, robot: str, board_id: str) -> RobotRights:
        """The rights of this robot on this board now."""
        ...


@runtime_checkable
class CommandPages(Protocol):
    """A forum that has a page per command."""

    async def command_page(self, post_id: str) -> str:
        """The address of the page of a post's command, also before there is anything on it."""
        ...

    async def publish_record(self, post_id: str, reply_id: str | None, record: dict[str, Any]) -> None:
        """Keep the record of a post's command, in place of the one before; `reply_id` is the post that tells it."""
        ...


# ---------------------------------------------------------------------- what not every forum has
@dataclass(frozen=True, slots=True)
class Registered:
    """A new account, and the secret that signs it in; the secret is never shown to anybody but its owner."""

    account: Account
    secret: str


@dataclass(frozen=True, slots=True)
class Notification:
    """Why an account should look at a post: `mention`, `reply` or another word of the forum."""

    id: str
    kind: str
    post: Post
    read: bool = False


@runtime_checkable
class RobotDirectory(Protocol):
    """A forum that lists the accounts of robots."""

    async def robot_names(self) -> tuple[str, ...]:
        """The handles of all accounts of robots."""
        ...


@runtime_checkable
class Searcher(Protocol):
    """A forum that finds posts by their words."""

    async def search(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        """Posts that have all words of the query, newest first."""
        ...


@runtime_checkable
class SemanticSearcher(Protocol):
    """A forum that finds posts by what they mean, where it has a model that knows it."""

    async def has_semantic_search(self) -> bool:
        """Whether it has one now."""
        ...

    async def search_semantic(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        """Posts that say something like the query, most alike first. `ForumUnoffered` without a model."""
        ...


@runtime_checkable
class Registrar(Protocol):
    """A forum where accounts are made, by an admin or by whoever comes: `ForumDenied` says who may."""

    async def register(
        self, name: str, *, kind: AccountKind = AccountKind.HUMAN, display_name: str = ""
    ) -> Registered: ...


@runtime_checkable
class Permissions(Protocol):
    """A forum where admins change what an account may do."""

    async def set_rights(self, name: str, *, role: Role | None = None, suspended: bool | None = None) -> Account:
        """Change what is given; the account as it is then. `ForumDenied` for all but admins."""
        ...


@runtime_checkable
class Notifications(Protocol):
    """A forum that keeps for each account who mentioned or answered it."""

    async def notifications(self, cursor: str | None = None, limit: int = 20) -> Page[Notification]:
        """Of the signed-in account, newest first."""
        ...


class Forum(Reader, Writer, Accounts, Events, Protocol):
    """A whole forum, signed in as one account."""

    async def close(self) -> None: ...
