"""Numbers that only one test process on this host holds at a time, for DDS domains."""

from __future__ import annotations

from functools import cache

from agentrob.errors import RobotBusy
from agentrob.process.host_lock import HostLock

_held: list[HostLock] = []


def take(what: str, among: range) -> int:
    """Take the first free number; this process holds it until it ends."""
    for number in among:
        try:
            _held.append(HostLock(f"test-{what}/{number}", what))
        except RobotBusy:
            continue
        return number
    raise RuntimeError(f"every {what} of {among} is taken by other test processes")


@cache
def dds_number() -> int:
    """Return a number for test files that use real DDS: each file has ten domains, and its process takes one of them.

    There are only ten, so a process takes one when it collects such a file.
    """
    return take("number", range(10))
