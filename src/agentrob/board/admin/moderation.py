"""Moderation and erasure: show hidden posts, lock and move topics, erase what an account wrote, expire pictures.

Moderation deletes nothing: moderators can read a hidden post and its versions, and show it again. Erasing deletes for
good, and only admins do it. Each adds a row to the audit log.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from sqlalchemy import and_, delete, or_, select, update

from agentrob.board.auth import rights
from agentrob.board.content.images import path_of
from agentrob.board.content.writes import add_event
from agentrob.board.db import audit
from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader, not_found, row_id
from agentrob.board.db.records import StoredPost, Topic, Version, from_us, now_us
from agentrob.board.db.writer import Transaction
from agentrob.board.services import Services
from agentrob.errors import BoardError
from agentrob.model import Account, EventKind

ERASED = "(deleted)"


def show(t: Transaction, by: Account, post_id: str, reason: str = "") -> StoredPost:
    """Show a hidden post again. It counts as an edit, so it starts no motion (law 4).

    409 for a post that its own author removed.
    """
    p = db.posts.c
    number = row_id(post_id, "post")
    row = t.connection.execute(select(p.removed, p.removed_by, p.author_id, p.raw).where(p.id == number)).first()
    post = Reader(t.connection).post(post_id)
    if row is None or not row.removed:
        return post
    if row.removed_by == row.author_id or not row.raw:
        raise BoardError(409, "removed", "its author removed this post, or it was erased", "it cannot be shown again")
    values = {"removed": False, "removed_by": None, "version": post.version + 1, "edited_us": now_us()}
    t.connection.execute(update(db.posts).where(p.id == number).values(**values))
    topics = db.topics.c
    t.connection.execute(update(db.topics).where(topics.id == int(post.topic_id)).values(posts=topics.posts + 1))
    add_event(t, EventKind.POST_EDITED, now_us(), topic_id=int(post.topic_id), post_id=number)
    audit.note(t.connection, by.name, "post.show", f"post:{post_id}", author=post.author.name, reason=reason)
    return Reader(t.connection).post(post_id)


def hidden(reader: Reader, post_id: str) -> tuple[StoredPost, tuple[Version, ...], str]:
    """A post with the text it had before it was hidden, its earlier versions, and who hid it (empty if it is not
    hidden)."""
    post = reader.post(post_id)
    p, a = db.posts.c, db.accounts.c
    found = select(p.raw, a.name).outerjoin(db.accounts, a.id == p.removed_by).where(p.id == int(post.id))
    row = reader.rows(found)[0]
    v = db.post_versions.c
    rows = reader.rows(select(v.version, v.raw, v.until_us).where(v.post_id == int(post.id)).order_by(v.version))
    versions = tuple(Version(r.version, r.raw, from_us(r.until_us)) for r in rows)
    return (replace(post, raw=row.raw) if post.removed else post), versions, row.name or ""


def lock(t: Transaction, by: Account, topic_id: str, locked: bool, reason: str = "") -> Topic:
    """Lock or unlock a topic. Only moderators and robots can post in a locked topic; a stop still works."""
    topic = Reader(t.connection).topic(topic_id)
    if topic.locked != locked:
        t.connection.execute(update(db.topics).where(db.topics.c.id == int(topic.id)).values(locked=locked))
        action = "topic.lock" if locked else "topic.unlock"
        audit.note(t.connection, by.name, action, f"topic:{topic.id}", reason=reason)
    return Reader(t.connection).topic(topic_id)


def move(t: Transaction, by: Account, topic_id: str, board_id: str, reason: str = "") -> Topic:
    """Move a topic to another board. Rights are checked again before any motion."""
    reader = Reader(t.connection)
    topic, board = reader.topic(topic_id), reader.board(board_id)
    if topic.board_id != board.id:
        t.connection.execute(update(db.topics).where(db.topics.c.id == int(topic.id)).values(board_id=board.id))
        details = {"from_board": topic.board_id, "to_board": board.id, "reason": reason}
        audit.note(t.connection, by.name, "topic.move", f"topic:{topic.id}", **details)
    return Reader(t.connection).topic(topic_id)


# -------------------------------------------------------------------- permanent deletion
def erase(t: Transaction, actor: str, name: str) -> tuple[int, int, frozenset[str]]:
    """Delete all posts and pictures of an account; return how many, and the files to delete.

    Also deletes its read positions and the records of its commands, which repeat its words, or, of a robot, the records
    that it sent. The rows of posts stay, empty, so that replies keep their place and no id is used twice; so does the
    account.
    """
    account = Reader(t.connection).account(name)
    if account is None:
        raise not_found("account", name)
    p, number = db.posts.c, int(account.id)
    rows = t.connection.execute(select(p.id, p.topic_id, p.removed).where(p.author_id == number, p.raw != "")).all()
    ids = [r.id for r in rows]
    for some in (ids[n : n + 500] for n in range(0, len(ids), 500)):
        t.connection.execute(delete(db.post_versions).where(db.post_versions.c.post_id.in_(some)))
        t.connection.execute(delete(db.post_images).where(db.post_images.c.post_id.in_(some)))
        empty: dict[str, Any] = {
            "raw": "",
            "html": "",
            "mentions": [],
            "card": None,
            "removed": True,
            "version": p.version + 1,
        }
        t.connection.execute(update(db.posts).where(p.id.in_(some)).values(**empty))
    wrote, c = select(p.id).where(p.author_id == number), db.commands.c
    t.connection.execute(delete(db.commands).where(or_(c.post_id.in_(wrote), c.robot_id == number)))
    r = db.replays.c
    t.connection.execute(delete(db.replays).where(or_(r.post_id.in_(wrote), r.robot_id == number)))
    topics = db.topics.c
    for row in rows:
        if not row.removed:
            less = update(db.topics).where(topics.id == row.topic_id).values(posts=topics.posts - 1)
            t.connection.execute(less)
            add_event(t, EventKind.POST_REMOVED, now_us(), topic_id=row.topic_id, post_id=row.id)
    t.connection.execute(update(db.topics).where(topics.author_id == number).values(title=ERASED))
    begun = select(topics.id).where(topics.author_id == number)
    t.connection.execute(delete(db.topic_tags).where(db.topic_tags.c.topic_id.in_(begun)))
    t.connection.execute(delete(db.topic_reads).where(db.topic_reads.c.account_id == number))
    pictures = db.images.c
    digests = _drop(t, and_(pictures.account_id == number, pictures.gone_us.is_(None)))
    audit.note(t.connection, actor, "account.erase", f"account:{account.name}", posts=len(ids), pictures=len(digests))
    return len(ids), len(digests), frozenset(digests)


def expire_pictures(t: Transaction, now: datetime | None = None) -> frozenset[str]:
    """Delete pictures of robots' cameras that are older than their owners keep them; return the files to delete."""
    reader, at, gone = Reader(t.connection), now or datetime.now(UTC), set()
    for robot in reader.robots():
        days = rights.settings_of(reader, robot.name).camera_days
        if days:
            before = int((at - timedelta(days=days)).timestamp() * 1_000_000)
            i = db.images.c
            old = and_(i.account_id == int(robot.id), i.created_us < before, i.gone_us.is_(None))
            digests = _drop(t, old)
            gone |= set(digests)
            if digests:
                audit.note(t.connection, "board", "pictures.expire", f"robot:{robot.name}", pictures=len(digests))
    return frozenset(gone)


