"""Garbage collection, free memory and turns of threads."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

from agentrob.process.interpreter import release_free_memory

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


def test_objects_that_exist_at_readiness_are_excluded_from_garbage_collection() -> None:
    code = (
        "import gc, agentrob.process.child as c; c.print_ready(); print(gc.get_freeze_count(), len(gc.get_objects()))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    frozen, rest = map(int, said.splitlines()[1].split())
    assert frozen > 50 * rest


def test_a_busy_thread_does_not_keep_the_event_loop_waiting_for_long() -> None:
    code = "import sys, agentrob.process.interpreter as e; e.prefer_event_loop(); print(sys.getswitchinterval())"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert float(said) <= 0.001
