"""A mark on disk while a step runs, so that a driver that is started again knows that its predecessor died in one.

The robot goes on for about a second after the last command of a driver that was killed. To the next driver that motion
looks like a foreign hand, which is a halt (law 12); the mark says that it is our own, for a moment. It is not synced to
the disk: a killed process loses nothing, and after a crash of the whole host it must not count.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import time
from pathlib import Path
from typing import NamedTuple

from agentrob.model import Op

log = logging.getLogger(__name__)

#: The mark is renewed this often while the step runs …
BEAT_S = 0.5
#: … and one that was not renewed for so long says nothing: no command is held and no gesture lasts longer.
COUNTS_S = 10.0
_LENGTH = 400  # one line of always the same length: a single write, so no killed process leaves half of it


class InterruptedStep(NamedTuple):
    """What a predecessor was doing when it died, and the mode that the robot was in when it was last seen."""

    op: Op
    mode: str


class CrashMarker:
    """`begin`, `refresh` and `end` are called by the thread of the step; none of them ever raises.

    Without a path, or on a disk that refuses, there is no mark: then the motion that is found counts as foreign.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._file: int | None = None
        self._op, self._beat_s = "", 0.0

    def begin(self, op: Op, mode: str) -> None:
        """Before the robot is commanded anything."""
        if self.path is None:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
        except OSError as e:
            log.warning("no mark of this step at %s (%s)", self.path, e.strerror)
            return
        self._op = str(op)
        self._write(mode)

    def refresh(self, mode: str) -> None:
        """While the step runs; call it as often as you like."""
        if self._file is not None and time.monotonic() >= self._beat_s + BEAT_S:
            self._write(mode)

    def end(self) -> None:
        """The step has ended and the robot rests, or was told to."""
        if self._file is not None:
            with contextlib.suppress(OSError):
                os.close(self._file)
            self._file = None
        self.clear()

    def clear(self) -> None:
        """Nothing of ours moves any more."""
        try:
            if self.path is not None:
                self.path.unlink(missing_ok=True)
        except OSError as e:  # it soon counts no more
            log.warning("the mark %s cannot be removed (%s)", self.path, e.strerror)

    def interrupted_step(self) -> InterruptedStep | None:
        """What a predecessor left that died within a step a moment ago, None when there is nothing that counts."""
        if self.path is None:
            return None
        try:
            record = json.loads(self.path.read_text(encoding="utf-8"))
            age_s = time.monotonic() - float(record["alive_s"])
            counts = record["boot"] == _boot() and 0 <= age_s <= COUNTS_S
            return InterruptedStep(Op(record["op"]), str(record["mode"])) if counts else None
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as e:
            log.warning("the mark %s says nothing (%s)", self.path, type(e).__name__)
            return None

    def _write(self, mode: str) -> None:
        assert self._file is not None
        self._beat_s = time.monotonic()
        record = {"op": self._op, "mode": mode[:30], "alive_s": self._beat_s, "boot": _boot()}
        with contextlib.suppress(OSError):
            os.pwrite(self._file, json.dumps(record).ljust(_LENGTH).encode(), 0)


def _boot() -> str:
    """This start of the host: its monotonic clock counts from there."""
    return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
