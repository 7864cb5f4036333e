"""A forum in memory: several accounts on one world, with events, keys, edits, limits and failures on demand.

It is part of the product, not a test mock: examples, stories and tests of other packages use it. It behaves like the
board and passes the same contract.

    world = MemoryForum.world()
    alice = world.sign_in("alice", role=Role.OPERATOR)
    robot = world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    written = await alice.create_topic("robots", "A walk", "@quadruped walk forward 1 m", key="1")
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TYPE_CHECKING, Any, TypeVar

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound, ForumUnoffered, ForumUnreachable
from agentrob.forums.cards import card_by
from agentrob.forums.memory.world import MemoryRecords
from agentrob.forums.protocol import Board, Event, Notification, Registered, Topic, Written
from agentrob.model import Account, AccountKind, EventKind, Page, Post, Role, StatusCard
from agentrob.semantic.encoder import MIN_SIMILARITY, cosine_similarity

if TYPE_CHECKING:
    from agentrob.config.forum import ForumConfig

T = TypeVar("T")


@dataclass
class MemoryWorld(MemoryRecords):
    """The forum itself, shared by all signed-in accounts. Times are the machine's clock plus `clock_offset_s`.

    `max_edits` limits edits per post. With `live=False` there is no event stream: agents poll, at most every
    `fastest_poll_s`. `reachable = False` makes all calls and open streams fail with `ForumUnreachable` until it is set
    back, `limited_s > 0` makes writes fail with `ForumLimited`. An `encoder` adds search by meaning.
    """

    def sign_in(
        self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER, display_name: str = ""
    ) -> MemoryForum:
        """Return the forum as seen by this account, which is created if it does not exist."""
        self.add_account(name, kind, role, display_name)
        return MemoryForum(self, name)


#: Worlds by the name in a configuration, for memory forums built through the entry point.
_named: dict[str, MemoryWorld] = {}


class MemoryForum:
    """One account's view of a `MemoryWorld`; fulfils `Forum`, `RobotPages` and all optional protocols."""

    def __init__(self, world: MemoryWorld | ForumConfig, name: str) -> None:
        """Take a world, or like every adapter settings and a token: `url` names the world, the token the account."""
        self._world = world if isinstance(world, MemoryWorld) else _named.setdefault(world.url, MemoryWorld())
        if name not in self._world.accounts:
            self._world.sign_in(name)
        self._name = name
        self.max_edits = self._world.max_edits
        self.live = self._world.live
        self.readable_by_role = True
        self.fastest_poll_s = self._world.fastest_poll_s

    @staticmethod
    def world(**settings: Any) -> MemoryWorld:
        """Return a new, empty forum; settings as in `MemoryWorld`."""
        return MemoryWorld(**settings)

    async def close(self) -> None:
        """Do nothing: there is no connection."""

    # ---------------------------------------------------------------- Reader
    async def boards(self) -> Sequence[Board]:
        return tuple(self._up().boards.values())

    async def topic(self, topic_id: str) -> Topic:
        topics = self._up().topics
        if topic_id not in topics:
            raise ForumNotFound(f"there is no topic {topic_id}")
        return topics[topic_id]

    async def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]:
        world = self._up()
        self._board(board_id)
        last = {p.topic_id: int(p.id) for p in world.posts.values()}
        found = sorted((t for t in world.topics.values() if t.board_id == board_id), key=lambda t: -last[t.id])
        return _page(found, cursor, limit)

    async def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]:
        await self.topic(topic_id)
        world = self._up()
        return _page([self._visible(p.id) for p in world.posts.values() if p.topic_id == topic_id], cursor, limit)

    async def post(self, post_id: str) -> Post:
        self._up()
        return self._visible(post_id)

    async def download(self, url: str) -> bytes:
        pictures = self._up().pictures
        if url not in pictures:
            raise ForumNotFound(f"there is no picture {url}")
        return pictures[url]

    # ---------------------------------------------------------------- Writer
    async def create_topic(
        self, board_id: str, title: str, body: str, *, key: str, images: Sequence[bytes] = ()
    ) -> Written:
        world = self._writing()
        if old := world.written_under(self._name, key):
            return Written(old, created=False)
        self._board(board_id)
        number = str(len(world.topics) + 1)
        topic = Topic(number, board_id, title, f"memory:/t/{number}", world.accounts[self._name], world.now())
        world.topics[number] = topic
        return Written(world.add_post(topic, self._name, body, key, images))

    async def reply(
        self,
        topic_id: str,
        body: str,
        *,
        key: str,
        reply_to: str | None = None,
        images: Sequence[bytes] = (),
        card: StatusCard | None = None,
    ) -> Written:
        world = self._writing()
        if old := world.written_under(self._name, key):
            return Written(old, created=False)
        topic = await self.topic(topic_id)
        return Written(world.add_post(topic, self._name, body, key, images, reply_to=reply_to, card=card))

    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        world = self._writing()
        post = world.fresh(post_id)
        if post.author.name != self._name:
            raise ForumDenied(f"post {post_id} belongs to {post.author.name}")
        if world.max_edits is not None and post.version > world.max_edits:
            raise ForumDenied(f"a post may be edited {world.max_edits} times here")
        edited = replace(
            post, raw=body, version=post.version + 1, edited_at=world.now(), mentions=world.mentioned(body),
            images=post.images + world.keep(post_id, images), card=card_by(post.author, card) or post.card,
        )  # fmt: skip
        world.posts[post_id] = edited
        world.emit(EventKind.POST_EDITED, post=edited)
        return edited

    async def edit_once(
        self, post_id: str, body: str, *, key: str, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        used = self._name, post_id, key
        if used in self._writing().edits:
            return await self.post(post_id)
        edited = await self.edit(post_id, body, images=images, card=card)
        self._world.edits.add(used)
        return edited

    async def find(self, key: str) -> Post | None:
        return self._up().written_under(self._name, key)

    # ---------------------------------------------------------------- Accounts
    async def me(self) -> Account:
        return self._up().accounts[self._name]

    async def robot_names(self) -> tuple[str, ...]:
        return tuple(a.name for a in self._up().accounts.values() if a.kind is AccountKind.ROBOT_AGENT)

    async def account(self, name: str) -> Account | None:
        return self._up().accounts.get(name)

    # ---------------------------------------------------------------- Events
    async def now(self) -> tuple[str, datetime]:
        world = self._up()
        return str(len(world.events)), world.now()

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        return tuple(self._mine(e) for e in self._up().after(after, limit))

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        if not self.live:
            raise ForumUnreachable("this forum has no event stream; poll changes()")
        while True:
            events = self._up().after(after, 100)
            for event in events:
                after = event.id
                yield self._mine(event)
                self._up()
            if not events and not await self._world.wait(heartbeat_s):
                yield Event("", EventKind.HEARTBEAT, self._up().now())

    # ---------------------------------------------------------------- what not every forum has
    async def search(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        """Return posts that contain all words, in any case."""
        world, words = self._up(), query.casefold().split()
        if board_id is not None:
            self._board(board_id)
        found = [
            self._visible(p.id)
            for p in reversed(world.posts.values())
            if board_id in (None, p.board_id) and not p.removed and all(w in p.raw.casefold() for w in words)
        ]
        return _page(found, cursor, limit)

    async def has_semantic_search(self) -> bool:
        return self._up().encoder is not None

    async def search_semantic(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        """Return posts with vectors like the query's. The vectors are computed for each search."""
        world = self._up()
        if world.encoder is None:
            raise ForumUnoffered("this forum has no model for a search by meaning")
        if board_id is not None:
            self._board(board_id)
        posts = [p for p in reversed(world.posts.values()) if board_id in (None, p.board_id) and not p.removed]
        wanted, *vectors = await asyncio.to_thread(world.encoder.encode, [query, *(p.raw for p in posts)])
        likeness = [(cosine_similarity(wanted, vector), p.id) for p, vector in zip(posts, vectors, strict=True)]
        found = sorted((entry for entry in likeness if entry[0] >= MIN_SIMILARITY), key=lambda entry: -entry[0])
        return _page([self._visible(post_id) for _, post_id in found], cursor, limit)

    async def register(self, name: str, *, kind: AccountKind = AccountKind.HUMAN, display_name: str = "") -> Registered:
        """Create an account, as an admin. An account's secret is its name."""
        world = self._admin("making accounts")
        if name in world.accounts:
            raise ForumError(f"there is an account named {name!r} already")
        world.sign_in(name, kind=kind, display_name=display_name)
        return Registered(world.accounts[name], name)

    async def set_rights(self, name: str, *, role: Role | None = None, suspended: bool | None = None) -> Account:
        world = self._admin("changing rights")
        if name not in world.accounts:
            raise ForumNotFound(f"there is no account {name!r}")
        if role is not None:
            world.set_role(name, role)
        if suspended is not None:
            world.suspend(name, suspended)
        return world.accounts[name]

    async def notifications(self, cursor: str | None = None, limit: int = 20) -> Page[Notification]:
        world, found = self._up(), list[Notification]()
        for post in reversed(world.posts.values()):
            answered = world.posts.get(post.reply_to or "")
            if post.author.name == self._name or post.removed:
                continue
            if self._name in post.mentions:
                found.append(Notification(f"mention-{post.id}", "mention", self._visible(post.id)))
            elif answered is not None and answered.author.name == self._name:
                found.append(Notification(f"reply-{post.id}", "reply", self._visible(post.id)))
        return _page(found, cursor, limit)

    # ---------------------------------------------------------------- RobotPages
    async def publish_robot(self, robot: str, card: dict[str, Any]) -> None:
        self._writing().robots[robot] = card

    async def robot_page(self, robot: str) -> str:
        return f"memory:/robots/{robot}"

    async def publish_frame(self, robot: str, jpeg: bytes) -> int:
        world = self._writing()
        world.frames[robot] = jpeg
        return world.viewers.get(robot, 0)

    # ---------------------------------------------------------------- buttons
    async def press_stop(self, robot: str) -> None:
        """Press the stop button of a robot's page."""
        self._press(EventKind.ROBOT_STOP, robot)

    async def press_estop(self, robot: str) -> None:
        """Press the button that stops a robot and locks it."""
        self._press(EventKind.ROBOT_ESTOP, robot)

    async def press_release(self, robot: str) -> None:
        """Press the button that releases a locked robot; its agent checks the right."""
        self._press(EventKind.ROBOT_RELEASE, robot)

    async def press_home(self, robot: str) -> None:
        """Press the button that sets the robot's home to where it stands; its agent checks the right."""
        self._press(EventKind.ROBOT_HOME, robot)

    async def press_reset(self, robot: str) -> None:
        """Press the button that resets a simulated room; operators only."""
        if self._up().accounts[self._name].role.rank < Role.OPERATOR.rank:
            raise ForumDenied("resetting the room needs an operator")
        self._press(EventKind.ROBOT_RESET, robot)

    def _press(self, kind: EventKind, robot: str) -> None:
        world = self._writing()
        world.emit(kind, robot=robot, account=world.accounts[self._name])

    # ---------------------------------------------------------------- inside
    def _up(self) -> MemoryWorld:
        if not self._world.reachable:
            self._world.unanswered += 1
            raise ForumUnreachable("the forum does not answer")
        return self._world

    def _writing(self) -> MemoryWorld:
        world = self._up()
        if world.accounts[self._name].suspended:
            raise ForumDenied(f"{self._name} is suspended")
        if world.limited_s > 0:
            raise ForumLimited(f"too fast, try again in {world.limited_s} s", world.limited_s)
        return world

    def _admin(self, doing: str) -> MemoryWorld:
        world = self._writing()
        if world.accounts[self._name].role is not Role.ADMIN:
            raise ForumDenied(f"{doing} needs an admin")
        return world

    def _board(self, board_id: str) -> Board:
        boards = self._world.boards
        if board_id not in boards:
            raise ForumNotFound(f"no board {board_id!r}; valid: {', '.join(boards)}")
        return boards[board_id]

    def _visible(self, post_id: str) -> Post:
        """Show keys only to their writer."""
        post = self._world.fresh(post_id)
        return post if post.author.name == self._name else replace(post, key=None)

    def _mine(self, event: Event) -> Event:
        if event.post is None or event.post.author.name == self._name:
            return event
        return replace(event, post=replace(event.post, key=None))


def _page(items: Sequence[T], cursor: str | None, limit: int) -> Page[T]:
    if cursor is not None and not cursor.isdecimal():
        raise ForumError(f"{cursor[:40]!r} is not a cursor of this forum")
    start = int(cursor or 0)
    end = start + limit
    return Page(tuple(items[start:end]), str(end) if end < len(items) else None)
