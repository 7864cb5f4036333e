"""Convert database rows to records."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Row

from agentrob.board.db.records import Board, Image, StoredEvent, StoredPost, Topic, from_us
from agentrob.model import Account, AccountKind, EventKind, Role


def account_from(row: Row[Any]) -> Account:
    return Account(
        id=str(row.a_id),
        name=row.a_name,
        kind=AccountKind(row.a_kind),
        role=Role(row.a_role),
        suspended=row.a_suspended,
        display_name=row.a_display_name or row.a_name,
        commands_simulated=row.a_commands_simulated,
    )


def board_from(r: Row[Any]) -> Board:
    return Board(r.id, r.name, r.description, Role(r.read_role), Role(r.post_role), Role(r.command_role))


def topic_from(r: Row[Any]) -> Topic:
    created, last = from_us(r.created_us), from_us(r.last_post_us)
    tags = tuple(sorted((r.tags or "").split()))
    return Topic(
        str(r.id), r.board_id, r.title, account_from(r), created, last, r.posts, r.locked, tags, str(r.last_post_id)
    )


def post_from(r: Row[Any], author: Account, images: tuple[Image, ...]) -> StoredPost:
    return StoredPost(
        id=str(r.id),
        topic_id=str(r.topic_id),
        board_id=r.board_id,
        author=author,
        raw="" if r.removed else r.raw,
        html="" if r.removed else r.html,
        version=r.version,
        created_at=from_us(r.created_us),
        edited_at=from_us(r.edited_us) if r.edited_us is not None else None,
        removed=r.removed,
        mentions=() if r.removed else tuple(r.mentions),
        reply_to=str(r.reply_to) if r.reply_to is not None else None,
        key=r.key,
        images=images,
        card=r.card if r.card and not r.removed and author.speaks_for(r.card.get("robot")) else None,
    )


def event_from(r: Row[Any], post: StoredPost | None) -> StoredEvent:
    account = account_from(r) if r.a_id is not None and r.robot is not None else None
    return StoredEvent(event_id(r.id, r.at_us), EventKind(r.kind), from_us(r.at_us), post, r.robot, account)


def event_id(number: int, at_us: int) -> str:
    """The id of an event row outside of the database: its number, and its time as the mark of this history."""
    return f"{number}-{at_us:x}"
