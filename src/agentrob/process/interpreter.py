"""Settings of the Python interpreter that shorten waits: garbage collection, free memory, turns of threads."""

from __future__ import annotations

import ctypes
import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

#: For how long a thread that computes may keep Python's lock while another wants it; Python's default is 5 ms.
SWITCH_S = 0.001


@contextmanager
def importing() -> Iterator[None]:
    """Import within this: imports create next to no garbage, and looking for it takes a fifth of their time."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.freeze()
            gc.enable()


def freeze_objects() -> None:
    """Exclude all present objects from garbage collection: in a robot's agent a full collection took 0.1 to 0.2 s,
    during which it could not receive a stop."""
    gc.collect()
    gc.freeze()


def prefer_event_loop() -> None:
    """Let the event loop run sooner beside threads that compute.

    After each wait for the network the loop needs Python's lock, and a stop passes several such waits on its way to
    the robot.
    """
    sys.setswitchinterval(SWITCH_S)


def release_free_memory() -> None:
    """Return the free memory of this process to the system; does nothing where the C library is not glibc.

    A process with many threads keeps tens of megabytes in scattered free blocks. Takes some milliseconds, in which
    other threads may have to wait for memory, but not for Python's lock.
    """
    if (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)) is not None:
        trim(0)
