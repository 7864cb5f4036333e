"""Take a copy of a SQLite database while its process runs, and restore it while the process is down."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path


class Backup:
    def __init__(self, database: Path, copy: Path) -> None:
        self.database, self.copy = database, copy
        copy.unlink(missing_ok=True)
        with (
            closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as now,
            closing(sqlite3.connect(copy)) as kept,
        ):
            now.backup(kept)

    def restore(self) -> None:
        delete(self.database)
        shutil.copy(self.copy, self.database)


def delete(database: Path) -> None:
    """Copy the database including what is only in its write-ahead log."""
    assert database.exists()
    for left in ("", "-wal", "-shm"):
        Path(f"{database}{left}").unlink(missing_ok=True)
