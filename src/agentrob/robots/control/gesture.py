"""Runs a robot's built-in motion as blocking calls on a separate thread; the watch is asked before each call."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence

from agentrob.robots.control.controller import RATE_HZ


class Gesture:
    """`objection` returns a reason to stop, or None. After the first reason no further call is made.

    `code` is the answer of the last call (-1 without an answer), `reason` is the objection. `unanswered`: a call did
    not return within `limit_s` by the clock `now_s`; it is left pending, and no further call is made.
    """

    def __init__(
        self,
        calls: Sequence[Callable[[], int]],
        objection: Callable[[], str | None],
        *,
        limit_s: float = math.inf,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.code, self.reason, self.unanswered = -1, "", False
        self._calls, self._objection = calls, objection
        self._limit_s, self._now_s, self._called_s = limit_s, now_s, math.inf
        self._thread = threading.Thread(target=self._run, name="gesture", daemon=True)

    @property
    def running(self) -> bool:
        """Whether an answer is still awaited, also after an objection."""
        return self._thread.is_alive() and not self.unanswered

    def follow(self) -> None:
        """Wait until the calls have returned, one is late, or there is an objection; a pending call then continues on
        its thread.

        Checks for an objection once more at the end, because a stop may abort a call before the next check.
        """
        self._thread.start()
        while self.running:
            self._thread.join(1 / RATE_HZ)
            if self.running and self._objected():
                return
            self.unanswered = self.running and self._now_s() - self._called_s > self._limit_s
        if self.code:
            self._objected()

    def _run(self) -> None:
        for call in self._calls:
            if self.unanswered or self._objected():
                return
            self.code, self._called_s = -1, self._now_s()
            self.code = int(call())
            if self.code:
                return

    def _objected(self) -> bool:
        if reason := self._objection():
            self.reason = reason  # never taken back: two threads ask
        return bool(self.reason)
