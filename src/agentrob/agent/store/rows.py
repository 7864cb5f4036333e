"""The journal's tables and connection, and the claims that are read from them."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sqlite3
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from agentrob.errors import JournalError
from agentrob.model import Account, Command, CommandState, EndReason
from agentrob.model.lifecycle import stored_reason, stored_state

T = TypeVar("T")


class MotionState(StrEnum):
    """The state of a motion row, which is written before anything moves: its first insert wins."""

    BEGUN = "begun"
    ENDED = "ended"  # and its result is kept
    CANCELLED = "cancelled"  # it never begins


TABLES = """
CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS claim (
    number INTEGER PRIMARY KEY AUTOINCREMENT, post TEXT NOT NULL UNIQUE, topic TEXT NOT NULL, command TEXT NOT NULL,
    boot TEXT NOT NULL, accepted_s REAL NOT NULL, status_post TEXT, final TEXT, plan TEXT, at REAL NOT NULL,
    ended TEXT);
CREATE INDEX IF NOT EXISTS claim_topic ON claim (topic);
CREATE TABLE IF NOT EXISTS motion (post TEXT PRIMARY KEY, state TEXT NOT NULL, result TEXT, at REAL NOT NULL);
CREATE TABLE IF NOT EXISTS approval (
    post TEXT PRIMARY KEY, asked_at TEXT NOT NULL, until_at TEXT NOT NULL, said TEXT, said_by TEXT);
CREATE TABLE IF NOT EXISTS assessment (post TEXT PRIMARY KEY, result TEXT NOT NULL);
"""
#: Tables of the workflow engine that version 0.1 used. They never decided what may move, so they are dropped.
OLD_ENGINE = (
    "operation_outputs", "workflow_events", "workflow_events_history", "workflow_input", "workflow_output", "streams",
    "notifications", "workflow_status", "workflow_schedules", "queues", "application_versions", "dbos_migrations",
)  # fmt: skip
#: Claims as `read_claim` wants to be given them.
CLAIMS = """
SELECT command, boot, accepted_s, status_post, final, ended, motion.state, asked_at, until_at, said
FROM claim LEFT JOIN approval ON approval.post = claim.post LEFT JOIN motion ON motion.post = claim.post
"""


class Rows:
    """A database whose connection belongs to one thread, so that rows are written in the order of the calls.

    `_in_rows` runs a call in that thread; the other methods that begin with `_` are for such calls.
    """

    def __init__(self, thread_name: str) -> None:
        self._db: sqlite3.Connection | None = None
        self._rows = ThreadPoolExecutor(1, thread_name_prefix=thread_name)

    async def _in_rows(self, call: Callable[..., T], *args: Any) -> T:
        try:
            return await asyncio.get_running_loop().run_in_executor(self._rows, partial(call, *args))
        except sqlite3.Error as e:
            raise JournalError(f"the journal cannot be used: {e}") from None

    @contextlib.contextmanager
    def _together(self) -> Iterator[None]:
        """Write everything inside in one transaction."""
        self._do("BEGIN IMMEDIATE")
        try:
            yield
            self._do("COMMIT")
        except BaseException:
            with contextlib.suppress(sqlite3.Error):  # the disk that failed the write may fail this too
                self._do("ROLLBACK")
            raise

    def _do(self, query: str, args: Sequence[Any] = ()) -> int:
        """Write; returns how many rows changed."""
        assert self._db is not None
        return self._db.execute(query, tuple(args)).rowcount

    def _one(self, query: str, args: Sequence[Any] = ()) -> Any:
        assert self._db is not None
        return self._db.execute(query, tuple(args)).fetchone()

    def _all(self, query: str, args: Sequence[Any] = ()) -> list[Any]:
        assert self._db is not None
        return self._db.execute(query, tuple(args)).fetchall()

    async def get(self, key: str) -> str | None:
        found = await self._in_rows(self._one, "SELECT value FROM meta WHERE key = ?", (key,))
        return str(found[0]) if found else None

    async def put(self, key: str, value: str) -> None:
        await self.put_all(**{key: value})

    async def put_all(self, **values: str) -> None:
        """Write all values in one transaction."""
        query = "INSERT INTO meta (key, value) VALUES (?, ?) ON CONFLICT (key) DO UPDATE SET value = excluded.value"

        def rows() -> None:
            with self._together():
                for item in values.items():
                    self._do(query, item)

        await self._in_rows(rows)

    async def get_time(self, key: str) -> datetime | None:
        found = await self.get(key)
        return datetime.fromisoformat(found) if found else None


def migrate(db: sqlite3.Connection, version: str) -> None:
    """Add the column that journals of earlier versions lack, drop the tables of their engine, and delete assessments of
    another version."""
    if "ended" not in [column[1] for column in db.execute("PRAGMA table_info(claim)")]:
        db.execute("ALTER TABLE claim ADD COLUMN ended TEXT")
    for table in OLD_ENGINE:
        db.execute(f"DROP TABLE IF EXISTS {table}")
    if db.execute("SELECT 1 FROM meta WHERE key = 'version' AND value = ?", (version,)).fetchone() is None:
        db.execute("DELETE FROM assessment")
        db.execute("INSERT OR REPLACE INTO meta (key, value) VALUES ('version', ?)", (version,))


def prune(db: sqlite3.Connection, before: float, commands: int, day: float) -> None:
    """Delete ended claims older than `before` (Unix seconds), or older than `day` and not among the newest `commands`.
    Open claims are kept.

    A post whose claim is deleted could be claimed again if the forum delivered it again. It still moves nothing (law
    6): it is at least a day old, and a post moves something only within minutes (law 5). Its claim on the forum stays.
    """
    old = "final NOT NULL AND (at < :before OR (at < :day AND number <= (SELECT max(number) FROM claim) - :commands))"
    values = {"before": before, "day": day, "commands": commands}
    for table in ("motion", "approval", "assessment"):
        db.execute(f"DELETE FROM {table} WHERE post IN (SELECT post FROM claim WHERE {old})", values)
    db.execute(f"DELETE FROM claim WHERE {old}", values)
    # Posts that were cancelled before anybody claimed them.
    db.execute("DELETE FROM motion WHERE at < ? AND post NOT IN (SELECT post FROM claim)", (before,))


ASK = "INSERT INTO approval (post, asked_at, until_at) VALUES (?, ?, ?) ON CONFLICT DO NOTHING"
#: The first word counts, but what was approved may be denied until it moves; what is over is no more decided.
DECIDE = """
UPDATE approval SET said = ?, said_by = ? WHERE post = ? AND (said IS NULL OR NOT ?)
AND NOT EXISTS (SELECT 1 FROM motion WHERE motion.post = approval.post)
"""
#: Each with a mark that no post's id begins with.
SET_ASIDE = (
    "UPDATE claim SET post = ? || post, topic = '', final = coalesce(final, 'cancelled')",
    "UPDATE motion SET post = ? || post",
    "UPDATE approval SET post = ? || post, said_by = NULL",
)


@dataclass(frozen=True, slots=True)
class ApprovalDecision:
    """An approval or a denial of a command, bound to its post as a command is bound to its own."""

    approved: bool
    by: Account
    post_id: str
    content_hash: str
    at: datetime


@dataclass(frozen=True, slots=True)
class ApprovalRequest:
    """A request for approval, made at `asked_at` by the forum's clock, and the decision, if there is one."""

    asked_at: datetime
    until_at: datetime
    decided: ApprovalDecision | None = None


