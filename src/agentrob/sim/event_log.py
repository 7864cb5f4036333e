"""Log the robots' actual motions and gestures as JSON lines."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TextIO

from agentrob.errors import SimError


class EventLog:
    """Appends to a file, flushed line by line; without a path it does nothing.

    A line: `{"at": wall clock, "time_s": world time, "robot", "event", "pose": {x_m, y_m, yaw_deg}, …}`. A write
    error (disk full) is reported once on stderr and in `last_error`, and the world continues.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.last_error = ""
        self._file: TextIO | None = None
        if path is not None:
            try:
                self._file = path.open("a", encoding="utf-8")
            except OSError as e:
                raise SimError(f"cannot write the event log {path}: {e.strerror}") from None

    def write(self, time_s: float, robot: str, event: str, pose: Mapping[str, float], facts: Mapping[str, Any]) -> None:
        if self._file is None:
            return
        at = datetime.now(UTC).isoformat(timespec="milliseconds")
        line = {"at": at, "time_s": round(time_s, 3), "robot": robot, "event": event, "pose": pose, **facts}
        try:
            self._file.write(json.dumps(line) + "\n")
            self._file.flush()
        except (OSError, ValueError) as e:
            if not self.last_error:
                sys.stderr.write(f"the event log is incomplete from here on: {e}\n")
            self.last_error = str(e)

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None
