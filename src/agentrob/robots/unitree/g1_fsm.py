"""Polls the state of the G1's own state machine five times a second, by its API id.

The SDK's client has no call for it, and its `Start` sends the state of older firmware (200, where it is 500 now).
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from typing import Any

GET_FSM_ID, SET_FSM_ID = 7001, 7101
#: Walking, and ready to walk: 500 in the main motion service, 501 with the waist free, 801 in the newer one, 200 once.
WALK = 500
WALKING = frozenset({WALK, 501, 801, 200})
LOCKED = 4
#: Other states as modes of `model.RobotState`: zero torque, damping, squatting, sitting, locked, getting up.
MODES = {0: "damping", 1: "damping", 2: "locked", 3: "sitting", LOCKED: "locked", 702: "lying", 706: "locked"}

EVERY_S = 0.2
#: An answer older than this is ignored; the mode is then unknown.
OLD_S = 1.0


class FsmMonitor:
    """Polls on a thread; `id` is the newest answer, None if there is none or it is old."""

    def __init__(self, client: Any, there: Callable[[], bool]) -> None:
        """`client` is a LocoClient with a short timeout, for this monitor only. Polls only while `there` is true."""
        self._client, self._there = client, there
        self._newest: tuple[float, int] | None = None
        self._closed = threading.Event()
        threading.Thread(target=self._poll, name="g1 fsm", daemon=True).start()

    @property
    def id(self) -> int | None:
        newest = self._newest
        return newest[1] if newest is not None and time.monotonic() - newest[0] < OLD_S else None

    def wait(self, limit_s: float) -> int | None:
        """Return the id, waiting for the first answer if there is none yet."""
        end_s = time.monotonic() + limit_s
        while (found := self.id) is None and time.monotonic() < end_s:
            self._closed.wait(0.02)
        return found

    def close(self) -> None:
        self._closed.set()

    def _poll(self) -> None:
        wait_s = 0.0
        while not self._closed.wait(wait_s):
            wait_s = EVERY_S
            if not self._there():
                continue
            asked_s = time.monotonic()
            code, data = self._client._Call(GET_FSM_ID, "{}")
            if code == 0 and (found := parse(data)) is not None:
                self._newest = asked_s, found


def parse(data: Any) -> int | None:
    """The id in an answer (`{"data": 500}`), or None."""
    try:
        return int(json.loads(data)["data"])
    except (ValueError, KeyError, TypeError):
        return None
