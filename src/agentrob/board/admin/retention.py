"""Delete old events, old idempotency keys, old replays and expired pictures of robots' cameras.

Posts, earlier texts, records of commands and the audit log are never deleted here.
"""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Any

import structlog
from sqlalchemy import ColumnElement, Select, Table, delete, func, or_, select

from agentrob.board.admin import moderation
from agentrob.board.db import schema as db
from agentrob.board.db.writer import Transaction
from agentrob.board.services import Services
from agentrob.config.board import BoardRetentionConfig
from agentrob.errors import BoardError

#: Seconds between two searches for old rows.
EVERY_S = 3600.0
#: Rows that one job deletes. A stop waits for one job at most.
AT_ONCE = 500
#: How long idempotency keys are kept. Clients repeat a write within minutes.
KEYS = timedelta(days=7)

log = structlog.get_logger(__name__)


async def keep_pruning(parts: Services) -> None:
    """Prune now and every hour, until cancelled."""
    keep = parts.settings.retention
    while True:
        try:
            for job in (prune_keys, prune_events, prune_replays):  # keys first: they point to events
                while await parts.store.do(partial(job, keep=keep)):
                    pass
        except BoardError as e:
            log.error("board.not_pruned", error=str(e))
        await asyncio.sleep(EVERY_S)


async def keep_expiring_pictures(services: Services) -> None:
    """Delete pictures of robots' cameras after the time that their owners set, now and every hour, until cancelled."""
    while True:
        try:
            await moderation.delete_files(services, await services.store.do(moderation.expire_pictures))
        except (BoardError, OSError) as e:
            log.error("board.pictures_not_expired", error=str(e))
        await asyncio.sleep(EVERY_S)


def prune_events(t: Transaction, keep: BoardRetentionConfig, now: datetime | None = None) -> bool:
    """Delete the oldest events that are older than `event_days` and not among the newest `events`; return whether there
    may be more. Always keeps the newest one, so that ids continue from it."""
    e, before = db.events.c, _us(now, timedelta(days=keep.event_days))
    newest = t.connection.execute(select(func.max(e.id))).scalar() or 0
    oldest = select(e.id, e.at_us).where(e.id <= newest - keep.events).order_by(e.id).limit(AT_ONCE)
    old = [row.id for row in t.connection.execute(oldest) if row.at_us < before]
    if old:
        t.connection.execute(delete(db.events).where(e.id.in_(old)))
    return len(old) == AT_ONCE


def prune_replays(t: Transaction, keep: BoardRetentionConfig, now: datetime | None = None) -> bool:
    """Delete replays of commands that are older than `replay_days`; return whether there may be more."""
    r, before = db.replays.c, _us(now, timedelta(days=keep.replay_days))
    old = t.connection.execute(select(r.post_id, r.robot_id).where(r.at_us < before).limit(AT_ONCE)).all()
    for row in old:
        t.connection.execute(delete(db.replays).where(r.post_id == row.post_id, r.robot_id == row.robot_id))
    return len(old) == AT_ONCE


def prune_keys(t: Transaction, keep: BoardRetentionConfig, now: datetime | None = None) -> bool:
    """Delete idempotency keys whose writes are older than `KEYS`; return whether there may be more."""
    before, more = _us(now, KEYS), False
    posts, images, events = db.posts.c, db.images.c, db.events.c
    u = db.used_keys.c
    for scope, table, old in (
        (u.scope.like("edit:%"), db.posts, posts.edited_us < before),
        (u.scope == "image", db.images, images.created_us < before),
        (u.scope.like("robot.%"), db.events, or_(events.id.is_(None), events.at_us < before)),
    ):
        refs = t.connection.execute(_refs(table, scope, old)).scalars().all()
        if refs:
            t.connection.execute(delete(db.used_keys).where(scope, u.ref.in_(refs)))
        more = more or len(refs) == AT_ONCE
    return more


def _refs(table: Table, scope: ColumnElement[bool], old: ColumnElement[bool]) -> Select[Any]:
    u = db.used_keys.c
    joined = select(u.ref).outerjoin(table, table.c.id == u.ref)
    return joined.where(scope, old).distinct().limit(AT_ONCE)


def _us(now: datetime | None, ago: timedelta) -> int:
    return int(((now or datetime.now(UTC)) - ago).timestamp() * 1_000_000)
