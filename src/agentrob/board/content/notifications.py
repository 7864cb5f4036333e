"""Notify accounts that a post mentions, that it replies to, or that started its topic; track what each has seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, and_, bindparam, delete, func, insert, select, update

from agentrob.board.auth import rights
from agentrob.board.db import schema as db
from agentrob.board.db.cursors import from_cursor, to_cursor
from agentrob.board.db.reader import ACCOUNT, Reader
from agentrob.board.db.records import StoredPost
from agentrob.board.db.rows import account_from
from agentrob.board.db.writer import Transaction
from agentrob.model import Account, AccountKind, Page, Role

#: More than this many are not counted.
MOST = 99
REASONS = {"mention": "mentions you", "reply": "replies to you", "topic": "is in your topic"}
REASONS |= {"approve": "waits for your approval"}
#: The largest number of approvers that are notified of one waiting command.
MOST_APPROVERS = 100
#: Robots and monitoring agents listen to events instead.
_TOLD = (AccountKind.HUMAN, AccountKind.COMMANDING_AGENT)
_BEGAN = select(db.topics.c.author_id).where(db.topics.c.id == bindparam("topic"))
_PEOPLE = select(db.accounts.c.id).where(
    db.accounts.c.id.in_(bindparam("ids", expanding=True)), db.accounts.c.kind.in_(_TOLD)
)


def _unread(boards: bool) -> Select[Any]:
    """Select what `me` has not seen, on all boards or on `boards`. Built once, because every page shows the number."""
    n, p, t, s = db.notices.c, db.posts.c, db.topics.c, db.notices_seen.c
    seen = select(s.post_id).where(s.account_id == bindparam("me")).scalar_subquery()
    fresh = select(n.post_id, p.topic_id).where(n.account_id == bindparam("me"), n.post_id > func.coalesce(seen, 0))
    fresh = fresh.join(db.posts, and_(p.id == n.post_id, p.removed.is_(False)))
    # Posts that were read in their topic count as seen too.
    r = db.topic_reads.c
    fresh = fresh.outerjoin(db.topic_reads, and_(r.account_id == bindparam("me"), r.topic_id == p.topic_id))
    fresh = fresh.where(p.id > func.coalesce(r.post_id, 0))
    if boards:
        fresh = fresh.join(db.topics, t.id == p.topic_id).where(t.board_id.in_(bindparam("boards", expanding=True)))
    return fresh.limit(MOST)


_NOTHING: Mapping[int, int] = {}
_UNREAD = {boards: _unread(boards) for boards in (False, True)}


@dataclass(frozen=True, slots=True)
class Notification:
    """`reason` is a word of `REASONS`; `fresh`: not seen before."""

    post: StoredPost
    reason: str
    fresh: bool


def notify(
    t: Transaction, post_id: int, topic_id: int, author: Account, mentions: Sequence[str], reply_to: int | None
) -> None:
    """Notify people and agents of a new post; only the first of several reasons counts."""
    a, p = db.accounts.c, db.posts.c
    reasons = {int(t.connection.execute(_BEGAN, {"topic": topic_id}).scalar_one()): "topic"}
    if reply_to is not None:
        answered = select(p.author_id).where(p.id == reply_to)
        reasons |= {int(i): "reply" for i in t.connection.execute(answered).scalars()}
    if mentions:
        named = select(a.id).where(a.name.in_(mentions))
        reasons |= {int(i): "mention" for i in t.connection.execute(named).scalars()}
    reasons.pop(int(author.id), None)
    if not reasons:
        return
    people = t.connection.execute(_PEOPLE, {"ids": list(reasons)}).scalars()
    rows = [{"account_id": i, "post_id": post_id, "reason": reasons[i]} for i in people]
    if rows:
        t.connection.execute(insert(db.notices), rows)


def notify_approvers(t: Transaction, status_id: int, robot: Account, command_id: int | None, waits: bool) -> None:
    """Notify those who may approve a command that its robot waits, by the robot's status post; and no more when that is
    over."""
    n, a = db.notices.c, db.accounts.c
    about_status = n.post_id == status_id
    if not waits:
        t.connection.execute(delete(db.notices).where(about_status, n.reason == "approve"))
        return
    if command_id is None:
        return
    reader = Reader(t.connection)
    command, kept = reader.post(str(command_id)), rights.settings_of(reader, robot.name)
    rank = max(Role.OPERATOR.rank, reader.board(command.board_id).read_role.rank)
    roles = [role for role in Role if role.rank >= rank]
    people = ACCOUNT.where(a.kind == AccountKind.HUMAN, a.role.in_(roles), a.suspended.is_(False)).order_by(a.id)
    may = [int(p.id) for p in map(account_from, reader.rows(people)) if rights.approves(kept, p, command.author)]
    if may := may[:MOST_APPROVERS]:
        t.connection.execute(delete(db.notices).where(about_status, n.account_id.in_(may)))
        rows = [{"account_id": i, "post_id": status_id, "reason": "approve"} for i in may]
        t.connection.execute(insert(db.notices), rows)


def unread(reader: Reader, account: Account, read: Mapping[int, int] = _NOTHING) -> int:
    """How many an account has not seen, at most `MOST`. `read` are read positions by topic that are not stored yet."""
    values: dict[str, Any] = {"me": int(account.id)}
    if (seen := reader.seen()) is not None:
        values["boards"] = list(seen)
    rows = reader.rows(_UNREAD[seen is not None], **values)
    return sum(row.post_id > read.get(row.topic_id, 0) for row in rows)


def latest(
    reader: Reader,
    account: Account,
    cursor: str | None = None,
    limit: int = 30,
    read: Mapping[int, int] = _NOTHING,
) -> Page[Notification]:
    """An account's notifications, newest first; those of posts that are gone or hidden from it are left out. `read` as
    in `unread`."""
    n, r, seen = db.notices.c, db.topic_reads.c, _seen(reader, account)
    stored = func.coalesce(r.post_id, 0).label("read")
    statement = _visible(reader, _of(account, n.post_id, n.reason, stored))
    mine = and_(r.account_id == int(account.id), r.topic_id == db.posts.c.topic_id)
    statement = statement.outerjoin(db.topic_reads, mine).order_by(n.post_id.desc()).limit(limit + 1)
    if cursor:
        statement = statement.where(n.post_id < from_cursor(cursor))
    rows = reader.rows(statement)
    posts = {int(p.id): p for p in reader.posts_by_id([row.post_id for row in rows[:limit]])}
    items = tuple(
        Notification(post, row.reason, row.post_id > max(seen, row.read, read.get(int(post.topic_id), 0)))
        for row in rows[:limit]
        if (post := posts.get(row.post_id))
    )
    return Page(items, to_cursor(rows[limit - 1].post_id) if len(rows) > limit else None)


def asked(reader: Reader, account: Account) -> tuple[StoredPost, ...]:
    """The status posts of commands whose approval an account was asked for, the oldest first."""
    n = db.notices.c
    statement = _visible(reader, _of(account, n.post_id)).where(n.reason == "approve").order_by(n.post_id)
    return tuple(reader.posts_by_id([row.post_id for row in reader.rows(statement.limit(MOST))]))


def mark_seen(t: Transaction, account: Account, up_to: int) -> None:
    """Mark all notifications up to a post as seen; never moves back."""
    s = db.notices_seen.c
    newest = t.connection.execute(select(func.max(db.posts.c.id))).scalar_one() or 0
    up_to, mine = min(up_to, newest), s.account_id == int(account.id)
    before = t.connection.execute(select(s.post_id).where(mine)).scalar_one_or_none()
    if before is None:
        t.connection.execute(insert(db.notices_seen).values(account_id=int(account.id), post_id=up_to))
    elif before < up_to:
        t.connection.execute(update(db.notices_seen).where(mine).values(post_id=up_to))


def _of(account: Account, *columns: Any) -> Select[Any]:
    return select(*columns).where(db.notices.c.account_id == int(account.id))


def _visible(reader: Reader, statement: Select[Any]) -> Select[Any]:
    p, t, seen = db.posts.c, db.topics.c, reader.seen()
    statement = statement.join(db.posts, and_(p.id == db.notices.c.post_id, p.removed.is_(False)))
    return statement if seen is None else statement.join(db.topics, t.id == p.topic_id).where(t.board_id.in_(seen))


def _seen(reader: Reader, account: Account) -> int:
    s = db.notices_seen.c
    row: Sequence[Any] | None = reader.first(select(s.post_id).where(s.account_id == int(account.id)))
    return int(row[0]) if row else 0
