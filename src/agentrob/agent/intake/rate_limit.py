"""How often one account may command one robot: a cooldown, which waits, a number per hour, and a number at a time."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from limits import RateLimitItem, RateLimitItemPerHour, RateLimitItemPerSecond
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from agentrob.config.robots import RatesConfig

#: A command waits so long at most; beyond, it is refused.
SHORT_S = 30.0


@dataclass(frozen=True, slots=True)
class RateLimitWait:
    """Why and how long an account has to wait: `rule` is the name of what it met."""

    rule: str
    seconds: float

    @property
    def short(self) -> bool:
        """Then the command waits by itself; else its author is told when to post it again."""
        return self.seconds <= SHORT_S

    @property
    def minutes(self) -> int:
        """As people say it: full minutes, at least one."""
        return max(1, math.ceil(self.seconds / 60))


class RateLimiter:
    """Counts commands that were allowed otherwise; in memory, so a restart begins anew. Stops are never counted."""

    def __init__(self, rates: RatesConfig) -> None:
        self._limiter = MovingWindowRateLimiter(MemoryStorage())
        self._items: dict[str, RateLimitItem] = {}
        if rates.commands_per_hour:
            self._items["rate.hour"] = RateLimitItemPerHour(rates.commands_per_hour)
        if rates.cooldown_s:
            self._items["rate.cooldown"] = RateLimitItemPerSecond(1, rates.cooldown_s)

    def take(self, account: str) -> RateLimitWait | None:
        """Count one command of this account now; or, uncounted, what it has to wait for."""
        waits = [RateLimitWait(rule, self._wait_s(item, account)) for rule, item in self._items.items()]
        longest = max(waits, key=lambda wait: wait.seconds, default=None)
        if longest is not None and longest.seconds > 0:
            return longest
        for item in self._items.values():
            self._limiter.hit(item, account)
        return None

    def exceeded(self, account: str) -> bool:
        """Whether a command of this account would be refused now; counts nothing."""
        return any(not RateLimitWait(rule, self._wait_s(item, account)).short for rule, item in self._items.items())

    def _wait_s(self, item: RateLimitItem, account: str) -> float:
        if self._limiter.test(item, account):
            return 0.0
        # The window may tell whole seconds; a moment more, so that the next look finds it free.
        return max(0.05, self._limiter.get_window_stats(item, account).reset_time - time.time())
