"""Runs a world in real time or at another pace, and callbacks from other threads between its ticks."""

from __future__ import annotations

import math
import queue
import time
from collections import deque
from collections.abc import Callable

LATE_S = 0.5  # further behind than this it skips ahead; the real-time factor then drops
WAIT_S = 0.3  # a world waits this long for a command, then continues until one comes
LOOK_S = 0.001  # how often it checks meanwhile
WINDOW = 10  # the number of half seconds over which the real-time factor is averaged


class RealtimeLoop:
    """Owned by the world's thread; `call_soon` and `stop` may be called from any thread and from signal handlers."""

    def __init__(self, period_s: float, pace: float = 1.0) -> None:
        """`pace`: simulated seconds per real second, at most."""
        self._period_s, self._real_period_s = period_s, period_s / pace
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._marks: deque[tuple[float, float]] = deque(maxlen=WINDOW)
        self._simulated_s = 0.0
        self.tick_ms = 0.0

    def call_soon(self, work: Callable[[], None]) -> None:
        """Run work in the world's thread, between two ticks."""
        self._work.put(work)

    def stop(self) -> None:
        self._work.put(None)

    @property
    def real_time_factor(self) -> float:
        """Simulated per real second, over five seconds: 1.0 when the machine is fast enough, 0 when it hangs."""
        marks = list(self._marks)
        if not marks:
            return 0.0
        began, simulated = marks[0]
        real = time.monotonic() - began
        return (self._simulated_s - simulated) / real if real > self._period_s else 1.0

    def run(self, tick: Callable[[], None], awaits: Callable[[], bool] = lambda: False) -> None:
        """Tick until stopped; not while it `awaits` a command, but for at most `WAIT_S`."""
        due, waiting_since = time.monotonic(), math.inf
        while self._work_until(due):
            began = time.monotonic()
            waiting_since = min(waiting_since, began) if awaits() else math.inf
            if waiting_since <= began < waiting_since + WAIT_S:
                due = began + LOOK_S
                continue
            if not self._marks or began - self._marks[-1][0] > 0.5:
                self._marks.append((began, self._simulated_s))
            tick()
            ended = time.monotonic()
            self._simulated_s += self._period_s
            self.tick_ms += 0.02 * ((ended - began) * 1000 - self.tick_ms)
            due += self._real_period_s
            if ended - due > LATE_S:
                due = ended

    def _work_until(self, due: float) -> bool:
        """Run callbacks until the next tick is due; return False if stopped."""
        while True:
            left = due - time.monotonic()
            try:
                work = self._work.get(timeout=left) if left > 0 else self._work.get_nowait()
            except queue.Empty:
                return True
            if work is None:
                return False
            work()
