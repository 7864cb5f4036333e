"""A robot's own motion as one or more blocking calls, on a thread of their own; the watch is asked before each."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from agentrob.robots.control.controller import RATE_HZ


class Gesture:
    """`objection` gives the reason to stop now, or None. Once it gave one no call follows, also when it has passed.

    `code` is what the last call answered (-1: nothing), `reason` is the objection.
    """

    def __init__(self, calls: Sequence[Callable[[], int]], objection: Callable[[], str | None]) -> None:
        self.code, self.reason = -1, ""
        self._calls, self._objection = calls, objection
        self._thread = threading.Thread(target=self._run, name="gesture", daemon=True)

    @property
    def running(self) -> bool:
        """Whether a call is not answered yet, also after an objection."""
        return self._thread.is_alive()

    def follow(self) -> None:
        """Until the calls are answered, or until the objection; then the call under way runs on without us.

        A stop breaks a call off, which then answers an error, perhaps before the next look: so it is asked once more.
        """
        self._thread.start()
        while self.running:
            self._thread.join(1 / RATE_HZ)
            if self.running and self._objected():
                return
        if self.code:
            self._objected()

    def _run(self) -> None:
        for call in self._calls:
            if self._objected():
                return
            self.code = -1
            self.code = int(call())
            if self.code:
                return

    def _objected(self) -> bool:
        if reason := self._objection():
            self.reason = reason  # never taken back: two threads ask
        return bool(self.reason)
