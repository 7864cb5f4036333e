"""Two network namespaces joined by a link that delays each IP packet and loses some, as `tc netem` does, which not
every kernel has. Needs root and /dev/net/tun.

Each namespace has a TUN device; a process copies packets between the two. What runs in the namespaces has the kernel's
own TCP, with its retransmissions and timeouts.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import heapq
import multiprocessing
import os
import random
import select
import struct
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path

_TUNSETIFF, _IFF_TUN, _IFF_NO_PI, _CLONE_NEWNET = 0x400454CA, 0x0001, 0x1000, 0x40000000
#: The names of the namespaces and their addresses.
SIDES = {"agent": "10.213.7.1", "robot": "10.213.7.2"}


@dataclass
class Link:
    """A link that is up; `inside` prefixes a command so that it runs on one side."""

    name: str
    _cut: Synchronized[int]

    def inside(self, side: str) -> list[str]:
        return ["ip", "netns", "exec", f"{self.name}-{side}"]

    def cut(self, yes: bool = True) -> None:
        """Lose every packet, or no longer."""
        self._cut.value = int(yes)


def usable() -> bool:
    return os.geteuid() == 0 and Path("/dev/net/tun").exists()


@contextlib.contextmanager
def lossy_link(delay_s: float, loss: float, seed: int = 0) -> Iterator[Link]:
    """Two namespaces joined by a link with `delay_s` each way and a share `loss` of lost packets."""
    name, cut = f"agentrob-{os.getpid()}", multiprocessing.get_context("fork").Value("i", 0)
    devices = {}
    try:
        for side, address in SIDES.items():
            _run("ip", "netns", "add", f"{name}-{side}")
            devices[side] = _open_tun(f"{name}-{side}")
            for command in (
                ["addr", "add", f"{address}/24", "dev", "tun0"],
                ["link", "set", "tun0", "up"],
                ["link", "set", "lo", "up"],
            ):
                _run("ip", "-n", f"{name}-{side}", *command)
        copying = multiprocessing.get_context("fork").Process(
            target=_copy, args=(list(devices.values()), delay_s, loss, seed, cut), daemon=True
        )
        copying.start()
        try:
            yield Link(name, cut)
        finally:
            copying.terminate()
            copying.join()
    finally:
        for device in devices.values():
            os.close(device)
        for side in SIDES:
            subprocess.run(["ip", "netns", "del", f"{name}-{side}"], check=False, capture_output=True)


def _run(*command: str) -> None:
    subprocess.run(command, check=True, capture_output=True)


def _open_tun(namespace: str) -> int:
    """A TUN device in a namespace."""
    libc = ctypes.CDLL(None, use_errno=True)
    with Path("/proc/self/ns/net").open() as home, Path(f"/run/netns/{namespace}").open() as there:
        if libc.setns(there.fileno(), _CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), "cannot enter the namespace")
        try:
            device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
            fcntl.ioctl(device, _TUNSETIFF, struct.pack("16sH", b"tun0", _IFF_TUN | _IFF_NO_PI))
        finally:
            libc.setns(home.fileno(), _CLONE_NEWNET)
    return device


def _copy(devices: list[int], delay_s: float, loss: float, seed: int, cut: Synchronized[int]) -> None:
    """Copy packets between two devices until the process ends."""
    with contextlib.suppress(PermissionError):
        os.nice(-10)
    rng, under_way, number = random.Random(seed), list[tuple[float, int, int, bytes]](), 0
    while True:
        wait_s = max(0.0, under_way[0][0] - time.monotonic()) if under_way else None
        for device in select.select(devices, [], [], wait_s)[0]:
            packet, other = os.read(device, 65536), devices[1 - devices.index(device)]
            if not cut.value and rng.random() >= loss:
                number += 1
                heapq.heappush(under_way, (time.monotonic() + delay_s, number, other, packet))
        while under_way and under_way[0][0] <= time.monotonic():
            _, _, device, packet = heapq.heappop(under_way)
            if not cut.value:
                with contextlib.suppress(OSError):
                    os.write(device, packet)
