"""Limit how often an account may post, command, upload and edit per hour, counted from rows in the database.

The check is part of the transaction that writes, so that concurrent requests cannot pass it together. A refusal is a
429 that names the limit and says when the next use is allowed. A stop is never limited (law 15).
"""

from __future__ import annotations

import math
from typing import Any

from sqlalchemy import Connection, Integer, Select, Table, bindparam, select

from agentrob.board.auth.attempts import record_use
from agentrob.board.db import schema as db
from agentrob.board.db.records import now_us
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind

HOUR_US = 3_600_000_000


def _nth(table: Table, owner: Any) -> Select[Any]:
    """Select when an account made its n-th newest row."""
    mine = select(table.c.created_us).where(owner == bindparam("by")).order_by(table.c.id.desc())
    return mine.offset(bindparam("before", type_=Integer)).limit(1)


_NTH_POST = _nth(db.posts, db.posts.c.author_id)
_NTH_IMAGE = _nth(db.images, db.images.c.account_id)


def check_posts(connection: Connection, author: Account, most: int) -> None:
    """429 when the account wrote `most` posts within the last hour. 0 means no limit."""
    _check(connection, _NTH_POST, author, most, "posts", "written {count} posts")


def check_uploads(connection: Connection, by: Account, most: int) -> None:
    """429 when the account uploaded `most` pictures within the last hour."""
    _check(connection, _NTH_IMAGE, by, most, "uploads", "uploaded {count} pictures")


def check_commands(connection: Connection, author: Account, most: int, robots: frozenset[str]) -> None:
    """429 when `most` posts of the account within the last hour mention a robot."""
    p, now = db.posts.c, now_us()
    recent = select(p.created_us, p.mentions).where(p.author_id == int(author.id), p.created_us > now - HOUR_US)
    # Newest first, by the index of posts by author; ends at the limit.
    times = []
    for row in connection.execute(recent.order_by(p.id.desc())):
        if not robots.isdisjoint(row.mentions):
            times.append(row.created_us)
        if len(times) >= most:
            raise _too_many("commands", f"commanded robots {most} times", times[-1] + HOUR_US - now)


def record_change(connection: Connection, by: Account, most: int) -> None:
    """Record an edit or a choice of tags. 429 after `most` within the last hour. Robots are exempt."""
    if by.kind is AccountKind.ROBOT_AGENT:
        return
    if (wait_s := record_use(connection, "change", by.id, most)) is not None:
        raise _too_many("changes", f"edited posts and chosen tags {most} times", int(wait_s * 1_000_000))


def _check(connection: Connection, nth: Select[Any], by: Account, most: int, what: str, done: str) -> None:
    if not most:
        return
    now = now_us()
    oldest = connection.execute(nth, {"by": int(by.id), "before": most - 1}).scalar_one_or_none()
    if oldest is not None and oldest > now - HOUR_US:
        raise _too_many(what, done.format(count=most), oldest + HOUR_US - now)


def _too_many(what: str, done: str, wait_us: int) -> BoardError:
    wait_s = max(1.0, wait_us / 1_000_000)
    minutes = math.ceil(wait_s / 60)
    when = "in a minute" if minutes == 1 else f"in {minutes} minutes"
    said = f"this account has {done} within the last hour, which is the limit; try again {when}"
    return BoardError(429, f"too_many_{what}", said, "a stop always works", wait_s)
