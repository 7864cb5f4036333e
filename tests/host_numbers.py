"""Numbers that only one test process on this host holds at a time: DDS domains and TCP ports."""

from __future__ import annotations

import socket
from functools import cache

from agentrob.errors import RobotBusy
from agentrob.process.host_lock import HostLock

_held: list[HostLock] = []
#: Below the ports that the kernel gives to connections and to servers without a port of their own, one of which
#: could otherwise come between the choice of a port and its use.
PORTS = range(20_000, 32_000)


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


def free_port() -> int:
    """Return a TCP port of loopback where nothing listens. No other test gets it, nor does a later call."""
    while True:
        port = take("port", PORTS)
        with socket.socket() as s:
            s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                s.bind(("127.0.0.1", port))
            except OSError:
                continue
        return port
