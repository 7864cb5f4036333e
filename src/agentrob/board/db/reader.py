"""Read records from the forum's database with a few short statements per call."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Collection, Hashable, Sequence
from typing import Any, TypeVar

from sqlalchemy import Connection, Executable, Integer, Row, Select, and_, bindparam, func, or_, select
from sqlalchemy.exc import DBAPIError, OperationalError

from agentrob.board.db import schema as db
from agentrob.board.db.cursors import LARGEST_ID, from_cursor, to_cursor
from agentrob.board.db.database import unavailable
from agentrob.board.db.read_cache import ReadCache
from agentrob.board.db.records import Board, Image, StoredEvent, StoredPost, Topic, Version, from_us
from agentrob.board.db.rows import account_from, board_from, event_from, event_id, post_from, topic_from
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Page

T = TypeVar("T")
#: The largest page size.
MAX_LIMIT = 100

_AUTHOR = (
    db.accounts.c.id.label("a_id"),
    db.accounts.c.name.label("a_name"),
    db.accounts.c.kind.label("a_kind"),
    db.accounts.c.role.label("a_role"),
    db.accounts.c.suspended.label("a_suspended"),
    db.accounts.c.display_name.label("a_display_name"),
    db.accounts.c.commands_simulated.label("a_commands_simulated"),
)
ACCOUNT: Select[Any] = select(*_AUTHOR)
_TAGS = select(func.aggregate_strings(db.topic_tags.c.tag, " ")).where(db.topic_tags.c.topic_id == db.topics.c.id)
_TOPICS = select(db.topics, _TAGS.scalar_subquery().label("tags"), *_AUTHOR).join(
    db.accounts, db.accounts.c.id == db.topics.c.author_id
)
_HAS_IMAGES = select(db.post_images.c.post_id).where(db.post_images.c.post_id == db.posts.c.id).exists()
_POSTS = (
    select(db.posts, db.topics.c.board_id, _HAS_IMAGES.label("has_images"), *_AUTHOR)
    .join(db.topics, db.topics.c.id == db.posts.c.topic_id)
    .join(db.accounts, db.accounts.c.id == db.posts.c.author_id)
)
# Built once: these run for nearly every request, and building a statement costs more than running it.
_POSTS_OF_TOPIC = (
    _POSTS.where(db.posts.c.topic_id == bindparam("of"), db.posts.c.id > bindparam("after"))
    .order_by(db.posts.c.id)
    .limit(bindparam("most", type_=Integer))
)
_TOPIC = _TOPICS.where(db.topics.c.id == bindparam("id"))
_TOPICS_BY_ID = _TOPICS.where(db.topics.c.id.in_(bindparam("ids", expanding=True)))
_POSTS_BY_ID = _POSTS.where(db.posts.c.id.in_(bindparam("ids", expanding=True)))
_BOARDS = select(db.boards).order_by(db.boards.c.position, db.boards.c.id)
_ACCOUNT_BY_NAME = ACCOUNT.where(db.accounts.c.name == bindparam("name"))
_NAMES = select(db.accounts.c.name).where(db.accounts.c.name.in_(bindparam("names", expanding=True)))
_ROBOTS = ACCOUNT.where(db.accounts.c.kind == AccountKind.ROBOT_AGENT).order_by(db.accounts.c.name)
_IMAGES_OF_POSTS = (
    select(db.post_images.c.post_id, db.images.c.id, db.images.c.width, db.images.c.height, db.images.c.media_type)
    .join(db.images, db.images.c.id == db.post_images.c.image_id)
    .where(db.post_images.c.post_id.in_(bindparam("ids", expanding=True)), db.images.c.gone_us.is_(None))
    .order_by(db.post_images.c.post_id, db.post_images.c.position)
)
_EVENTS = select(db.events, *_AUTHOR).outerjoin(db.accounts, db.accounts.c.id == db.events.c.account_id)
_NEWEST_EVENT = select(db.events.c.id, db.events.c.at_us).order_by(db.events.c.id.desc()).limit(1)
_OLDEST_EVENT = select(db.events.c.id).order_by(db.events.c.id).limit(1)
#: The newest change in the audit log, and the newest event of a topic: whatever its posts show changes with one.
_TOPIC_VERSION = select(
    select(func.max(db.audit.c.id)).scalar_subquery(),
    select(func.max(db.events.c.id)).where(db.events.c.topic_id == bindparam("id")).scalar_subquery(),
)
_TOPIC_VERSION_SQLITE = "SELECT (SELECT max(id) FROM audit), (SELECT max(id) FROM events WHERE topic_id = ?)"
_NEWEST_POST = select(func.max(db.posts.c.id))
_EVENT_TIME = select(db.events.c.at_us).where(db.events.c.id == bindparam("id"))
#: The event id after which everything comes.
BEFORE_ALL = "0"


def row_id(text: str, what: str) -> int:
    """Parse an id. Raises 404 if it cannot be one."""
    if text.isascii() and text.isdigit() and (number := int(text[:20])) <= LARGEST_ID and len(text) < 20:
        return number
    raise not_found(what, text)


def not_found(what: str, which: str, hint: str = "") -> BoardError:
    return BoardError(404, f"no_such_{what}", f"there is no {what} {which[:64]!r}", hint)


class Reader:
    """Reads on one connection, from one thread at a time. Raises `BoardError` 404 and 503.

    `sees` says which boards the reader may see; without it all are seen. Content of other boards counts as missing.
    `cache` keeps what was read; never within a transaction that writes.
    """

    def __init__(
        self, connection: Connection, sees: Callable[[], frozenset[str]] | None = None, cache: ReadCache | None = None
    ) -> None:
        self.connection = connection
        self._sees, self._cache = sees, cache
        #: Whether the database is known to be unreachable; then nobody waits for it, above all not the event loop.
        self.gone: Callable[[], bool] = lambda: False

    def rows(self, statement: Executable, **values: Any) -> Sequence[Row[Any]]:
        if self.gone():
            raise BoardError(503, "storage", "the database cannot be reached", "try again in a moment", 1.0)
        try:
            return self._rows(statement, values)
        except DBAPIError as e:
            raise unavailable(e) from e

    def _rows(self, statement: Executable, values: dict[str, Any]) -> Sequence[Row[Any]]:
        try:
            return self.connection.execute(statement, values).all()
        except DBAPIError as e:
            if not e.connection_invalidated:
                raise
            self.connection.rollback()  # the next read connects anew
            if self._cache is None:
                raise
        return self.connection.execute(statement, values).all()  # a server that was started again meanwhile

    def kept(self, key: Hashable, read: Callable[[], T], *, access: bool = False) -> T:
        """The result of `read`, cached until it may have changed, by any process (`ReadCache.kept`)."""
        return read() if self._cache is None or self.gone() else self._cache.kept(key, read, access=access)

    def version(self) -> int | None:
        """A number that changes with every commit of another connection; None if the database has none."""
        return None if self._cache is None else self._cache.commits()

    def topic_version(self, topic_id: int) -> tuple[int | None, int | None]:
        """A version that changes with everything that a page of this topic's posts shows.

        Every change of a post adds an event in its topic, and every change of an account, a board or a picture that is
        not its owner's own adds to the audit log, in the same transaction.
        """
        try:
            if self.connection.dialect.name == "sqlite":  # used by every request: ten times as fast without SQLAlchemy
                raw: Any = self.connection.connection.dbapi_connection
                row = raw.execute(_TOPIC_VERSION_SQLITE, (topic_id,)).fetchone()
            else:
                row = self.rows(_TOPIC_VERSION, id=topic_id)[0]
        except sqlite3.Error as e:
            raise unavailable(OperationalError(None, None, e)) from e
        return row[0], row[1]

    def seen(self) -> frozenset[str] | None:
        """The boards that this reader may see now; None for all."""
        if self._sees is None:
            return None
        sees = self._sees()
        return None if sees.issuperset(b.id for b in self.all_boards()) else sees

    def first(self, statement: Select[Any], **values: Any) -> Row[Any] | None:
        found = self.rows(statement, **values)
        return found[0] if found else None

    # ---------------------------------------------------------------- boards and topics
    def all_boards(self) -> tuple[Board, ...]:
        """All boards, regardless of the viewer."""
        return self.kept("boards", lambda: tuple(map(board_from, self.rows(_BOARDS))), access=True)

    def boards(self) -> tuple[Board, ...]:
        boards, seen = self.all_boards(), self.seen()
        return boards if seen is None else tuple(b for b in boards if b.id in seen)

    def board_names(self) -> dict[str, str]:
        """The names of the boards that are seen, by id."""
        return {board.id: board.name for board in self.boards()}

    def board(self, board_id: str) -> Board:
        boards = self.boards()
        for board in boards:
            if board.id == board_id:
                return board
        raise not_found("board", board_id, "valid: " + (", ".join(b.id for b in boards) or "none"))

    def topics(
        self, board_id: str | None, cursor: str | None = None, limit: int = 20, tag: str | None = None
    ) -> Page[Topic]:
        """Latest activity first, of one board or of all, with a tag; without topics whose posts are all removed."""
        t = db.topics.c
        statement = _TOPICS.where(t.posts > 0).order_by(t.last_post_id.desc()).limit(_limit(limit) + 1)
        if board_id is not None:
            statement = statement.where(t.board_id == self.board(board_id).id)
        elif (seen := self.seen()) is not None:
            statement = statement.where(t.board_id.in_(seen))
        if tag is not None:
            statement = statement.where(t.id.in_(select(db.topic_tags.c.topic_id).where(db.topic_tags.c.tag == tag)))
        if cursor:
            statement = statement.where(t.last_post_id < from_cursor(cursor))
        rows = self.rows(statement)
        return Page(tuple(map(topic_from, rows[:limit])), _cursor([r.last_post_id for r in rows], limit))

    def topics_by_id(self, ids: Sequence[int]) -> tuple[Topic, ...]:
        """The visible ones, in this order."""
        rows, seen = self.rows(_TOPICS_BY_ID, ids=ids), self.seen()
        found = {r.id: topic_from(r) for r in rows if seen is None or r.board_id in seen}
        return tuple(found[i] for i in ids if i in found)

    def topic(self, topic_id: str) -> Topic:
        number = row_id(topic_id, "topic")
        row = self.kept(("topic", number), lambda: self.first(_TOPIC, id=number))
        if row is None or ((seen := self.seen()) is not None and row.board_id not in seen):
            raise not_found("topic", topic_id)
        return topic_from(row)

    def title_begun_by(self, post: StoredPost) -> str:
        """The title of the topic if this is its first post, else empty."""
        p = db.posts.c
        first = self.first(select(func.min(p.id)).where(p.topic_id == int(post.topic_id)))
        return self.topic(post.topic_id).title if first and str(first[0]) == post.id else ""

    # ---------------------------------------------------------------- posts
    def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[StoredPost]:
        """Oldest first, including removed ones (empty). Raises 404."""
        topic = self.topic(topic_id)
        after = from_cursor(cursor) if cursor else 0
        rows = self.rows(_POSTS_OF_TOPIC, of=int(topic.id), after=after, most=_limit(limit) + 1)
        return Page(self._posts(rows[:limit]), _cursor([r.id for r in rows], limit))

    def posts_by(self, author: Account, limit: int = 20) -> tuple[StoredPost, ...]:
        """Posts of an account, newest first, without removed ones."""
        p = db.posts.c
        mine = and_(p.author_id == int(author.id), p.removed.is_(False))
        statement = _POSTS.where(mine).order_by(p.id.desc()).limit(_limit(limit))
        if (seen := self.seen()) is not None:
            statement = statement.where(db.topics.c.board_id.in_(seen))
        return self._posts(self.rows(statement))

    def latest_posts(
        self, cursor: str | None, limit: int, board_id: str | None = None, topic_id: str | None = None
    ) -> Page[StoredPost]:
        """Newest first, of one board, one topic or of all, without removed ones."""
        p, t = db.posts.c, db.topics.c
        statement = _POSTS.where(p.removed.is_(False)).order_by(p.id.desc()).limit(_limit(limit) + 1)
        if topic_id is not None:
            statement = statement.where(p.topic_id == int(self.topic(topic_id).id))
        elif board_id is not None:
            statement = statement.where(t.board_id == self.board(board_id).id)
        elif (seen := self.seen()) is not None:
            statement = statement.where(t.board_id.in_(seen))
        if cursor:
            statement = statement.where(p.id < from_cursor(cursor))
        rows = self.rows(statement)
        return Page(self._posts(rows[:limit]), _cursor([r.id for r in rows], limit))

    def cursor_before(self, post_id: str, limit: int = 50) -> str | None:
        """The cursor of the page of `posts(limit=limit)` that shows this post; None for the first page."""
        p = db.posts.c
        number = row_id(post_id, "post")
        topic_id = self.first(select(p.topic_id).where(p.id == number))
        if topic_id is None:
            raise not_found("post", post_id)
        self.topic(str(topic_id[0]))
        earlier = and_(p.topic_id == topic_id[0], p.id < number)
        counted = self.rows(select(func.count()).select_from(db.posts).where(earlier))[0][0]
        start = counted - counted % _limit(limit)
        if start == 0:
            return None
        before = self.rows(select(p.id).where(earlier).order_by(p.id).offset(start - 1).limit(1))
        return to_cursor(before[0][0])

    def post(self, post_id: str) -> StoredPost:
        found = self.posts_by_id([row_id(post_id, "post")])
        if not found:
            raise not_found("post", post_id)
        return found[0]

    def posts_by_id(self, ids: Sequence[int]) -> tuple[StoredPost, ...]:
        rows, seen = self.rows(_POSTS_BY_ID, ids=ids), self.seen()
        return self._posts(rows if seen is None else [r for r in rows if r.board_id in seen])

    def find(self, author: Account, key: str) -> StoredPost | None:
        """The author's own post written under `key`."""
        p = db.posts.c
        found = self._posts(self.rows(_POSTS.where(p.author_id == int(author.id), p.key == key)))
        return found[0] if found else None

    def status_post(self, robot: Account, post: StoredPost) -> StoredPost | None:
        """The robot's newest reply with a card to a command; each run of a schedule has one of its own."""
        p = db.posts.c
        ours = (p.topic_id == int(post.topic_id), p.author_id == int(robot.id), p.reply_to == int(post.id))
        found = self._posts(
            self.rows(_POSTS.where(*ours, p.card.is_not(None), ~p.removed).order_by(p.id.desc()).limit(1))
        )
        return found[0] if found else None

    def versions(self, post_id: str) -> tuple[Version, ...]:
        """Earlier versions, oldest first."""
        v = db.post_versions.c
        rows = self.rows(select(v.version, v.raw, v.until_us).where(v.post_id == int(self.post(post_id).id)))
        return tuple(Version(r.version, r.raw, from_us(r.until_us)) for r in sorted(rows, key=lambda r: r.version))

    def _posts(self, rows: Sequence[Row[Any]]) -> tuple[StoredPost, ...]:
        images = self._images([r.id for r in rows if r.has_images and not r.removed])
        authors = {r.a_id: r for r in rows}  # few people write many posts
        accounts = {a_id: account_from(r) for a_id, r in authors.items()}
        return tuple(post_from(r, accounts[r.a_id], images.get(r.id, ())) for r in rows)

    def _images(self, post_ids: Sequence[int]) -> dict[int, tuple[Image, ...]]:
        found: dict[int, tuple[Image, ...]] = {}
        for r in self.rows(_IMAGES_OF_POSTS, ids=post_ids) if post_ids else ():
            found[r.post_id] = (*found.get(r.post_id, ()), Image(str(r.id), r.width, r.height, r.media_type))
        return found

    def image(self, image_id: str) -> tuple[Image, str]:
        """The image and the hash that names its file."""
        row = self.first(select(db.images).where(db.images.c.id == row_id(image_id, "image")))
        if row is None or row.gone_us is not None:
            raise not_found("image", image_id)
        return Image(str(row.id), row.width, row.height, row.media_type), row.sha256

    def image_shown(self, image_id: str, viewer: Account | None) -> bool:
        """Whether a visible post that is not removed shows the image; its owner always sees it."""
        i, pi = db.images.c, db.post_images.c
        number = int(image_id)
        if viewer and self.first(select(i.id).where(i.id == number, i.account_id == int(viewer.id))):
            return True
        shown = select(pi.post_id).join(db.posts, db.posts.c.id == pi.post_id)
        if (seen := self.seen()) is not None:
            shown = shown.join(db.topics, db.topics.c.id == db.posts.c.topic_id).where(db.topics.c.board_id.in_(seen))
        return self.first(shown.where(pi.image_id == number, db.posts.c.removed.is_(False)).limit(1)) is not None

    def image_robot(self, image_id: str) -> str | None:
        """The robot whose agent uploaded the image; None if a person did."""
        robots = and_(db.images.c.id == int(image_id), db.accounts.c.kind == AccountKind.ROBOT_AGENT)
        query = select(db.accounts.c.name).join(db.images, db.images.c.account_id == db.accounts.c.id).where(robots)
        row = self.first(query)
        return row.name if row else None

    # ---------------------------------------------------------------- accounts
    def account(self, name: str) -> Account | None:
        row = self.first(_ACCOUNT_BY_NAME, name=name.lower())
        return account_from(row) if row else None

    def names(self, names: Collection[str]) -> frozenset[str]:
        """Which of these names (lower case) are accounts."""
        return frozenset(row.name for row in self.rows(_NAMES, names=list(names)))

    def robots(self) -> tuple[Account, ...]:
        """All accounts of robot agents."""
        return self.kept("robots", lambda: tuple(map(account_from, self.rows(_ROBOTS))), access=True)

    def newest_post_id(self) -> int:
        return int(self.rows(_NEWEST_POST)[0][0] or 0)

    # ---------------------------------------------------------------- events
    def newest_event_id(self) -> str:
        found = self.kept("newest event", lambda: self.first(_NEWEST_EVENT))
        return event_id(found.id, found.at_us) if found else BEFORE_ALL

    def known_event(self, wanted: str) -> int:
        """The number of an event id, if no event can be missed by resuming after it.

        404 for an event of another history, as before a restored backup or a lost disk: its number may belong to
        another event now, but not its time. 404 also for an event that was pruned (`retention`). `BEFORE_ALL` and bare
        numbers, the ids of earlier versions, are only compared with the newest and oldest event.
        """
        number, _, tag = wanted.partition("-")
        if number.isascii() and number.isdigit() and len(number) < 19:
            if tag and (row := self.first(_EVENT_TIME, id=int(number))) and event_id(int(number), row.at_us) == wanted:
                return int(number)
            if wanted == number and (wanted == BEFORE_ALL or self._may_go_on_after(int(number))):
                return int(number)
        raise not_found("event", wanted, f"the newest is {self.newest_event_id()}")

    def _may_go_on_after(self, number: int) -> bool:
        row = self.first(_OLDEST_EVENT)
        return row is not None and row.id - 1 <= number <= event_number(self.newest_event_id())

    def events(
        self, after: int, limit: int, topic_id: str | None = None, boards: frozenset[str] | None = None
    ) -> tuple[StoredEvent, ...]:
        """Oldest first, with posts as they are now; of posts only those of `boards` when given."""
        e = db.events.c
        statement = _EVENTS.where(e.id > after).order_by(e.id).limit(_limit(limit))
        if (seen := self.seen() if boards is None else boards) is not None:
            statement = statement.outerjoin(db.topics, db.topics.c.id == e.topic_id).where(
                or_(e.topic_id.is_(None), db.topics.c.board_id.in_(seen))
            )
        if topic_id is not None:
            statement = statement.where(e.topic_id == row_id(topic_id, "topic"))
        rows = self.rows(statement)
        posts = {int(p.id): p for p in self.posts_by_id(sorted({r.post_id for r in rows if r.post_id}))}
        return tuple(event_from(r, posts.get(r.post_id)) for r in rows)


# -------------------------------------------------------------------- cursors
def event_number(given_out: str) -> int:
    """Return the sequence number in an event id."""
    return int(given_out.partition("-")[0])


def _cursor(ids: Sequence[int], limit: int) -> str | None:
    return to_cursor(ids[limit - 1]) if len(ids) > limit else None


def _limit(limit: int) -> int:
    if not 1 <= limit <= MAX_LIMIT:
        raise BoardError(422, "bad_limit", f"limit {limit} is out of range", f"1 to {MAX_LIMIT}")
    return limit
