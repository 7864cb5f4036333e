"""Counts attempts to sign in, so that passwords cannot be guessed and argon2 cannot be used to exhaust the machine."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

from agentrob.errors import BoardError

WINDOW_S = 300.0
SIGN_UP_WINDOW_S = 3600.0
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

    def count_sign_up(self, address: str, most: int) -> None:
        """Count one account made from an address. 429 beyond `most` in an hour; 0 is no such limit."""
        now, key = self._clock(), ("sign-up", address)
        times = self._recent(key, now, SIGN_UP_WINDOW_S)
        if most and len(times) >= most:
            wait_s = times[0] + SIGN_UP_WINDOW_S - now
            said = f"{most} accounts were made from your address within the last hour, which is the limit"
            minutes = math.ceil(wait_s / 60)
            raise BoardError(429, "too_many_sign_ups", said, f"come again in {minutes} minutes", wait_s)
        self._seen.setdefault(key, deque()).append(now)

    def forget_sign_up(self, address: str) -> None:
        """The last one made no account."""
        if times := self._seen.get(("sign-up", address)):
            times.pop()

    def forget(self, name: str) -> None:
        """A right password: the name starts anew."""
        self._seen.pop(("name", name.lower()[:64]), None)

    def _recent(self, key: tuple[str, str], now: float, window_s: float = WINDOW_S) -> deque[float]:
        if len(self._seen) > _MAX_KEYS:
            self._seen = {k: t for k, t in self._seen.items() if t and t[-1] > now - SIGN_UP_WINDOW_S}
        times = self._seen.get(key, deque())
        while times and times[0] <= now - window_s:
            times.popleft()
        return times
