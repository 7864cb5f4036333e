"""Read a command while it is written: what a robot would do, or why it would not, without carrying anything out.

A `CommandReader` is given to `server.create_app`; the board knows no rules of reading itself. It runs on a thread of
its own, one text at a time, and is expected to work in another process, so that it never delays a stop (law 15).
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Protocol

from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from agentrob.errors import BoardError
from agentrob.model import Account, Capabilities, Plan, RobotRights

#: Texts that one account may have read in a minute: a fast typist pauses about four times a second.
PER_MINUTE = 300
#: Characters of a text that is read while it is written.
READ_CHARS = 2_000
#: The number of texts that may wait for their turn.
MAX_WAITING = 16


@dataclass(frozen=True, slots=True)
class ReadableRobot:
    """A robot that may be addressed. `history` are the plans that were done in the thread, oldest first.

    `sees`: the things that it finds in its camera's pictures. `consents`: the risky operations that its owner
    consents to, or all where that is not known. `scene` describes its surroundings, if that is known.
    """

    name: str
    can: Capabilities
    rights: RobotRights = RobotRights()
    history: tuple[Plan, ...] = ()
    sees: tuple[str, ...] = ()
    consents: frozenset[str] = frozenset()
    scene: str = ""


@dataclass(frozen=True, slots=True)
class DraftCommand:
    """The text of a post that is not written yet, and the robots of the board."""

    text: str
    author: Account
    robots: tuple[ReadableRobot, ...] = ()


@dataclass(frozen=True, slots=True)
class RobotReading:
    """How one robot reads a text: a sentence for people (`line`), the outcome (a word that `RobotReadingOut` lists),
    the rule that objects, if any, and the steps as data."""

    robot: str
    line: str
    outcome: str
    rule: str = ""
    steps: tuple[dict[str, object], ...] = ()


@dataclass(frozen=True, slots=True)
class DraftReading:
    """`mentioned` are all names that the text mentions, `robots` the readings of those that are robots here."""

    mentioned: tuple[str, ...] = ()
    robots: tuple[RobotReading, ...] = ()


class CommandReader(Protocol):
    """Reads texts. `read` blocks; it is called from one thread. Raises `TooSlow` for a text that takes too long."""

    def read(self, draft: DraftCommand) -> DraftReading: ...

    def close(self) -> None: ...


class ReadingQueue:
    """The texts that are read, one at a time."""

    def __init__(self, make: Callable[[], CommandReader]) -> None:
        self._reader = make()
        self._thread = ThreadPoolExecutor(1, "board-reading")
        self._waiting = 0
        self._begun = False
        self._limiter, self._most = MovingWindowRateLimiter(MemoryStorage()), RateLimitItemPerMinute(PER_MINUTE)

    def warm(self) -> None:
        """Start the reader, unless it was started before, so that the first text does not wait for that."""
        if self._begun:
            return
        self._begun = True
        nobody = Account("0", "nobody")
        self._thread.submit(self._reader.read, DraftCommand("", nobody)).add_done_callback(
            lambda done: done.exception()
        )

    def close(self) -> None:
        self._reader.close()
        self._thread.shutdown(cancel_futures=True)

    async def read(self, draft: DraftCommand) -> DraftReading:
        """429 if the account has too many texts read, 503 if too many wait, 413 for a long text. Raises `TooSlow`."""
        if len(draft.text) > READ_CHARS:
            raise BoardError(413, "too_long_to_read", "the text is too long to be read while it is written",
                             f"at most {READ_CHARS} characters")  # fmt: skip
        if not self._limiter.hit(self._most, draft.author.id):
            what = f"this account had {PER_MINUTE} texts read within a minute, which is the limit"
            raise BoardError(429, "too_many_readings", what, "posting is not affected", 10.0)
        if self._waiting >= MAX_WAITING:
            raise BoardError(503, "overloaded", "too many texts are waiting to be read", "try again in a moment", 1.0)
        self._waiting += 1
        try:
            return await asyncio.wrap_future(self._thread.submit(self._reader.read, draft))
        finally:
            self._waiting -= 1