def _drop(t: Transaction, which: object) -> Sequence[str]:
    i = db.images.c
    digests = t.connection.execute(select(i.sha256).where(which)).scalars().all()  # type: ignore[arg-type]
    t.connection.execute(update(db.images).where(which).values(gone_us=now_us()))  # type: ignore[arg-type]
    return digests


def take_away(t: Transaction, folder: Path, digests: Collection[str]) -> int:
    """Delete the files that no picture needs any more; return how many. Call it after the commit that released them."""
    i, taken = db.images.c, 0
    for digest in digests:
        needed = select(i.id).where(i.sha256 == digest, i.gone_us.is_(None)).limit(1)
        if t.connection.execute(needed).first() is None:
            path_of(folder, digest).unlink(missing_ok=True)
            taken += 1
    return taken


async def erase_content(services: Services, actor: str, name: str) -> tuple[int, int]:
    """Erase an account's content and its files; return how many posts and pictures."""
    posts, pictures, digests = await services.store.do(lambda t: erase(t, actor, name))
    await delete_files(services, digests)
    return posts, pictures


async def delete_files(services: Services, digests: Collection[str]) -> None:
    """Delete the files of pictures that are gone, unless another picture has the same content."""
    if digests:
        await services.store.do(lambda t: take_away(t, services.settings.images_dir, digests))
