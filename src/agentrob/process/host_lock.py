"""A lock that one process on this host holds: a name in Linux's abstract socket space.

The kernel gives the name back when the process ends, however it ends, so nothing is left on disk; and the name is the
same for every user of the host. Whoever connects to it reaches the holder: that is how `agentrob stop --all` finds
every driver without a file, a forum or an agent.
"""

from __future__ import annotations

import contextlib
import socket
from pathlib import Path

from agentrob.errors import RobotBusy

PREFIX = "agentrob/"


class HostLock:
    """Hold `agentrob/<name>` until closed. Raises `RobotBusy` when another process on this host holds it."""

    def __init__(self, name: str, what: str) -> None:
        self.name = name
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self.socket.bind("\0" + PREFIX + name)
        except OSError:
            self.socket.close()
            raise RobotBusy(f"{what} is already held by another process on this host ({PREFIX}{name})") from None
        self.socket.listen(16)

    def close(self) -> None:
        """Give the name back; a thread that waits for a caller gets an `OSError`, and the name is free once it has."""
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)  # or a thread that accepts would keep the name
        self.socket.close()

    def __enter__(self) -> HostLock:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def connect(name: str, timeout_s: float = 2.0) -> socket.socket:
    """A connection to the holder of `agentrob/<name>`; `ConnectionRefusedError` when nobody holds it."""
    s = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    s.settimeout(timeout_s)
    try:
        s.connect("\0" + PREFIX + name)
    except OSError:
        s.close()
        raise
    return s


def held(prefix: str = "") -> list[str]:
    """Names that start with `prefix` and are held on this host now, sorted, without the common `agentrob/`."""
    names: set[str] = set()
    for line in Path("/proc/net/unix").read_text(errors="replace").splitlines()[1:]:
        fields = line.split(maxsplit=7)
        if len(fields) == 8 and fields[7].startswith("@" + PREFIX + prefix):
            names.add(fields[7][1 + len(PREFIX) :])
    return sorted(names)
