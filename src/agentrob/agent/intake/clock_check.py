"""Compare the forum's clock with ours when an event's time is not the expected one, and know since when posts count."""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Callable, Coroutine
from datetime import UTC, datetime, timedelta
from typing import Any

from agentrob.agent.intake.event_stream import EventStream, elapsed_s
from agentrob.errors import ForumError

#: How long until clocks that agreed are compared again, and how long a comparison may take.
COMPARE_S, COMPARING_S = 1.0, 5.0
#: How long replies mention that the forum's clock was set.
SAID_S = 60.0


class ClockCheck:
    """The clock of one agent's forum. `spawn` starts a background task."""

    def __init__(
        self, stream: Callable[[], EventStream], spawn: Callable[[Coroutine[Any, Any, Any]], asyncio.Task[Any]]
    ) -> None:
        self._stream, self._spawn = stream, spawn
        self._begun = datetime.min.replace(tzinfo=UTC), elapsed_s()
        self._comparing: asyncio.Task[Any] | None = None
        self._compared_s = -math.inf

    def begin(self, at: datetime) -> None:
        """Let posts count from this time of the forum on."""
        self._begun = at, elapsed_s()

    @property
    def watermark_at(self) -> datetime:
        """Nothing that was posted before then is a command. Not later than our start, by the forum's clock as it is set
        now: it may have been set back since."""
        begun_at, begun_s = self._begun
        return min(begun_at, self._stream().at(begun_s))

    def note(self, at: datetime) -> None:
        """Note the forum's time. If it is not the expected one, the event is late or the clock was set: compare
        clocks."""
        idle = self._comparing is None or self._comparing.done()
        if idle and self._stream().differs(at) and elapsed_s() - self._compared_s >= COMPARE_S:
            self._comparing = self._spawn(self.compare())

    async def settled(self) -> None:
        """Wait for a comparison of clocks that is running."""
        if self._comparing is not None and not self._comparing.done():
            await asyncio.wait({self._comparing}, timeout=COMPARING_S)

    def was_set(self) -> timedelta | None:
        """By how much the forum's clock was set, if that was noticed recently."""
        step = self._stream().step
        return step.by if step is not None and elapsed_s() - step.noticed_s < SAID_S else None

    async def compare(self) -> None:
        """Compare now; a forum that does not answer within `COMPARING_S` is asked again later."""
        step = self._stream().step
        with contextlib.suppress(ForumError, TimeoutError):
            async with asyncio.timeout(COMPARING_S):
                await self._stream().set_clock()
        if self._stream().step is step:  # what came is merely late, and so may more be
            self._compared_s = elapsed_s()
