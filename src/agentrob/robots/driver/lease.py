"""Leases of the robot: one at a time, expiring one second after its last renewal was sent."""

from __future__ import annotations

import math
import secrets
import threading
import time
from typing import NamedTuple

from agentrob.errors import LeaseLost, RobotBusy
from agentrob.model import FencingToken
from agentrob.robots.codec import display_name
from agentrob.robots.driver.fencing import FencingNumbers

TTL_S = 1.0


class End(NamedTuple):
    """The end of a lease and of the commands accepted before: `why` is a stable code, `by` a name or empty."""

    why: str
    by: str = ""

    @property
    def said(self) -> str:
        """As part of a sentence: `by a stop of NAME`, `by a shutdown`."""
        if self == FENCED:
            return "because another worker took the robot"
        return f"by a {self.why} of {self.by}" if self.by else f"by a {self.why}"


LAPSED = End("lease_lapsed")
FENCED = End("fenced")


class Leases:
    """Thread-safe. The lock is held only for a few assignments, so a stop never waits for it."""

    def __init__(self, ttl_s: float = TTL_S, numbers: FencingNumbers | None = None) -> None:
        self.ttl_s = ttl_s
        self.numbers = numbers or FencingNumbers()
        self._lock = threading.Lock()
        self._lease, self._holder, self._until_s = "", "", 0.0
        self._fence: FencingToken | None = None  # of the current lease
        self._ended: tuple[str, End] = ("", LAPSED)  # (lease, end) of the last one that ended before its time
        self._last_end: tuple[float, End] = (-math.inf, LAPSED)  # (monotonic seconds, end), also without a lease

    @property
    def holder(self) -> str | None:
        """The current holder of the robot."""
        return self._holder if self._lease and time.monotonic() < self._until_s else None

    def take(self, holder: str, since_s: float = math.inf, fence: FencingToken | None = None) -> str:
        """Return a new lease for a command that was accepted at `since_s` (monotonic seconds).

        Raises `LeaseLost` if a stop or halt came since then, `Fenced` if another worker has taken the robot, and
        `RobotBusy`, which names the holder of the robot.
        """
        with self._lock:
            self.refuse_ended(since_s)
            if fence is not None:
                self.numbers.check(fence)
            if (other := self.holder) is not None:
                raise RobotBusy(
                    f"{other} holds the robot until it releases the lease or does not renew it for a second"
                )
            self._lease, self._holder, self._fence = secrets.token_urlsafe(12), holder, fence
            self._until_s = time.monotonic() + self.ttl_s
            return self._lease

    def renew(self, lease: str, sent_s: float = math.inf) -> None:
        """Extend the lease to its time to live after `sent_s`, when the renewal was sent (monotonic seconds, default
        now). A renewal that was long on its way shows that its holder was alive then, not that it is now. Raises
        `LeaseLost` if the lease has ended."""
        with self._lock:
            self._refuse_lost(lease)
            self._until_s = max(self._until_s, min(sent_s, time.monotonic()) + self.ttl_s)

    def check(self, lease: str) -> None:
        """Raise `LeaseLost` if the lease has ended."""
        with self._lock:
            self._refuse_lost(lease)

    def give_back(self, lease: str) -> None:
        with self._lock:
            if lease and lease == self._lease:
                self._lease = ""

    def end(self, why: str, by: str = "", *, running_only: bool = False) -> float:
        """End the current lease, and unless `running_only` also the commands accepted before now. Return the time in
        monotonic seconds."""
        end = End(why, display_name(by))
        with self._lock:
            ended_s = time.monotonic()
            if not running_only:
                self._last_end = (ended_s, end)
            if self._lease:
                self._ended, self._lease = (self._lease, end), ""
            return ended_s

    def fence(self, fence: FencingToken) -> None:
        """Remember the fencing number of the robot's newest holder, and end a lease with a smaller one of the same
        database. Raises `Fenced` if a larger one was seen. The caller then calls `numbers.save`."""
        with self._lock:
            held = self._fence if self._lease else None
            if self.numbers.see(fence) and held is not None and held.store == fence.store:
                self._ended, self._lease = (self._lease, FENCED), ""

    def refuse_ended(self, since_s: float) -> None:
        """Raise `LeaseLost` if a stop or halt came at or after `since_s`."""
        ended_s, end = self._last_end
        if ended_s >= since_s:
            sentence = f"the command was ended {end.said}; only a later command moves the robot"
            raise LeaseLost(sentence, end.why, end.by)

    def _refuse_lost(self, lease: str) -> None:
        if (end := self._end_of(lease)) is not None:
            raise LeaseLost(self.sentence(end), end.why, end.by)

    def lost(self, lease: str) -> str | None:
        """Return None while the lease is valid, else a stable word: `lease_lapsed`, or why it was ended."""
        end = self._end_of(lease)
        return end and end.why

    def _end_of(self, lease: str) -> End | None:
        if lease and lease == self._lease and time.monotonic() < self._until_s:
            return None
        return self._ended[1] if lease and lease == self._ended[0] else LAPSED

    @staticmethod
    def sentence(end: End) -> str:
        if end == LAPSED:
            return "the lease lapsed, was released or never existed; take a new one"
        return f"the lease was ended {end.said}; take a new one"
