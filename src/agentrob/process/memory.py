"""Returns free memory to the system, which the C library otherwise keeps for its own later use."""

from __future__ import annotations

import ctypes


def release_free_memory() -> None:
    """Return the free memory of this process to the system; does nothing where the C library is not glibc.

    A process with many threads keeps tens of megabytes in scattered free blocks. Takes some milliseconds, in which
    other threads may have to wait for memory, but not for Python's lock.
    """
    if (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)) is not None:
        trim(0)
