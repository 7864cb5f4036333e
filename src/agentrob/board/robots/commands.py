"""Store the record of each finished command: one per post and robot, sent by the robot's agent."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import and_, func, insert, select, update

from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader, not_found, row_id
from agentrob.board.db.records import StoredPost, from_us, now_us
from agentrob.board.db.writer import Transaction
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, CommandState, Plan
from agentrob.model.plans import step_of

#: Bytes of JSON and levels of nesting that a record may have.
RECORD_BYTES, RECORD_DEPTH = 64 * 1024, 20


@dataclass(frozen=True, slots=True)
class CommandRecord:
    """A robot's record of a command. `reply` is the robot's own post that reports it, with the pictures."""

    robot: str
    at: datetime
    reply: StoredPost | None
    record: Mapping[str, Any]


def save_record(t: Transaction, by: Account, post_id: str, reply_id: str | None, record: Mapping[str, Any]) -> None:
    """Store or replace a robot's record. 404 if the posts do not exist, 403 if the reply is not the robot's own."""
    reader = Reader(t.connection)
    post = reader.post(post_id)
    if post.removed:
        raise not_found("post", post_id)
    reply = reader.post(reply_id) if reply_id is not None else None
    if reply is not None and (reply.author.id != by.id or reply.topic_id != post.topic_id):
        raise BoardError(
            403,
            "not_yours",
            "reply_id is not a reply of this robot in this topic",
            "send the id of the robot's own reply",
        )
    c = db.commands.c
    key = {"post_id": int(post.id), "robot_id": int(by.id)}
    values = {"reply_id": int(reply.id) if reply else None, "at_us": now_us(), "record": dict(record)}
    mine = and_(c.post_id == key["post_id"], c.robot_id == key["robot_id"])
    if t.connection.execute(update(db.commands).where(mine).values(**values)).rowcount == 0:
        t.connection.execute(insert(db.commands).values(**key, **values))


def records_of(reader: Reader, post_id: str) -> tuple[StoredPost, tuple[CommandRecord, ...]]:
    """The post of a command and the robots' records of it, by name of the robot.

    A removed post has no records, since they may repeat its words; nor have the runs of its schedule. 404 if it does
    not exist or may not be seen.
    """
    post = reader.post(str(row_id(post_id, "post")))
    if removed(reader, post):
        return post, ()
    c, a = db.commands.c, db.accounts.c
    statement = select(db.commands, a.name).join(db.accounts, a.id == c.robot_id).where(c.post_id == int(post.id))
    rows = reader.rows(statement.order_by(a.name))
    replies = {int(p.id): p for p in reader.posts_by_id([r.reply_id for r in rows if r.reply_id is not None])}
    return post, tuple(CommandRecord(r.name, from_us(r.at_us), replies.get(r.reply_id), r.record) for r in rows)


def removed(reader: Reader, post: StoredPost) -> bool:
    """Whether the post of a command was removed, or the one with the schedule of which it is a run."""
    asked = schedule_of(reader, post)
    return post.removed or (asked is not None and asked.removed)


def schedule_of(reader: Reader, post: StoredPost) -> StoredPost | None:
    """The post with the schedule of which the command in this post is a run: the robot's report is the run's own post,
    and replies to it. None for any other post."""
    if post.author.kind is not AccountKind.ROBOT_AGENT or post.reply_to is None:
        return None
    return next(iter(reader.posts_by_id([int(post.reply_to)])), None)


def newest_record_us(reader: Reader, topic_id: str) -> int:
    """When the newest record of a command in a topic was sent; 0 if there is none."""
    c, p = db.commands.c, db.posts.c
    newest = select(func.max(c.at_us)).join(db.posts, p.id == c.post_id)
    return int(reader.rows(newest.where(p.topic_id == row_id(topic_id, "topic")))[0][0] or 0)


def record_pictures(reader: Reader, reply_ids: Sequence[int]) -> dict[str, Any]:
    """The entries of records about the pictures of these replies, by reply."""
    c = db.commands.c
    rows = reader.rows(select(c.reply_id, c.record).where(c.reply_id.in_(reply_ids))) if reply_ids else ()
    return {str(row.reply_id): row.record.get("pictures") for row in rows}


def done_plans(reader: Reader, topic_id: str, robot: Account, most: int = 5) -> tuple[Plan, ...]:
    """The plans that a robot's records call done in a topic, oldest first, as far as they can be read."""
    c, p = db.commands.c, db.posts.c
    statement = select(c.record).join(db.posts, p.id == c.post_id).order_by(c.post_id.desc()).limit(most)
    mine = statement.where(p.topic_id == row_id(topic_id, "topic"), c.robot_id == int(robot.id), p.removed.is_(False))
    records = (row.record for row in reversed(reader.rows(mine)))
    plans = (_plan(record.get("plan")) for record in records if record.get("status") == CommandState.DONE)
    return tuple(plan for plan in plans if plan is not None)


def _plan(data: object) -> Plan | None:
    try:
        steps = tuple(step_of(step) for step in data) if isinstance(data, list) else ()
    except (ValueError, AttributeError):
        return None
    return Plan(steps) if steps else None


def answered(reader: Reader, post_id: str) -> str | None:
    """The id of the command that a post of a robot reports or claims; None for any other post."""
    post = reader.post(str(row_id(post_id, "post")))
    if post.author.kind is not AccountKind.ROBOT_AGENT:
        return None
    c = db.commands.c
    recorded = select(c.post_id).where(c.reply_id == int(post.id), c.robot_id == int(post.author.id))
    asked = row.post_id if (row := reader.first(recorded)) else post.reply_to if post.card else None
    return None if asked is None or str(asked) == post.id else str(asked)


def check_robot(by: Account, named: object, what: str) -> None:
    """403 for what a robot's agent says in the name of another robot: a card has that robot's stop button."""
    if not by.speaks_for(named):
        said = f"this {what} names {str(named)[:64]!r}, but the account is {by.name!r}"
        raise BoardError(403, "not_this_robot", said, f"robot: {by.name!r}, or that robot's own token")


def check(value: dict[str, Any], what: str, most_bytes: int, depth: int) -> None:
    """413 for JSON that is too large, 422 for values that JSON does not have or a page cannot show."""
    try:
        size = len(json.dumps(value, allow_nan=False, ensure_ascii=False).encode())
        if not _plain(value, depth):
            raise ValueError("nested too deeply, or a number that is too large")
    except (ValueError, RecursionError) as e:
        reason = "a broken character" if isinstance(e, UnicodeError) else str(e)
        hint = f"finite numbers below 2^53, whole characters, at most {depth} levels"
        raise BoardError(422, f"bad_{what}", f"that {what} cannot be shown: {reason}"[:200], hint) from None
    if size > most_bytes:
        raise BoardError(413, f"{what}_too_large", f"the {what} has {size} bytes", f"at most {most_bytes} bytes")


def _plain(value: object, depth: int) -> bool:
    if isinstance(value, (dict, list)):
        inside = value.values() if isinstance(value, dict) else value
        return depth > 0 and all(_plain(v, depth - 1) for v in inside)
    return not isinstance(value, int) or abs(value) < 2**53
