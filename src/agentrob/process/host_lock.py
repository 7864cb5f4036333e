"""A lock that one process on this host holds: a name in Linux's abstract socket space.

The kernel frees the name when the process ends, for whatever reason, so nothing is left on disk; and the name is the
same for every user of the host. A connection to the name reaches the holder: so `agentrob stop --all` finds every
driver without a file, a forum or an agent.

`AGENTROB_LOCK_NAMESPACE` separates test processes: the locks of simulated robots' drivers then end in `@<namespace>`,
and `held` hides those of other namespaces. No other lock may have a namespace, so a real robot still has one driver
and `stop --all` still reaches it. Without the variable, `held` lists the locks of every namespace.
"""

from __future__ import annotations

import contextlib
import os
import re
import socket
from pathlib import Path

from agentrob.errors import ConfigError, RobotBusy

PREFIX = "agentrob/"
NAMESPACE = "AGENTROB_LOCK_NAMESPACE"
#: Names that may have a namespace: the drivers of fake robots, and of robots on loopback.
_MAY_HAVE_NAMESPACE = ("driver/fake/", "driver/lo/")


def namespaced(name: str) -> str:
    """The lock's name within the namespace of this process. Only for a simulated robot's driver.

    Raises `ConfigError` for a namespace that is not a word, `ValueError` for a lock that must be one per host.
    """
    if not name.startswith(_MAY_HAVE_NAMESPACE):
        raise ValueError(
            f"the lock {name!r} must be unique on this host; a namespace is for {' and '.join(_MAY_HAVE_NAMESPACE)}"
        )
    namespace = os.environ.get(NAMESPACE, "")
    if not re.fullmatch(r"[\w-]{0,40}", namespace, re.ASCII):
        raise ConfigError(f"{NAMESPACE} is {namespace!r}; valid: at most 40 letters, digits, '-' and '_'")
    return f"{name}@{namespace}" if namespace else name


def without_namespace(name: str) -> str:
    return name.partition("@")[0] if name.startswith(_MAY_HAVE_NAMESPACE) else name


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
        """Free the name. A thread blocked in `accept` gets an `OSError`; the name is free after that."""
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)  # otherwise a thread in `accept` would keep the name
        self.socket.close()

    def __enter__(self) -> HostLock:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def connect(name: str, timeout_s: float = 2.0) -> socket.socket:
    """A connection to the holder of `agentrob/<name>`; `ConnectionRefusedError` if the lock is free."""
    s = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    s.settimeout(timeout_s)
    try:
        s.connect("\0" + PREFIX + name)
    except OSError:
        s.close()
        raise
    return s


def held(prefix: str = "") -> list[str]:
    """Names that start with `prefix` and are held on this host now, sorted, without the common `agentrob/`.

    Names of other namespaces are left out if this process has a namespace.
    """
    namespace = os.environ.get(NAMESPACE, "")
    return [name for name in held_anywhere(prefix) if not namespace or _namespace_of(name) in ("", namespace)]


def held_anywhere(prefix: str = "") -> list[str]:
    """As `held`, in every namespace."""
    names: set[str] = set()
    for line in Path("/proc/net/unix").read_text(errors="replace").splitlines()[1:]:
        fields = line.split(maxsplit=7)
        if len(fields) == 8 and fields[7].startswith("@" + PREFIX + prefix):
            names.add(fields[7][1 + len(PREFIX) :])
    return sorted(names)


def _namespace_of(name: str) -> str:
    return name[len(without_namespace(name)) + 1 :]
