"""Estimate a server's clock from `Date` headers, which have whole seconds, by comparing many answers (pure)."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta


class HeaderClock:
    """A `Date` of 12:00:03 that came between two moments of ours bounds the difference of the clocks from both sides:
    each answer may narrow it, to about as much as an answer takes."""

    def __init__(self) -> None:
        self._low_s = -float("inf")
        self._high_s = float("inf")

    def heard(self, date: datetime, asked: datetime, answered: datetime) -> None:
        """The forum said `date` at some moment between `asked` and `answered` of ours."""
        low_s = (date - answered).total_seconds()
        high_s = (date - asked).total_seconds() + 1.0
        if low_s > self._high_s or high_s < self._low_s:  # one of the clocks was set
            self._low_s, self._high_s = low_s, high_s
            return
        self._low_s, self._high_s = max(self._low_s, low_s), min(self._high_s, high_s)

    @property
    def unsure_s(self) -> float:
        """How wide the bounds are."""
        return self._high_s - self._low_s

    def now(self) -> datetime:
        """The forum's time; ours while nothing was heard."""
        here = datetime.now(UTC)
        if self.unsure_s == float("inf"):
            return here
        return here + timedelta(seconds=(self._low_s + self._high_s) / 2)
