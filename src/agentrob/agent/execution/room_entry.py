"""Wait for the room that a robot shares with others, before a command and between its steps. The driver decides."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence

from agentrob.model import Hindrance, Primitive
from agentrob.robots.driver.client import DriverClient

#: How often the driver is asked while the robot waits; it forgets those that do not ask for 3 s.
ASK_S = 0.3


class RoomEntry:
    """Asks one robot's driver for its room. `shared` says whether the robot shares one; `on_change` is called when it
    begins or ends to wait for another robot."""

    def __init__(self, driver: DriverClient, shared: bool, on_change: Callable[[], None] = lambda: None) -> None:
        self._driver, self._shared, self._on_change = driver, shared, on_change
        self._awaited: Hindrance | None = None

    @property
    def awaited(self) -> Hindrance | None:
        """Whom the robot waits for now."""
        return self._awaited

    async def enter(
        self,
        steps: Sequence[Primitive],
        on_wait: Callable[[Hindrance], None],
        ended: Callable[[], object] = lambda: None,
        limit_s: float = float("inf"),
    ) -> Hindrance | None:
        """Return None once these steps may begin, also if the command `ended`; else what waiting does not change, or
        what was still in the way after `limit_s`. `on_wait` is called when the reason to wait changes.

        Raises `RobotError` if the driver does not answer.
        """
        if not self._shared or not any(step.moves for step in steps):
            return None
        end_s = time.monotonic() + limit_s
        try:
            while not ended() and (hindrance := await self._driver.enter_room(steps)) is not None:
                if not hindrance.passes or time.monotonic() >= end_s:
                    return hindrance
                if hindrance.robot and _changed(self._awaited, hindrance):
                    on_wait(hindrance)
                    self._await(hindrance)
                await asyncio.sleep(ASK_S)
            return None
        finally:
            self._await(None)

    def _await(self, hindrance: Hindrance | None) -> None:
        if hindrance is not self._awaited:
            self._awaited = hindrance
            self._on_change()


def _changed(before: Hindrance | None, now: Hindrance) -> bool:
    """Whether people should hear of it: whom it waits for, what that one does, or that its driver fell silent."""
    return before is None or (before.robot, before.doing, before.silent) != (now.robot, now.doing, now.silent)
