"""Clocks on which a robot's own motion is timed: the host's for real robots, the robot's stamps for simulated ones.

On a busy machine a simulated world runs slower than life: what its robot does takes longer by the host's clock, and as
long as ever by the robot's. Leases, deadlines, the age of states and stops are always timed by the host's clock.
"""

from __future__ import annotations

import math
import threading
import time
from typing import Protocol

#: A simulated robot sends a state this often. Until the next one its clock runs on with the host's for so long.
STATE_EVERY_S = 0.02
#: A robot that sends nothing for so long is silent: its clock runs on with the host's, so that no wait lasts forever.
SILENT_S = 0.5
#: A stamp that is further ahead than this is a clock that was set. The host's clock tells how much time passed.
LEAP_S = 1.0
#: `wait_until` returns this much later than on the host's clock at the latest, so that a stop is noticed meanwhile.
LATE_S = 0.1


class Clock(Protocol):
    """Times are seconds since any moment."""

    def now_s(self) -> float: ...

    def wait_until(self, time_s: float) -> None: ...


class HostClock:
    """The host's monotonic clock."""

    def now_s(self) -> float:
        return time.monotonic()

    def wait_until(self, time_s: float) -> None:
        time.sleep(max(0.0, time_s - time.monotonic()))


class StampClock:
    """The clock of a simulated robot, from the stamps of its states; the host's where they carry none. Thread-safe."""

    def __init__(self) -> None:
        self._taken = threading.Condition()
        self._seconds, self._stamp_s, self._came_s = 0.0, math.nan, time.monotonic()

    def take(self, came_s: float, stamp_s: float) -> None:
        """Process the stamp of a state that came at `came_s` (monotonic seconds)."""
        with self._taken:
            passed_s = stamp_s - self._stamp_s
            if not 0.0 < passed_s <= LEAP_S:
                passed_s = came_s - self._came_s
            self._seconds = max(self._at(came_s), self._seconds + passed_s)
            self._stamp_s, self._came_s = stamp_s, came_s
            self._taken.notify_all()

    def now_s(self) -> float:
        with self._taken:
            return self._at(time.monotonic())

    def wait_until(self, time_s: float) -> None:
        with self._taken:
            began_s = time.monotonic()
            latest_s = began_s + time_s - self._at(began_s) + LATE_S
            while (left_s := time_s - self._at(now_s := time.monotonic())) > 0 and now_s < latest_s:
                self._taken.wait(min(left_s, latest_s - now_s))

    def _at(self, now_s: float) -> float:
        since_s = max(0.0, now_s - self._came_s)
        return self._seconds + min(since_s, STATE_EVERY_S) + max(0.0, since_s - SILENT_S)
