"""The journal's own tables, a claim as it is read from them, and the clock that tells how old it is."""

from __future__ import annotations

import contextlib
import os
import sqlite3
import time
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from pydantic import TypeAdapter

from agentrob.model import Command

COMMAND = TypeAdapter(Command)
TABLES = """
CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS claim (
    number INTEGER PRIMARY KEY AUTOINCREMENT, post TEXT NOT NULL UNIQUE, topic TEXT NOT NULL, command TEXT NOT NULL,
    boot TEXT NOT NULL, accepted_s REAL NOT NULL, status_post TEXT, final TEXT, plan TEXT, at REAL NOT NULL,
    ended TEXT);
CREATE INDEX IF NOT EXISTS claim_topic ON claim (topic);
CREATE TABLE IF NOT EXISTS motion (post TEXT PRIMARY KEY, state TEXT NOT NULL, result TEXT, at REAL NOT NULL);
"""
#: What `read_claim` wants to be given of a row.
COLUMNS = "command, boot, accepted_s, status_post, final, ended"


def migrate(db: sqlite3.Connection) -> None:
    """Journals of earlier versions lack a column."""
    if "ended" not in [column[1] for column in db.execute("PRAGMA table_info(claim)")]:
        db.execute("ALTER TABLE claim ADD COLUMN ended TEXT")


@dataclass(frozen=True, slots=True)
class Claim:
    """A post that this journal took. `new` is False when it had been taken before, perhaps by an earlier process.

    `waited_s` is how long ago it was accepted by the machine's clock that nobody sets, infinite when the machine has
    been started anew since. `final` is the state that its reply told, None while it is open. `ended` is why it may
    never move (a stable word), None while it may.
    """

    command: Command
    new: bool
    waited_s: float
    status_post: str | None = None
    final: str | None = None
    ended: str | None = None

    def why_not(self, now_at: datetime, watermark_at: datetime, stopped_at: datetime, max_age_s: float) -> str | None:
        """Why an earlier process's claim may not begin to move; None when the restart fell within its time."""
        posted_at = self.command.posted_at
        if self.ended is not None:
            return self.ended
        if posted_at <= stopped_at:
            return "stop"
        fresh = posted_at > watermark_at and (now_at - posted_at).total_seconds() <= max_age_s
        return None if fresh else "stale"


def read_claim(row: tuple[str, str, float, str | None, str | None, str | None]) -> Claim:
    """A row of `COLUMNS`; its `waited_s` counts until now."""
    command, taken_in, accepted_s, status_post, final, ended = row
    waited_s = boot_s() - accepted_s if taken_in == boot() else float("inf")
    return Claim(COMMAND.validate_json(command), False, waited_s, status_post, final, ended)


def boot_s() -> float:
    """Seconds since this machine started, sleep included: a clock that nobody sets."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def boot() -> str:
    """Which start of the machine this is."""
    with contextlib.suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    return f"{os.uname().nodename}"
