"""Keeps the zones of one room, for all drivers that share a data folder: `rooms/<room>.sqlite`.

There is no process that could fail: each call is one transaction of the caller. A lease is on disk before its robot
moves, so a driver that is killed, or a host that is switched off, leaves it behind as taken.
"""

from __future__ import annotations

import contextlib
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

from pydantic import TypeAdapter, ValidationError

from agentrob.errors import RobotError, RobotUnreachable
from agentrob.robots.zones.area import Area
from agentrob.robots.zones.ledger import Answer, Ledger, Message, Other, Place, ZoneLease

#: Wait at most this long for the transaction of another driver.
BUSY_S = 1.0
_LEDGER = TypeAdapter(Ledger)
_MAKE = (
    "create table if not exists room (id integer primary key check (id = 1), boot text not null, ledger text not null)"
)


class ZoneKeeper(Protocol):
    """Keeps the zones of a room: here, or at the driver of another host. See `Ledger` for the calls.

    Every call raises `RobotUnreachable` if the room cannot be read or written; nothing is then known of its outcome.
    """

    def hello(self, robot: str) -> int: ...

    def take(self, message: Message, place: Place, area: Area, doing: str) -> Answer: ...

    def report(self, message: Message, lease: int, place: Place, *, at_rest: bool) -> list[Other]: ...

    def release(self, robot: str) -> ZoneLease | None: ...

    def members(self) -> tuple[list[Other], list[str]]:
        """All robots of the room, and those that wait, in order."""
        ...


class LocalKeeper:
    """See `ZoneKeeper`. Thread-safe. `boot` returns the id of this boot of the host, from which `clock` counts."""

    def __init__(self, path: Path, boot: Callable[[], str], clock: Callable[[], float] = time.monotonic) -> None:
        self.path, self._clock, self._boot = path, clock, boot
        self._lock = threading.Lock()
        self._db: sqlite3.Connection | None = None
        self._file = (0, 0)

    def hello(self, robot: str) -> int:
        with self._ledger(durable=True) as ledger:
            return ledger.hello(robot, self._clock())

    def take(self, message: Message, place: Place, area: Area, doing: str) -> Answer:
        with self._ledger(durable=True) as ledger:
            return ledger.take(message, place, area, doing, self._clock())

    def report(self, message: Message, lease: int, place: Place, *, at_rest: bool) -> list[Other]:
        with self._ledger() as ledger:  # a report that a power failure undoes leaves more taken, not less
            return ledger.report(message, lease, place, at_rest=at_rest, now_s=self._clock())

    def release(self, robot: str) -> ZoneLease | None:
        with self._ledger(durable=True) as ledger:
            return ledger.release(robot, self._clock())

    def members(self) -> tuple[list[Other], list[str]]:
        with self._ledger() as ledger:
            now_s = self._clock()
            return ledger.others("", now_s), ledger.waiting(now_s)

    def close(self) -> None:
        with self._lock:
            self._disconnect()

    @contextlib.contextmanager
    def _ledger(self, *, durable: bool = False) -> Iterator[Ledger]:
        """The ledger within a transaction, which ends with the block; `durable` waits for the disk. What the ledger
        noted before it raised (`OldSession`, `LeaseGone`) counts."""
        if not self._lock.acquire(timeout=BUSY_S):
            raise RobotUnreachable(f"the room's file {self.path} is in use by another request")
        try:
            db = self._connected()
            db.execute(f"pragma synchronous = {'full' if durable else 'normal'}")
            db.execute("begin immediate")
            found = db.execute("select boot, ledger from room").fetchone()
            ledger, boot = Ledger() if found is None else _LEDGER.validate_json(found[1]), self._boot()
            if found is not None and found[0] != boot:
                ledger.rebooted()
            try:
                yield ledger
            finally:
                db.execute("insert or replace into room values (1, ?, ?)", (boot, _LEDGER.dump_json(ledger).decode()))
                db.execute("commit")
        except (sqlite3.Error, OSError) as e:
            self._disconnect()
            raise RobotUnreachable(f"the room's file {self.path} cannot be used ({e})") from None
        except ValidationError:
            self._disconnect()
            raise RobotUnreachable(
                f"the room's file {self.path} cannot be read, so it is unknown who moves in the room; see that every "
                "robot of the room is at rest, end their drivers, and remove the file"
            ) from None
        finally:
            self._lock.release()

    def _connected(self) -> sqlite3.Connection:
        """The connection, opened anew if the file was removed or replaced since."""
        if self._db is not None and self._file != _identity(self.path):
            self._disconnect()
        if self._db is None:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._db = sqlite3.connect(self.path, timeout=BUSY_S, isolation_level=None, check_same_thread=False)
            self._db.execute("pragma journal_mode = wal")
            self._db.execute(_MAKE)
            self._file = _identity(self.path)
        return self._db

    def _disconnect(self) -> None:
        if self._db is not None:
            with contextlib.suppress(sqlite3.Error):
                self._db.close()
        self._db = None


def _identity(path: Path) -> tuple[int, int]:
    found = path.stat()
    return found.st_dev, found.st_ino


def room_file(data: Path, room: str) -> Path:
    """Where a room is kept in a data folder."""
    if not room or not room.isprintable() or "/" in room or room.startswith("."):
        raise RobotError(f"{room!r} is not a room's name")
    return data / "rooms" / f"{room}.sqlite"
