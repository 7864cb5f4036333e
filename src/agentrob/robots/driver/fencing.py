"""The largest fencing number that a driver has seen of each journal database, kept in a file: a worker that lost the
robot to another one stays locked out, also after a restart of the driver. Fails closed."""

from __future__ import annotations

import json
import threading
from pathlib import Path

from agentrob.errors import Fenced, RobotError
from agentrob.model import FencingToken
from agentrob.robots.safety.durable_file import write_json

#: Databases whose numbers are kept. None is ever dropped, since its earlier workers could then move the robot again.
STORES = 32


class FencingNumbers:
    """Thread-safe. The numbers are in memory at once and on disk after `save`; without a path only in memory.

    A file that cannot be read refuses every fencing number until it is removed, because the numbers in it are unknown.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.path = path
        self._facts = threading.Lock()  # held for assignments only, so that a stop never waits for the disk
        self._disk = threading.Lock()
        self._unreadable = ""
        self._numbers = self._saved = self._read()

    @property
    def known(self) -> bool:
        """Whether a worker with a fencing number has ever taken this robot."""
        return bool(self._numbers or self._unreadable)

    def check(self, fence: FencingToken) -> None:
        """Raise `Fenced` if a larger number of the same database was seen, or if the numbers are unknown."""
        if self._unreadable:
            raise Fenced(
                f"{self.path} cannot be read ({self._unreadable}), so it is unknown which worker holds the robot; "
                "end every worker but one, remove the file, and restart the driver"
            )
        if (newest := self._numbers.get(fence.store, fence.number)) > fence.number:
            raise Fenced(
                f"another worker has taken this robot since (its number is {newest}, yours is {fence.number}); "
                "take the robot again from the journal's database before you move it"
            )

    def see(self, fence: FencingToken) -> bool:
        """Remember a number in memory; return whether it is the largest so far. Raises `Fenced` if it is smaller than
        one seen before."""
        with self._facts:
            self.check(fence)
            if self._numbers.get(fence.store) == fence.number:
                return False
            if fence.store not in self._numbers and len(self._numbers) >= STORES:
                raise Fenced(
                    f"this driver has seen workers of {STORES} databases and keeps no more; "
                    f"end every worker but one, remove {self.path or 'its file'}, and restart the driver"
                )
            self._numbers = {**self._numbers, fence.store: fence.number}
            return True

    def save(self) -> None:
        """Write the numbers to disk, unless they are there. Raises `RobotError`; the numbers then hold in memory."""
        if self.path is None or self._saved is self._numbers:
            return
        with self._disk:
            if self._saved is (numbers := self._numbers):
                return
            try:
                write_json(self.path, numbers)
            except OSError as e:
                raise RobotError(
                    f"the fencing number cannot be written to {self.path} ({e.strerror}), so a restarted driver would "
                    "forget it; make room on the disk and try again"
                ) from None
            self._saved = numbers

    def _read(self) -> dict[str, int]:
        if self.path is None:
            return {}
        try:
            record = json.loads(self.path.read_text(encoding="utf-8"))
            if not isinstance(record, dict) or not all(type(number) is int for number in record.values()):
                raise ValueError("not an object of whole numbers")
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as e:
            self._unreadable = e.strerror or str(e) if isinstance(e, OSError) else type(e).__name__
            return {}
        return record
