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

from agentrob.model import Account, AccountKind, EventKind, FleetRobot, Page, Post, RobotRights, Role, StatusCard

T = TypeVar("T")

#: The current trace id, for forums that log it; empty outside of a trace.
TRACE_ID: ContextVar[str] = ContextVar("TRACE_ID", default="")


@dataclass(frozen=True, slots=True)
class Board:
    """A category. `id` is the forum's name for it."""

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
    """A written post. If its key was used before, this is the earlier post and `created` is False."""

    post: Post
    created: bool = True


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened, in order. A stream can resume after `id`; only the forum can compare ids.

    `post` is set for post events (as it was on delivery), `robot` and `account` for robot events: which account pressed
    a button (an emergency stop also locks the robot), or that viewers are watching.
    """

    id: str
    kind: EventKind
    at: datetime
    post: Post | None = None
    robot: str | None = None
    account: Account | None = None


class Reader(Protocol):
    """Read boards, topics and posts, always in their current state."""

    async def boards(self) -> Sequence[Board]: ...

    async def topic(self, topic_id: str) -> Topic: ...

    async def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]: ...

    async def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]: ...

    async def post(self, post_id: str) -> Post:
        """Return the current post; `removed` if it is hidden or deleted. Raises `ForumNotFound` if it never existed."""
        ...

    async def download(self, url: str) -> bytes:
        """Return an image of a post, by its address in `Post.images`."""
        ...


class Writer(Protocol):
    """Write as the signed-in account. `key` makes a write idempotent: the same key twice is one post.

    `images` are JPEG, PNG or WebP bytes (which may be animated), shown below the text in order. A forum that rejects
    one raises `ForumError`, and the same write may be tried with fewer. `card` is the machine-readable status.
    """

    #: How often a post may be edited; None: without limit.
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
        """Replace the text; add `images` to those of the post."""
        ...

    async def find(self, key: str) -> Post | None:
        """Return the post that this account wrote under `key`, if any."""
        ...


class Accounts(Protocol):
    """Look up accounts; rights are checked again before motion."""

    async def me(self) -> Account: ...

    async def account(self, name: str) -> Account | None: ...


#: The position before all events that a forum keeps. Forums that keep all events need not support it.
BEFORE_ALL = "0"


class Events(Protocol):
    """Changes, oldest first, each once."""

    #: Whether `stream` works. If not, the agent polls `changes`.
    live: bool
    #: The shortest allowed interval between calls of `changes`, in seconds.
    fastest_poll_s: float

    async def now(self) -> tuple[str, datetime]:
        """Return the id of the newest event (a watermark) and the forum's clock."""
        ...

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        """Return the events after one, or after `BEFORE_ALL`. Like `stream`, raises `ForumNotFound` if the forum does
        not know that event or no longer keeps it."""
        ...

    def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        """Yield events as they happen, with heartbeats in between. Raises `ForumUnreachable` when it is cut."""
        ...


@runtime_checkable
class ReadableByRole(Protocol):
    """A forum on which an account may read what its role may read, so that accounts of one role can share an event
    stream. A forum with other permissions, such as categories for some groups, must not declare it: a robot would not
    receive the stops of a category that the account of the stream may not read."""

    readable_by_role: bool


@runtime_checkable
class RobotPages(Protocol):
    """A forum with a page for each robot: its state and a live picture."""

    async def publish_robot(self, robot: str, card: dict[str, Any]) -> None:
        """Update the robot's page: model, ops, state, battery, board, queue."""
        ...

    async def publish_frame(self, robot: str, jpeg: bytes) -> int:
        """Show a live picture; return the number of viewers."""
        ...


@dataclass(frozen=True, slots=True)
class PoseViewers:
    """The number of viewers of a robot's map, after how many seconds they get the next pose, and whether some see the
    3D view, which needs joint angles."""

    viewers: int
    every_s: float
    body: bool


