"""Yesterday's copy of a SQLite database, taken while its process runs and put back while that is down."""

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

    def put_back(self) -> None:
        delete(self.database)
        shutil.copy(self.copy, self.database)


def delete(database: Path) -> None:
    """With what has not been written into it yet."""
    assert database.exists()
    for left in ("", "-wal", "-shm"):
        Path(f"{database}{left}").unlink(missing_ok=True)
