"""Processor time of the parts of a system, each of which is some processes with their descendants."""

from __future__ import annotations

import contextlib
import os
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

#: How often it is read: of a process that is killed, what it used after the last reading is lost.
READ_S = 0.5
_TICKS = os.sysconf("SC_CLK_TCK")


class ProcessorTime:
    """Adds up user and system time by part until closed. `parts` returns the ids of each part's first processes now."""

    def __init__(self, parts: Callable[[], Mapping[str, Sequence[int]]]) -> None:
        self._parts = parts
        #: What each process used, by part, id and start: ids are used again.
        self._used: dict[tuple[str, int, str], float] = {}
        self._lock, self._closed = threading.Lock(), threading.Event()
        self._reader = threading.Thread(target=self._read_often, daemon=True)
        self._reader.start()

    def __enter__(self) -> ProcessorTime:
        return self

    def __exit__(self, *_: object) -> None:
        self._closed.set()
        self._reader.join()

    def seconds(self) -> Counter[str]:
        """Processor seconds of each part until now."""
        with self._lock:
            self._read()
            total = Counter[str]()
            for (part, _, _), used_s in self._used.items():
                total[part] += used_s
            return total

    def _read_often(self) -> None:
        while not self._closed.wait(READ_S):
            with self._lock:
                self._read()

    def _read(self) -> None:
        for part, firsts in self._parts().items():
            for pid in (pid for first in firsts for pid in _with_descendants(first)):
                with contextlib.suppress(OSError):
                    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
                    self._used[part, pid, fields[19]] = (int(fields[11]) + int(fields[12])) / _TICKS


def _with_descendants(pid: int) -> Iterator[int]:
    yield pid
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                yield from _with_descendants(int(child))