@runtime_checkable
class PosePages(Protocol):
    """A forum that shows where robots are while somebody watches, and replays commands."""

    async def publish_pose(self, robot: str, frame: dict[str, Any]) -> PoseViewers:
        """Show a pose, in metres and radians of the robot's room."""
        ...

    async def publish_geometry(self, robot: str, geometry: bytes) -> str:
        """Store the gzipped shape of the robot for the 3D view; return its name."""
        ...

    async def publish_replay(self, post_id: str, replay: bytes) -> None:
        """Store the gzipped replay of a post's command, replacing an earlier one."""
        ...


@runtime_checkable
class RobotControls(Protocol):
    """A forum whose robot pages have buttons: emergency stop for everybody, release and home for the owner. Presses
    arrive as events."""

    async def robot_page(self, robot: str) -> str:
        """Return the address of the robot's page."""
        ...


@runtime_checkable
class RobotRightsSource(Protocol):
    """A forum that stores rights for each robot, in addition to the roles of accounts."""

    async def robot_rights(self, robot: str, board_id: str) -> RobotRights:
        """Return the robot's current rights on this board."""
        ...


@runtime_checkable
class CommandPages(Protocol):
    """A forum with a page for each command."""

    async def command_page(self, post_id: str) -> str:
        """Return the address of the page of a post's command, even before it has content."""
        ...

    async def publish_record(self, post_id: str, reply_id: str | None, record: dict[str, Any]) -> None:
        """Store the record of a post's command, replacing an earlier one; `reply_id` is the post that reports it."""
        ...


# ---------------------------------------------------------------------- what not every forum has
@dataclass(frozen=True, slots=True)
class Registered:
    """A new account and the secret that signs it in. Only its owner may see the secret."""

    account: Account
    secret: str


@dataclass(frozen=True, slots=True)
class Notification:
    """Why an account should read a post: `mention`, `reply` or another word of the forum."""

    id: str
    kind: str
    post: Post
    read: bool = False


@runtime_checkable
class KeyedEdits(Protocol):
    """A forum that makes an edit under a key once, however often it is sent: also if the first one was still under way
    when its answer was given up."""

    async def edit_once(
        self, post_id: str, body: str, *, key: str, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        """Like `Writer.edit`. If this account has edited this post under `key`, nothing changes."""
        ...


@runtime_checkable
class RobotDirectory(Protocol):
    """A forum that lists the accounts of robots."""

    async def robot_names(self) -> tuple[str, ...]:
        """Return the handles of all robot accounts."""
        ...


@runtime_checkable
class Fleet(Protocol):
    """A forum that lists its robots with what their agents published."""

    async def fleet(self) -> tuple[FleetRobot, ...]:
        """Return all robots, by name."""
        ...


@runtime_checkable
class Searcher(Protocol):
    """A forum with full-text search."""

    async def search(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        """Return the posts that contain all words of the query, newest first."""
        ...


@runtime_checkable
class SemanticSearcher(Protocol):
    """A forum that can search by meaning, if it has a model for it."""

    async def has_semantic_search(self) -> bool:
        """Return whether it can now."""
        ...

    async def search_semantic(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        """Return posts with a meaning like the query's, best match first. Raises `ForumUnoffered` without a model."""
        ...


@runtime_checkable
class Registrar(Protocol):
    """A forum where accounts can be created, by admins or by anybody. Raises `ForumDenied` if this account may not."""

    async def register(
        self, name: str, *, kind: AccountKind = AccountKind.HUMAN, display_name: str = ""
    ) -> Registered: ...


@runtime_checkable
class Permissions(Protocol):
    """A forum where admins change what an account may do."""

    async def set_rights(self, name: str, *, role: Role | None = None, suspended: bool | None = None) -> Account:
        """Change the given rights and return the account. Raises `ForumDenied` unless an admin calls it."""
        ...


@runtime_checkable
class Notifications(Protocol):
    """A forum that notifies accounts of mentions and replies."""

    async def notifications(self, cursor: str | None = None, limit: int = 20) -> Page[Notification]:
        """Return the notifications of the signed-in account, newest first."""
        ...


class Forum(Reader, Writer, Accounts, Events, Protocol):
    """A complete forum, signed in as one account."""

    async def close(self) -> None: ...
