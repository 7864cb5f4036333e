"""The audit log: who changed what. A row is added in the same transaction as its change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, insert, select

from agentrob.board.db import schema as db
from agentrob.board.db.cursors import from_cursor, to_cursor
from agentrob.board.db.reader import Reader
from agentrob.board.db.records import from_us, now_us

#: The actor of changes made at the command line.
SHELL = "shell"


@dataclass(frozen=True, slots=True)
class Entry:
    """One change; `target` is such as `account:ann`, `post:12`, `board:talk`."""

    id: str
    at: datetime
    actor: str
    action: str
    target: str
    detail: dict[str, Any]


def note(connection: Connection, actor: str, action: str, target: str, **detail: Any) -> None:
    """Add a row; empty details are left out. Never pass a password, a token or a link."""
    given = {k: v for k, v in detail.items() if v not in (None, "", (), [])}
    row = {"at_us": now_us(), "actor": actor, "action": action, "target": target[:80], "detail": given}
    connection.execute(insert(db.audit).values(**row))


def page(
    reader: Reader, cursor: str | None, limit: int, target: str | None = None
) -> tuple[Sequence[Entry], str | None]:
    """A page of the log, newest first, and the cursor of the next page; of one target or of all."""
    before = from_cursor(cursor) if cursor else None
    rows = reader.rows(statement(before, limit + 1, target or None))
    more = to_cursor(rows[limit - 1].id) if len(rows) > limit else None
    return [entry(r) for r in rows[:limit]], more


def statement(before: int | None, limit: int, target: str | None = None) -> Any:
    """The statement that selects rows, newest first."""
    a = db.audit.c
    chosen = select(db.audit).order_by(a.id.desc()).limit(limit)
    if before is not None:
        chosen = chosen.where(a.id < before)
    return chosen if target is None else chosen.where(a.target == target)


def entry(row: Any) -> Entry:
    """The record of a row."""
    return Entry(str(row.id), from_us(row.at_us), row.actor, row.action, row.target, row.detail)
