"""Journals as version 0.1 wrote them: a SQLite file for each robot, without a robot in its rows."""

from __future__ import annotations

import sqlite3
import time
from contextlib import closing
from pathlib import Path

from agentrob.agent.store import rows
from agentrob.model import Command

#: The columns of a claim in the last such version, and in the first.
CLAIM = (
    "number INTEGER PRIMARY KEY AUTOINCREMENT, post TEXT NOT NULL UNIQUE, topic TEXT NOT NULL, command TEXT NOT NULL, "
    "boot TEXT NOT NULL, accepted_s REAL NOT NULL, status_post TEXT, final TEXT, plan TEXT, at REAL NOT NULL, "
    "ended TEXT"
)
OLDEST_CLAIM = CLAIM.removesuffix(", ended TEXT")
TABLES = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE claim ({columns});
CREATE INDEX claim_topic ON claim (topic);
CREATE TABLE motion (post TEXT PRIMARY KEY, state TEXT NOT NULL, result TEXT, at REAL NOT NULL);
CREATE TABLE approval (
    post TEXT PRIMARY KEY, asked_at TEXT NOT NULL, until_at TEXT NOT NULL, said TEXT, said_by TEXT);
CREATE TABLE assessment (post TEXT PRIMARY KEY, result TEXT NOT NULL);
CREATE TABLE dbos_migrations (version INTEGER NOT NULL PRIMARY KEY);
CREATE TABLE workflow_status (workflow_uuid TEXT PRIMARY KEY);
"""


def write_old_journal(
    folder: Path,
    robot: str,
    *claims: Command,
    begun: tuple[str, ...] = (),
    columns: str = CLAIM,
    **values: str,
) -> Path:
    """Write the file of a robot with these claims, some of whose motions have begun, and these values in `meta`."""
    path = folder / "agents" / robot / "journal.sqlite"
    path.parent.mkdir(parents=True)
    with closing(sqlite3.connect(path)) as db, db:
        db.execute("PRAGMA journal_mode=wal")
        db.executescript(TABLES.format(columns=columns))
        for command in claims:
            kept = rows.COMMAND.dump_json(command).decode()
            row = (command.post_id, command.topic_id, kept, rows.boot(), rows.boot_s(), time.time())
            db.execute("INSERT INTO claim (post, topic, command, boot, accepted_s, at) VALUES (?, ?, ?, ?, ?, ?)", row)
        for post in begun:
            db.execute("INSERT INTO motion (post, state, at) VALUES (?, 'begun', ?)", (post, time.time()))
        db.executemany("INSERT INTO meta VALUES (?, ?)", ({"cursor": "27-660e8ab3806e2"} | values).items())
    return path
