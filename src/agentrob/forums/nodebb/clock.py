"""Estimate a server's clock from `Date` headers, which have whole seconds, by comparing many answers (pure)."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta


class HeaderClock:
    """A `Date` of 12:00:03 received between two local times bounds the difference of the clocks on both sides. Each
    answer may narrow the bounds, to about the duration of an answer."""

    def __init__(self) -> None:
        self._low_s = -float("inf")
        self._high_s = float("inf")

    def add(self, date: datetime, asked: datetime, answered: datetime) -> None:
        """Record a `Date` received between the local times `asked` and `answered`."""
        low_s = (date - answered).total_seconds()
        high_s = (date - asked).total_seconds() + 1.0
        if low_s > self._high_s or high_s < self._low_s:  # one of the clocks was changed
            self._low_s, self._high_s = low_s, high_s
            return
        self._low_s, self._high_s = max(self._low_s, low_s), min(self._high_s, high_s)

    @property
    def uncertainty_s(self) -> float:
        """Return the width of the bounds."""
        return self._high_s - self._low_s

    def now(self) -> datetime:
        """Return the forum's time, or ours before the first answer."""
        here = datetime.now(UTC)
        if self.uncertainty_s == float("inf"):
            return here
        return here + timedelta(seconds=(self._low_s + self._high_s) / 2)
