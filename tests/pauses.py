"""Run a test with a simulated world again if it failed while the machine or its world was paused.

A robot whose state is older than half a second stops, as it must, and then its test fails. A virtual machine pauses for
longer than that when others take its processors, and a single process pauses while it waits for memory.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Protocol, runtime_checkable

import pytest

#: Shorter than the guard's limit of 0.5 s for the age of a state, because a world and a driver may wait in turn.
PAUSE_S = 0.25
LOOK_S = 0.02


class MachinePausedError(Exception):
    """A test failed while the machine, or the world of the test, was paused."""


@runtime_checkable
class PausableWorld(Protocol):
    """A fixture with a world that measures how long that was paused."""

    def longest_pause_s(self, since_s: float) -> float:
        """Return the longest pause since a time of the monotonic clock, in seconds."""
        ...


class PauseMonitor:
    """Measures the longest time for which a thread on any processor could not run."""

    def __init__(self) -> None:
        self._closed = threading.Event()
        self.longest_s = 0.0
        self._threads = [
            threading.Thread(target=self._watch, args=(processor,), daemon=True)
            for processor in sorted(os.sched_getaffinity(0))
        ]
        for thread in self._threads:
            thread.start()

    def _watch(self, processor: int) -> None:
        os.sched_setaffinity(threading.get_native_id(), {processor})
        looked_s = time.monotonic()
        while not self._closed.wait(LOOK_S):
            now_s = time.monotonic()
            self.longest_s = max(self.longest_s, now_s - looked_s - LOOK_S)
            looked_s = now_s

    def close(self) -> None:
        self._closed.set()
        for thread in self._threads:
            thread.join()


def processor_times_s() -> dict[str, float]:
    """Seconds that the processors have spent so far on each kind of work; `nice` is that of tests (proc_stat(5))."""
    kinds = ("user", "nice", "system", "idle", "iowait", "irq", "softirq", "steal")
    ticks = Path("/proc/stat").read_text(encoding="ascii").split()[1 : 1 + len(kinds)]
    return {kind: int(n) / os.sysconf("SC_CLK_TCK") for kind, n in zip(kinds, ticks, strict=True)}


@contextmanager
def pauses_explain_failures(item: pytest.Item, phase: str) -> Iterator[None]:
    """Raise `MachinePausedError` instead of another exception if the machine or a world was paused meanwhile.

    The report of every other failure says what the machine did.
    """
    monitor, began_s, before_s = PauseMonitor(), time.monotonic(), processor_times_s()
    try:
        yield
    except Exception as failure:
        worlds = (one for one in getattr(item, "funcargs", {}).values() if isinstance(one, PausableWorld))
        world_s = max((world.longest_pause_s(began_s) for world in worlds), default=0.0)
        used = ", ".join(f"{kind} {now_s - before_s[kind]:.1f} s" for kind, now_s in processor_times_s().items())
        found = (
            f"longest pause of the machine {monitor.longest_s:.2f} s, of the world {world_s:.2f} s; processors: {used}"
        )
        if max(monitor.longest_s, world_s) < PAUSE_S:
            item.add_report_section(phase, "machine", found)
            raise
        item.warn(pytest.PytestWarning(f"{item.nodeid} failed while it was paused: {found}"))
        raise MachinePausedError(found) from failure
    finally:
        monitor.close()


def pytest_itemcollected(item: pytest.Item) -> None:
    if item.get_closest_marker("sim"):
        item.add_marker(pytest.mark.flaky(reruns=2, only_rerun=[MachinePausedError.__name__]))


def _explained(item: pytest.Item, phase: str) -> Iterator[None]:
    with pauses_explain_failures(item, phase) if item.get_closest_marker("sim") else nullcontext():
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    return (yield from _explained(item, "setup"))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    return (yield from _explained(item, "call"))
