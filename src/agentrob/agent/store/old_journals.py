"""Journals of earlier versions: one SQLite file for each robot, without a robot in its rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Table, inspect, text

from agentrob.agent.store import versions
from agentrob.agent.store.queries import NEWEST_NUMBER, insert_all
from agentrob.agent.store.schema import ALL, CLAIM, METADATA

#: Tables of the workflow engine that version 0.1 used. They never decided what may move, so they are dropped.
OLD_ENGINE = (
    "operation_outputs", "workflow_events", "workflow_events_history", "workflow_input", "workflow_output", "streams",
    "notifications", "workflow_status", "workflow_schedules", "queues", "application_versions", "dbos_migrations",
)  # fmt: skip
Rows = dict[Table, list[dict[str, Any]]]


def create_tables(db: Connection, robot: str) -> None:
    """Create the tables of a SQLite file. If they are of an earlier version, replace them and keep their rows. Raises
    `JournalError` for a newer version."""
    without_robot = versions.stored_version(db) == 1
    kept = read_rows(db) if without_robot else {}
    if without_robot:
        METADATA.drop_all(db)
        for table in OLD_ENGINE:
            db.execute(text(f"DROP TABLE IF EXISTS {table}"))
    METADATA.create_all(db)
    add_rows(db, robot, kept)
    versions.write_version(db)


def read_rows(db: Connection) -> Rows:
    """All rows of a robot in a SQLite journal of this version or an earlier one, as far as this version has their
    columns. Raises `JournalError` for a newer version."""
    versions.stored_version(db)
    there = inspect(db).get_table_names()
    found: Rows = {}
    for table in METADATA.sorted_tables:
        rows = db.execute(text(f"SELECT * FROM {table.name}")).mappings() if table.name in there else ()
        ours = (row for row in rows if row.get("robot") != ALL)
        found[table] = [{name: value for name, value in row.items() if name in table.c} for row in ours]
    return found


def add_rows(db: Connection, robot: str, rows: Rows) -> None:
    """Add rows of a file to a robot's. Rows that the robot has already stay as they are."""
    if claims := rows.get(CLAIM):
        newest = db.execute(NEWEST_NUMBER, {"this_robot": robot}).scalar_one()
        rows[CLAIM] = [claim | {"number": newest + claim["number"]} for claim in claims]
    for table, found in rows.items():
        insert_all(db, table, [row | {"robot": robot} for row in found])


def set_aside(path: Path) -> None:
    """Rename a file that was imported, its log first, which must not become another file's."""
    for end in ("-wal", "-shm", ""):
        if (file := path.with_name(path.name + end)).exists():
            file.rename(path.with_name(f"{path.name}.imported{end}"))
