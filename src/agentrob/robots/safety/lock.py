"""A robot's halt, kept in a file: no motion until the owner releases it, also after a restart. Fails closed."""

from __future__ import annotations

import json
import math
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

from agentrob.errors import RobotError
from agentrob.language.messages.durations import duration
from agentrob.model import Language, Lock
from agentrob.robots.safety.durable_file import sync_folder, write_json


class Halt:
    """`lock` says who locked the robot, why and when; None if it is not locked. An unreadable file counts as a lock.

    A release removes only the halt that existed when it was requested: a halt set at the same time stays.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._facts = threading.Lock()  # held for assignments only, so that a halt never waits for the disk
        self._disk = threading.Lock()
        self._lock: Lock | None = self._read()
        self._set_s = _monotonic(self._lock)

    @property
    def lock(self) -> Lock | None:
        return self._lock

    @property
    def why(self) -> str | None:
        """The sentence while locked, else None."""
        return None if (lock := self._lock) is None else sentence(lock)

    def set(self, by: str, why: str, asked_s: float | None = None) -> str:
        """Halt in memory at once. The caller stops the robot, then calls `save`.

        `asked_s` is when the halt was requested (monotonic seconds; default now): a later release removes it.
        """
        asked_s = time.monotonic() if asked_s is None else asked_s
        with self._facts:
            self._lock = Lock(by, why, datetime.now(UTC))
            self._set_s = max(self._set_s, asked_s)
            return sentence(self._lock)

    def save(self) -> bool:
        """Write the halt to disk. Return False if that failed: the halt then ends with this process."""
        with self._disk:
            if (lock := self._lock) is None:
                return True
            at = lock.at.isoformat(timespec="milliseconds") if lock.at else None
            record = {"why": lock.why, "by": lock.by, "at": at}
            try:
                write_json(self.path, record)
            except OSError:
                return False
            return True

    def release(self, since_s: float = math.inf) -> Lock | None:
        """Remove the lock; return it, or None if there was none.

        `since_s` is when the release was requested (monotonic seconds). Raises `RobotError` if the robot was locked
        after that, and `OSError` if the file cannot be removed; the lock then stays.
        """
        with self._disk:
            with self._facts:
                lock, set_s = self._lock, self._set_s
            if lock is not None and set_s > since_s:
                raise RobotError("the robot was locked after this release was requested, so it stays locked")
            self.path.unlink(missing_ok=True)
            if self.path.parent.exists():
                sync_folder(self.path.parent)
            with self._facts:
                if self._lock is not lock:
                    # That halt waits for `self._disk` to write itself down.
                    raise RobotError("the robot was locked again during the release, so it stays locked")
                self._lock = None
            return lock

    def _read(self) -> Lock | None:
        try:
            record = json.loads(self.path.read_text(encoding="utf-8"))
            why, by, at = str(record["why"]), record.get("by", ""), record.get("at")
            return Lock(str(by), why, None if at is None else datetime.fromisoformat(str(at)).astimezone(UTC))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as e:
            why = f"{self.path} cannot be read ({type(e).__name__}), so the robot stays locked until it is released"
            return Lock("", why)


def _monotonic(lock: Lock | None) -> float:
    """When a lock read from its file was set, in monotonic seconds; never in the future, even if the machine's clock
    was changed."""
    if lock is None or lock.at is None:
        return -math.inf
    return time.monotonic() - max(0.0, (datetime.now(UTC) - lock.at).total_seconds())


def sentence(lock: Lock) -> str:
    """Who locked the robot, how long ago and why, in English."""
    if not lock.by:  # of a file that cannot be read, or that an earlier version wrote as a whole sentence
        return lock.why if lock.why.startswith("Halted by ") else f"Halted: {lock.why}"
    held = held_for(lock)
    return f"Halted by {lock.by}{f' {held} ago' if held else ''}: {lock.why}"


def held_for(lock: Lock, language: Language = "en") -> str:
    """How long the robot has been locked, in words; empty if unknown."""
    return duration((datetime.now(UTC) - lock.at).total_seconds(), language) if lock.at else ""
