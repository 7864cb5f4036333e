"""DDS domains of simulated worlds: each world has its own domain on this host."""

from __future__ import annotations

import contextlib

from agentrob.errors import RobotBusy
from agentrob.process import host_lock

#: Domains for worlds without a configured one; real robots use 0.
DOMAINS = range(40, 100)


class PrivateDomain:
    """A free DDS domain on this host, reserved until closed. Raises `RobotBusy` if all are in use."""

    def __init__(self) -> None:
        taken = {host_lock.without_namespace(name) for name in host_lock.held_anywhere()}
        for number in DOMAINS:
            if not {f"world/lo/{number}", f"driver/lo/{number}"} & taken:
                with contextlib.suppress(RobotBusy):
                    self._lock = host_lock.HostLock(f"domain/lo/{number}", f"DDS domain {number}")
                    self.number = number
                    return
        raise RobotBusy(f"all DDS domains from {DOMAINS.start} to {DOMAINS.stop - 1} are in use on this host")

    def close(self) -> None:
        self._lock.close()
