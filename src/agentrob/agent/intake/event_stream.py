"""Receive the events of a forum, streamed or polled, and measure how long the forum has been silent."""

from __future__ import annotations

import asyncio
import math
import time
import traceback
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import structlog

from agentrob.errors import ForumError, ForumLimited, ForumMalformed, ForumNotFound, ForumUnreachable
from agentrob.forums.protocol import Event, Events
from agentrob.model import EventKind

#: While a robot moves its stop channel is proven this often, and given up after `SILENCE_S` (law 16).
BEAT_S = 0.5
SILENCE_S = 2.0
UNPROVEN_STEP_S = 5.0
#: A forum's clock that is off by more than this was set.
STEP = timedelta(seconds=5)
_BACKOFF_S = (0.1, 5.0)
_log = structlog.get_logger()


def elapsed_s() -> float:
    """Seconds of a clock that cannot be set. Includes the time that the machine slept, where the system counts it."""
    return time.clock_gettime(getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC))


@dataclass(frozen=True, slots=True)
class ClockStep:
    """The forum's clock was set: `by` is positive when it was set ahead; `noticed_s` is when that was noticed, by
    `elapsed_s`."""

    by: timedelta
    noticed_s: float


class EventStream:
    """Events after `cursor`, which advances with each event. Reconnects to a forum that was away.

    A forum without a stream is polled every `poll_s` seconds, and every `BEAT_S` while a robot moves. If `listens` is
    false the forum is polled only after `poll_now` and while a robot moves. `on_beat` is called with the forum's time
    at each heartbeat; it must not wait.
    """

    def __init__(
        self,
        forum: Events,
        cursor: str,
        poll_s: float,
        listens: bool = True,
        on_beat: Callable[[datetime], None] = lambda _: None,
    ) -> None:
        self.cursor = cursor
        #: The newest change of the forum's clock that was noticed; None if it was never set.
        self.step: ClockStep | None = None
        self._on_beat = on_beat
        self._forum = forum
        self._listens = listens
        self._poll_s = poll_s if listens else math.inf
        self._polls_requested = self._polls_answered = 0
        self._hurrying = 0
        self._hurry = asyncio.Event()
        self._heard = asyncio.Event()
        self._heard_s = -float("inf")
        self._compared = datetime.now(UTC), -float("inf")  # the forum's time, and when by `elapsed_s` it was that

    # Both are asked anew each time: a forum behind another server knows them only once it was reached.
    @property
    def _live(self) -> bool:
        return self._forum.live and self._listens

    @property
    def _fastest_s(self) -> float:
        return 0.0 if self._live else self._forum.fastest_poll_s

    # ---------------------------------------------------------------- the forum's clock
    def now(self) -> datetime:
        """The forum's time now, computed from its last answer: this machine's own clock may be set meanwhile."""
        return self.at(elapsed_s())

    def at(self, moment_s: float) -> datetime:
        """The forum's time at a moment of `elapsed_s`, by the forum's clock as it is set now."""
        at, compared_s = self._compared
        if not math.isfinite(compared_s):
            at, compared_s = datetime.now(UTC), elapsed_s()
        return at + timedelta(seconds=moment_s - compared_s)

    def differs(self, at: datetime) -> bool:
        """Whether the time that the forum just reported differs from the time expected."""
        return abs(at - self.now()) > STEP

    @property
    def compared_at(self) -> datetime:
        """The forum's time in its last answer, never later than now: a post written after that answer is newer, however
        long the answer took."""
        return self._compared[0]

    async def set_clock(self) -> str:
        """Compare clocks; returns the id of the newest event. Raises `ForumError`."""
        before_s = elapsed_s()
        newest, at = await self._forum.now()
        after_s = elapsed_s()
        asked_s, by = (before_s + after_s) / 2, at - self.at((before_s + after_s) / 2)
        if math.isfinite(self._compared[1]) and abs(by) > STEP + timedelta(seconds=(after_s - before_s) / 2):
            self.step = ClockStep(by, after_s)
            _log.warning("the forum's clock was set", by_s=round(by.total_seconds(), 1), now=at.isoformat())
        self._compared = at, asked_s
        return newest

    # ---------------------------------------------------------------- alive
    @property
    def silent_s(self) -> float:
        """Seconds since the forum last proved that its events reach us."""
        return time.monotonic() - self._heard_s

    @property
    def step_s(self) -> float:
        """How long a step may take: five seconds where the forum cannot be heard each second (law 16)."""
        return math.inf if self._fastest_s <= BEAT_S * 2 else UNPROVEN_STEP_S

    @property
    def silent(self) -> bool:
        """Whether the forum has been silent for too long for a robot that moves; where it cannot be heard each second,
        `step_s` bounds that instead."""
        return self.silent_s > SILENCE_S and self.step_s == math.inf

    async def prove(self) -> bool:
        """Wait until an event or heartbeat arrives; False when the forum stays silent for `SILENCE_S`."""
        if self.silent_s <= max(BEAT_S * 2, self._fastest_s):
            return True
        self._heard.clear()
        self._hurry.set()
        try:
            async with asyncio.timeout(SILENCE_S + self._fastest_s):
                await self._heard.wait()
        except TimeoutError:
            return False
        finally:
            self._calm()
        return True

    def __enter__(self) -> EventStream:
        """`with event_stream:` while a robot moves: poll fast where polling is needed."""
        self._hurrying += 1
        self._hurry.set()
        return self

    def __exit__(self, *_: object) -> None:
        self._hurrying -= 1
        self._calm()

    async def poll_now(self) -> None:
        """Poll the forum now if it has no stream; return once the new events have been received."""
        if self._live:
            return
        self._polls_requested += 1
        mine = self._polls_requested
        self._hurry.set()
        while self._polls_answered < mine:
            self._heard.clear()
            await self._heard.wait()

    def _calm(self) -> None:
        if self._hurrying == 0 and self._polls_answered == self._polls_requested:
            self._hurry.clear()

    # ---------------------------------------------------------------- events
    async def missed(self) -> Sequence[Event]:
        """The first of the events after `cursor`; none if there are no more. Raises `ForumError`. A malformed answer
        counts as unreachable: no command continues without these events."""
        try:
            return await self._forum.changes(self.cursor)
        except ForumMalformed as e:
            raise ForumUnreachable(str(e)) from None

    async def events(self) -> AsyncIterator[Event]:
        """Yield every event once and in order, without heartbeats. `ForumNotFound`: the cursor names no event."""
        wait_s, longest_s = _BACKOFF_S
        while True:
            try:
                if elapsed_s() - self._compared[1] > 300.0:
                    await self.set_clock()
                async for event in self._forum.stream(self.cursor, BEAT_S) if self._live else self._poll():
                    wait_s = _BACKOFF_S[0]
                    self._alive()
                    if event.kind is EventKind.HEARTBEAT:
                        self._on_beat(event.at)
                    else:
                        self.cursor = event.id
                        yield event
            except ForumNotFound:
                raise
            except ForumError as e:
                wait_s = max(wait_s, e.retry_after_s) if isinstance(e, ForumLimited) else wait_s
                _log.warning("forum events cut, trying again", after_s=round(wait_s, 1), error=str(e))
            except Exception:  # a fault of the adapter: without events no stop would be received
                _log.error("forum events cut, trying again", after_s=round(wait_s, 1), trace=traceback.format_exc())
            await asyncio.sleep(wait_s)
            wait_s = min(longest_s, wait_s * 2)

    async def _poll(self) -> AsyncIterator[Event]:
        """Poll until an error; `events` then polls again."""
        while True:
            requested = self._polls_requested
            events = await self._forum.changes(self.cursor)
            self._alive()
            for event in events:
                yield event
            if not events:
                self._polls_answered = requested
                self._alive()
                self._calm()
            if not events or self._fastest_s:
                await self._pause()

    async def _pause(self) -> None:
        await asyncio.sleep(self._fastest_s)
        if self._polls_answered < self._polls_requested:
            return
        if self._hurry.is_set():
            await asyncio.sleep(max(0.0, BEAT_S - self._fastest_s))
            return
        try:
            wait_s = None if math.isinf(self._poll_s) else max(0.0, self._poll_s - self._fastest_s)
            async with asyncio.timeout(wait_s):
                await self._hurry.wait()
        except TimeoutError:
            return

    def _alive(self) -> None:
        self._heard_s = time.monotonic()
        self._heard.set()
