"""A file that exists while a step runs, so that a restarted driver knows that its predecessor died during one.

The robot moves on for about a second after the last command of a killed driver. To the next driver that motion looks
like a takeover, which causes a halt (law 12); the marker says that the motion is our own. It is not synced to disk: a
killed process loses nothing, and after a crash of the whole host the marker must not count.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import time
from pathlib import Path
from typing import NamedTuple

from agentrob.model.operations.declaration import check_name

log = logging.getLogger(__name__)

#: The marker is refreshed this often while the step runs …
BEAT_S = 0.5
#: … and an older one is ignored: no command is held and no gesture lasts longer.
COUNTS_S = 10.0
_LENGTH = 400  # one line of always the same length: a single write, so no killed process leaves half of it


class InterruptedStep(NamedTuple):
    """The step that the previous driver died in, and the robot's last known mode."""

    op: str
    mode: str


class CrashMarker:
    """`begin`, `refresh` and `end` are called by the thread of the step; none of them ever raises.

    Without a path, or if the disk cannot be written, there is no marker: motion after a restart then counts as a
    takeover.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._file: int | None = None
        self._op, self._beat_s = "", 0.0

    def begin(self, op: str, mode: str) -> None:
        """Call before the first command of a step."""
        if self.path is None:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
        except OSError as e:
            log.warning("cannot write the crash marker %s (%s)", self.path, e.strerror)
            return
        self._op = str(op)
        self._write(mode)

    def refresh(self, mode: str) -> None:
        """Call while the step runs, as often as you like."""
        if self._file is not None and time.monotonic() >= self._beat_s + BEAT_S:
            self._write(mode)

    def end(self) -> None:
        """Call after the step, when the robot is at rest or has been stopped."""
        if self._file is not None:
            with contextlib.suppress(OSError):
                os.close(self._file)
            self._file = None
        self.clear()

    def clear(self) -> None:
        """Remove the marker: no motion of ours is left."""
        try:
            if self.path is not None:
                self.path.unlink(missing_ok=True)
        except OSError as e:  # it soon counts no more
            log.warning("cannot remove the crash marker %s (%s)", self.path, e.strerror)

    def interrupted_step(self) -> InterruptedStep | None:
        """Return the step that a previous driver died in a moment ago, or None."""
        if self.path is None:
            return None
        try:
            record = json.loads(self.path.read_text(encoding="utf-8"))
            age_s = time.monotonic() - float(record["alive_s"])
            counts = record["boot"] == boot_id() and 0 <= age_s <= COUNTS_S
            check_name(record["op"], "operation")
            return InterruptedStep(record["op"], str(record["mode"])) if counts else None
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as e:
            log.warning("cannot read the crash marker %s (%s)", self.path, type(e).__name__)
            return None

    def _write(self, mode: str) -> None:
        assert self._file is not None
        self._beat_s = time.monotonic()
        record = {"op": self._op, "mode": mode[:30], "alive_s": self._beat_s, "boot": boot_id()}
        with contextlib.suppress(OSError):
            os.pwrite(self._file, json.dumps(record).ljust(_LENGTH).encode(), 0)


def boot_id() -> str:
    """Id of this boot of the host, from which its monotonic clock counts."""
    return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
