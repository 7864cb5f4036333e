"""Freed memory is returned to the operating system."""

from __future__ import annotations

import resource
from pathlib import Path

from agentrob.process.memory import release_free_memory

MB = 2**20


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def test_freed_memory_between_used_blocks_is_returned() -> None:
    blocks = [bytearray(16 * 1024) for _ in range(4096)]
    used = resident_bytes()
    kept = blocks[::256]  # without them the heap would simply shrink at its end
    del blocks
    release_free_memory()
    assert len(kept) == 16
    assert used - resident_bytes() > 32 * MB
