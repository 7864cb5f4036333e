"""Numbers that one test process has at a time on this host, for DDS domains."""

from __future__ import annotations

from functools import cache

from agentrob.errors import RobotBusy
from agentrob.process.host_lock import HostLock

_held: list[HostLock] = []


def take(what: str, among: range) -> int:
    """The first free number; this process holds it until it ends."""
    for number in among:
        try:
            _held.append(HostLock(f"test-{what}/{number}", what))
        except RobotBusy:
            continue
        return number
    raise RuntimeError(f"every {what} of {among} is taken by other test processes")


@cache
def dds_number() -> int:
    """For the files that speak real DDS: each has ten domains of its own, and its process takes the one of this number.

    There are only ten, so a process takes one when it collects such a file.
    """
    return take("number", range(10))
