"""Counts attempts to sign in, so that passwords cannot be guessed and argon2 cannot be used to exhaust the machine."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from agentrob.errors import BoardError

WINDOW_S = 300.0
PER_NAME = 10
PER_ADDRESS = 30
_MAX_KEYS = 10_000


class Attempts:
    """At most `PER_NAME` attempts for one name and `PER_ADDRESS` from one address in `WINDOW_S`."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._seen: dict[tuple[str, str], deque[float]] = {}

    def count(self, name: str, address: str) -> None:
        """Count one attempt. 429 when there were too many; that one then does not count.

        Without a name (signing up) only the address counts: else a few newcomers would shut out all others.
        """
        now = self._clock()
        limits = [(("address", address), PER_ADDRESS)]
        if name:
            limits.insert(0, (("name", name.lower()[:64]), PER_NAME))
        for key, limit in limits:
            times = self._recent(key, now)
            if len(times) >= limit:
                wait_s = times[0] + WINDOW_S - now
                raise BoardError(429, "too_many_attempts", "too many attempts to sign in", "wait", wait_s)
        for key, _ in limits:
            self._seen.setdefault(key, deque()).append(now)

    def forget(self, name: str) -> None:
        """A right password: the name starts anew."""
        self._seen.pop(("name", name.lower()[:64]), None)

    def _recent(self, key: tuple[str, str], now: float) -> deque[float]:
        if len(self._seen) > _MAX_KEYS:
            self._seen = {k: t for k, t in self._seen.items() if t and t[-1] > now - WINDOW_S}
        times = self._seen.get(key, deque())
        while times and times[0] <= now - WINDOW_S:
            times.popleft()
        return times
