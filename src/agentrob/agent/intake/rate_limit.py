"""Limit how often one account may command one robot: a cooldown and a number of commands per hour."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from limits import RateLimitItem, RateLimitItemPerHour, RateLimitItemPerSecond
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from agentrob.config.robots import RatesConfig

#: The longest time that a command waits for its limit; one that would wait longer is refused.
SHORT_S = 30.0


@dataclass(frozen=True, slots=True)
class RateLimitWait:
    """How long an account has to wait, and the name of the limit that it reached."""

    rule: str
    seconds: float

    @property
    def short(self) -> bool:
        """Whether the command waits by itself. If not, it is refused, and the reply says when to post it again."""
        return self.seconds <= SHORT_S

    @property
    def minutes(self) -> int:
        """Full minutes, at least one."""
        return max(1, math.ceil(self.seconds / 60))


class RateLimiter:
    """Counts the commands of each account in memory, so a restart resets it. Stops are never counted."""

    def __init__(self, rates: RatesConfig) -> None:
        self._limiter = MovingWindowRateLimiter(MemoryStorage())
        self._items: dict[str, RateLimitItem] = {}
        if rates.commands_per_hour:
            self._items["rate.hour"] = RateLimitItemPerHour(rates.commands_per_hour)
        if rates.cooldown_s:
            self._items["rate.cooldown"] = RateLimitItemPerSecond(1, rates.cooldown_s)

    def take(self, account: str) -> RateLimitWait | None:
        """Count one command of this account; if it is over a limit, count nothing and return the wait."""
        waits = [RateLimitWait(rule, self._wait_s(item, account)) for rule, item in self._items.items()]
        longest = max(waits, key=lambda wait: wait.seconds, default=None)
        if longest is not None and longest.seconds > 0:
            return longest
        for item in self._items.values():
            self._limiter.hit(item, account)
        return None

    def exceeded(self, account: str) -> bool:
        """Whether a command of this account would be refused now. Counts nothing."""
        return any(not RateLimitWait(rule, self._wait_s(item, account)).short for rule, item in self._items.items())

    def _wait_s(self, item: RateLimitItem, account: str) -> float:
        if self._limiter.test(item, account):
            return 0.0
        # The window may be in whole seconds: wait a moment longer, so that the next check passes.
        return max(0.05, self._limiter.get_window_stats(item, account).reset_time - time.time())
