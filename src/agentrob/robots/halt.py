"""A robot's halt: a file that says no motion until the owner releases it; it outlives the process, and fails closed."""

from __future__ import annotations

import json
import os
import threading
from datetime import UTC, datetime
from pathlib import Path


class Halt:
    """`why` is the sentence while halted, else None. A file that cannot be read counts as a halt."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self.why: str | None = self._read()

    def set(self, by: str, why: str) -> str | None:
        """Halt in memory at once. The caller stops the robot, then calls `keep`."""
        self.why = f"Halted by {by}: {why}"
        return self.why

    def keep(self) -> bool:
        """Write the halt down. False when the disk refused: then it holds only as long as this process lives."""
        with self._lock:
            if self.why is None:
                return True
            record = {"why": self.why, "at": datetime.now(UTC).isoformat(timespec="seconds")}
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                fresh = self.path.with_suffix(".new")
                with fresh.open("w", encoding="utf-8") as f:
                    json.dump(record, f)
                    f.flush()
                    os.fsync(f.fileno())
                fresh.replace(self.path)
                self._sync_folder()
            except OSError:
                return False
            return True

    def release(self) -> None:
        """Take the halt away. Raises `OSError` when the file cannot be removed: then the halt stays."""
        with self._lock:
            self.path.unlink(missing_ok=True)
            if self.path.parent.exists():
                self._sync_folder()
            self.why = None

    def _sync_folder(self) -> None:
        folder = os.open(self.path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)

    def _read(self) -> str | None:
        try:
            record = json.loads(self.path.read_text(encoding="utf-8"))
            return str(record["why"])
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as e:
            return f"Halted: {self.path} cannot be read ({type(e).__name__}), so the robot stays halted until released."
