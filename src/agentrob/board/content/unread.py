"""Read positions: the last post of each topic that an account has read, and how many posts are new since.

A page calls `ReadPositions.showed`, which updates a dictionary. Changes are written to the database in one job every
few seconds, so that reading a page never waits for the writer and rarely invalidates caches. If the server is killed,
posts read in the last few seconds count as unread again.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import structlog
from sqlalchemy import Integer, and_, bindparam, func, select, text, update

from agentrob.board.db import schema as db
from agentrob.board.db.cursors import from_cursor, to_cursor
from agentrob.board.db.reader import Reader
from agentrob.board.db.records import Topic
from agentrob.board.db.writer import Transaction
from agentrob.errors import BoardError
from agentrob.model import Account, Page

if TYPE_CHECKING:
    from agentrob.board.content.store import Store

#: The largest count of unread posts in a topic; the number of topics searched for unread posts.
MOST, LOOKED_AT = 99, 1000
#: Read positions kept in memory.
MAX_KEPT = 50_000
WRITE_EVERY_S = 5.0

log = structlog.get_logger(__name__)

_p, _r = db.posts.c, db.topic_reads.c
_NEW = (
    select(_p.id)
    .where(_p.topic_id == bindparam("topic"), _p.id > bindparam("after"))
    .where(_p.removed.is_(False), _p.author_id != bindparam("me"))
    .order_by(_p.id)
    .limit(bindparam("most", type_=Integer))
    .subquery()
)
_COUNTED = select(func.count(_NEW.c.id).label("new"), func.min(_NEW.c.id).label("first"))
_MARKS = select(_r.topic_id, _r.post_id).where(
    _r.account_id == bindparam("me"), _r.topic_id.in_(bindparam("topics", expanding=True))
)
_READ_UP_TO = select(db.accounts.c.read_up_to).where(db.accounts.c.id == bindparam("me"))
_WRITE = text(
    "INSERT INTO topic_reads (account_id, topic_id, post_id) VALUES (:account, :topic, :post) "
    "ON CONFLICT (account_id, topic_id) DO UPDATE SET post_id = excluded.post_id "
    "WHERE excluded.post_id > topic_reads.post_id"
)
_Key = tuple[int, int]  # account, topic


@dataclass(frozen=True, slots=True)
class UnreadCount:
    """The number of unread posts of others in a topic, at most `MOST` + 1, and the first of them."""

    count: int
    first: str

    def __str__(self) -> str:
        return f"{MOST}+ new" if self.count > MOST else f"{self.count} new"


class ReadPositions:
    """The read positions of accounts, cached. Use it on the event loop's thread only."""

    def __init__(self) -> None:
        self._known: dict[_Key, int] = {}
        self._pending: dict[_Key, int] = {}
        self._read_up_to: dict[int, int] = {}

    def showed(self, reader: Reader, account: Account | None, topic: Topic, post_id: str) -> None:
        """Record that a page showed a topic up to this post."""
        if account is None or not post_id:
            return
        key = int(account.id), int(topic.id)
        if int(post_id) > self._of(reader, key[0], (topic,))[topic.id]:
            self._known[key] = self._pending[key] = int(post_id)

    def unwritten(self, account: Account) -> dict[int, int]:
        """The read positions of an account that are not in the database yet, by topic."""
        me = int(account.id)
        return {topic: post for (who, topic), post in self._pending.items() if who == me}

    def news(self, reader: Reader, account: Account | None, topics: Collection[Topic]) -> dict[str, UnreadCount]:
        """The unread counts of an account, by topic; without topics that have none."""
        if account is None or not topics:
            return {}
        marks, found = self._of(reader, int(account.id), topics), dict[str, UnreadCount]()
        for topic in topics:
            if int(topic.last_post_id) <= (mark := marks[topic.id]):
                continue
            asked = {"topic": int(topic.id), "after": mark, "me": int(account.id), "most": MOST + 1}
            row = reader.kept(("news", *asked.values()), lambda asked=asked: reader.rows(_COUNTED, **asked)[0])  # type: ignore[misc]
            if row.new:
                found[topic.id] = UnreadCount(row.new, str(row.first))
        return found

    def unread(
        self, reader: Reader, account: Account, cursor: str | None, limit: int, board_id: str | None = None
    ) -> Page[tuple[Topic, UnreadCount]]:
        """Topics with unread posts, latest activity first, among the `LOOKED_AT` most recent ones of one board or of
        all.
        404."""
        t, me = db.topics.c, int(account.id)
        latest = select(t.id, t.last_post_id).where(t.posts > 0, t.last_post_id > self._base(reader, me))
        if board_id is not None:
            latest = latest.where(t.board_id == reader.board(board_id).id)
        elif (seen := reader.seen()) is not None:
            latest = latest.where(t.board_id.in_(seen))
        if cursor:
            latest = latest.where(t.last_post_id < from_cursor(cursor))
        some = latest.order_by(t.last_post_id.desc()).limit(LOOKED_AT).subquery()
        mine = and_(_r.account_id == me, _r.topic_id == some.c.id)
        statement = select(some).outerjoin(db.topic_reads, mine)
        statement = statement.where(some.c.last_post_id > func.coalesce(_r.post_id, 0))
        rows = reader.rows(statement.order_by(some.c.last_post_id.desc()).limit(limit + 1))
        topics = reader.topics_by_id([r.id for r in rows[:limit]])
        news = self.news(reader, account, topics)
        more = to_cursor(rows[limit - 1].last_post_id) if len(rows) > limit else None
        return Page(tuple((topic, news[topic.id]) for topic in topics if topic.id in news), more)

    async def topic_read(self, store: Store, account: Account, topic: Topic, up_to: int) -> None:
        """Mark the posts of a topic up to this one as read; never moves back."""
        await self._mark(store, int(account.id), lambda _: {int(topic.id): min(up_to, int(topic.last_post_id))})

    async def all_read(self, store: Store, account: Account, up_to: int, board_id: str | None = None) -> None:
        """Mark all posts up to this one as read, on a board or on all; never moves back.

        On a board this covers the topics that `unread` searches.
        """
        if board_id is not None:
            base = self._base(store.reader, int(account.id))
            await self._mark(store, int(account.id), lambda t: _marks_of(t, board_id, base, up_to))
            return
        a, me = db.accounts.c, int(account.id)

        def job(t: Transaction) -> int:
            newest = t.connection.execute(select(func.max(_p.id))).scalar_one() or 0
            mine, value = and_(a.id == me, a.read_up_to < min(up_to, newest)), {"read_up_to": min(up_to, newest)}
            t.connection.execute(update(db.accounts).where(mine).values(**value))
            return int(t.connection.execute(_READ_UP_TO, {"me": me}).scalar_one())

        self._read_up_to[me] = await store.do(job)

    async def _mark(self, store: Store, me: int, chosen: Callable[[Transaction], dict[int, int]]) -> None:
        """Write read positions of one account, by topic."""

        def job(t: Transaction) -> dict[int, int]:
            marks = chosen(t)
            if rows := [{"account": me, "topic": topic, "post": post} for topic, post in marks.items()]:
                t.connection.execute(_WRITE, rows)
            return marks

        for topic, post in (await store.do(job)).items():
            if (me, topic) in self._known:  # otherwise it is read when needed
                self._known[me, topic] = max(post, self._known[me, topic])

    async def write(self, store: Store) -> None:
        """Write changed positions. If that fails, they are kept for the next attempt."""
        pending, self._pending = self._pending, {}
        if not pending:
            return
        rows = [{"account": account, "topic": topic, "post": post} for (account, topic), post in pending.items()]

        def job(t: Transaction) -> None:
            t.connection.execute(_WRITE, rows)

        try:
            await store.do(job)
        except BoardError as e:
            log.warning("board.marks_not_written", marks=len(rows), error=str(e))
            self._pending = pending | self._pending

    def forget(self) -> None:
        """Drop cached positions except those that are not written yet."""
        self._known, self._read_up_to = dict(self._pending), {}

    # ---------------------------------------------------------------- pieces
    def _of(self, reader: Reader, me: int, topics: Iterable[Topic]) -> Mapping[str, int]:
        """The last read post of each topic."""
        base = self._base(reader, me)
        if len(self._known) > MAX_KEPT:
            self.forget()
        missing = [number for topic in topics if (me, number := int(topic.id)) not in self._known]
        if missing:
            there = {row.topic_id: row.post_id for row in reader.rows(_MARKS, me=me, topics=missing)}
            self._known |= {(me, number): there.get(number, 0) for number in missing}
        return {topic.id: max(base, self._known[me, int(topic.id)]) for topic in topics}

    def _base(self, reader: Reader, me: int) -> int:
        if me not in self._read_up_to:
            row = reader.first(_READ_UP_TO, me=me)
            self._read_up_to[me] = row.read_up_to if row else 0
        return self._read_up_to[me]


def _marks_of(t: Transaction, board_id: str, base: int, up_to: int) -> dict[int, int]:
    """The positions of the most recent topics of a board if everything up to a post is read."""
    c = db.topics.c
    some = select(c.id, c.last_post_id).where(c.board_id == board_id, c.last_post_id > base)
    rows = t.connection.execute(some.order_by(c.last_post_id.desc()).limit(LOOKED_AT))
    return {row.id: min(up_to, row.last_post_id) for row in rows}


async def run_flush_loop(marks: ReadPositions, store: Store, shared: bool) -> None:
    """Write read positions every few seconds, until cancelled. If several processes share the database, also drop the
    cache, to see what was read at the others."""
    while True:
        await asyncio.sleep(WRITE_EVERY_S)
        await marks.write(store)
        if shared:
            marks.forget()