COMMAND, DECIDED = TypeAdapter(Command), TypeAdapter(ApprovalDecision)


@dataclass(frozen=True, slots=True)
class Claim:
    """A post that this journal claimed. `new` is False if it was claimed before, perhaps by an earlier process.

    `waited_s` is how long ago it was accepted, by the machine's clock that cannot be set; infinite if the machine was
    restarted since. `final` is the state of its final reply, None while it is open. `ended` is why it may never move,
    None while it may. `asked` is its request for approval. `motion` is the state of its motion row.
    """

    command: Command
    new: bool
    waited_s: float
    status_post: str | None = None
    final: CommandState | None = None
    ended: EndReason | None = None
    asked: ApprovalRequest | None = None
    motion: MotionState | None = None

    @property
    def state(self) -> CommandState:
        """How far the command is, as far as the journal knows: it keeps no place in the queue."""
        if self.final is not None:
            return self.final
        if self.motion in (MotionState.BEGUN, MotionState.ENDED):
            return CommandState.RUNNING
        if self.asked is None:
            return CommandState.SEEN
        return CommandState.WAITING if self.asked.decided is None else CommandState.QUEUED

    def why_not(
        self, now_at: datetime, watermark_at: datetime, stopped_at: datetime, max_age_s: float
    ) -> EndReason | None:
        """Why a claim of an earlier process may not begin to move; None if it is still fresh."""
        posted_at = self.command.posted_at
        if self.ended is not None:
            return self.ended
        if posted_at <= stopped_at:
            return EndReason.STOP
        if posted_at <= watermark_at:
            return EndReason.STALE
        if self.asked is not None and self.asked.decided is None:
            return EndReason.LAPSED if now_at > self.asked.until_at else None
        # What was approved is as fresh as its approval is.
        since_at = self.asked.decided.at if self.asked is not None and self.asked.decided is not None else posted_at
        return None if now_at - since_at <= timedelta(seconds=max_age_s) else EndReason.STALE


def read_claim(row: tuple[Any, ...]) -> Claim:
    """A row of `CLAIMS`; its `waited_s` counts until now."""
    command, taken_in, accepted_s, status_post, final, ended, motion, *asked = row
    return Claim(
        COMMAND.validate_json(command),
        new=False,
        waited_s=boot_s() - accepted_s if taken_in == boot() else float("inf"),
        status_post=status_post,
        final=stored_state(final) if final is not None else None,
        ended=stored_reason(ended) if ended is not None else None,
        asked=read_asked(*asked),
        motion=MotionState(motion) if motion is not None else None,
    )


def read_asked(asked_at: str | None, until_at: str | None, decision: str | None) -> ApprovalRequest | None:
    if asked_at is None or until_at is None:
        return None
    decided = DECIDED.validate_json(decision) if decision else None
    return ApprovalRequest(datetime.fromisoformat(asked_at), datetime.fromisoformat(until_at), decided)


def boot_s() -> float:
    """Seconds since this machine started, sleep included: a clock that cannot be set."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def boot() -> str:
    """The id of this start of the machine."""
    with contextlib.suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    return f"{os.uname().nodename}"
