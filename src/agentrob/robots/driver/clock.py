"""The monotonic clock of a driver's host, as a client on another host knows it.

A measurement says when the client asked and was answered, and the time at the driver in between. So the difference
between the clocks is known within the round trip; several measurements narrow it down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

#: How fast two clocks may drift apart: each may be adjusted by 500 ppm, and quartz adds 100.
DRIFT = 0.0012


@dataclass
class DriverClock:
    """`low_s` and `high_s` bound the driver's time minus ours; `boot` names the boot of the driver's host."""

    boot: str = ""
    low_s: float = -math.inf
    high_s: float = math.inf
    _measured_s: float = 0.0

    @property
    def known(self) -> bool:
        return self.boot != ""

    def measured(self, boot: str, driver_s: float, asked_s: float, answered_s: float) -> None:
        """Use a measurement: at `driver_s` of the driver's clock, ours was between `asked_s` and `answered_s`.

        One that contradicts the earlier ones replaces them: a host was restarted or suspended.
        """
        low_s, high_s = driver_s - answered_s, driver_s - asked_s
        drift_s = DRIFT * max(0.0, answered_s - self._measured_s)
        narrow_low_s, narrow_high_s = max(low_s, self.low_s - drift_s), min(high_s, self.high_s + drift_s)
        if boot == self.boot and narrow_low_s <= narrow_high_s:
            low_s, high_s = narrow_low_s, narrow_high_s
        self.boot, self.low_s, self.high_s, self._measured_s = boot, low_s, high_s, answered_s

    def earliest_there(self, ours_s: float, now_s: float) -> float:
        """A time of ours by the driver's clock, at the earliest."""
        return ours_s + self.low_s - self._drift_s(now_s)

    def earliest_here(self, driver_s: float, now_s: float) -> float:
        """A time of the driver's clock by ours, at the earliest."""
        return driver_s - self.high_s - self._drift_s(now_s)

    def latest_here(self, driver_s: float, now_s: float) -> float:
        """A time of the driver's clock by ours, at the latest."""
        return driver_s - self.low_s + self._drift_s(now_s)

    def _drift_s(self, now_s: float) -> float:
        return DRIFT * max(0.0, now_s - self._measured_s)
