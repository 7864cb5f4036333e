"""Run a test with a simulated world again if it failed while the machine was paused.

A robot whose state is older than half a second stops, as it must, and then its test fails. A virtual machine pauses for
longer than that when others take its processors.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

import pytest

#: Shorter than the guard's limit of 0.5 s for the age of a state, because a world and a driver may wait in turn.
PAUSE_S = 0.25
LOOK_S = 0.02


class MachinePausedError(Exception):
    """A test failed while the machine was paused."""


class PauseMonitor:
    """Measures for how long, at most, a thread on any of the processors could not run."""

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


@contextmanager
def pauses_explain_failures() -> Iterator[None]:
    """Raise `MachinePausedError` instead of another exception if the machine was paused meanwhile."""
    monitor = PauseMonitor()
    try:
        yield
    except Exception as failure:
        if monitor.longest_s < PAUSE_S:
            raise
        raise MachinePausedError(f"the machine was paused for {monitor.longest_s:.2f} s") from failure
    finally:
        monitor.close()


def pytest_itemcollected(item: pytest.Item) -> None:
    if item.get_closest_marker("sim"):
        item.add_marker(pytest.mark.flaky(reruns=2, only_rerun=[MachinePausedError.__name__]))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    with pauses_explain_failures() if item.get_closest_marker("sim") else nullcontext():
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    with pauses_explain_failures() if item.get_closest_marker("sim") else nullcontext():
        return (yield)
