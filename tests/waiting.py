"""Wait, under a limit, for what no event tells: another process, a thread, a database."""

from __future__ import annotations

import asyncio
import inspect
import time
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

from agentrob.model import RobotState

LIMIT_S, EVERY_S = 60.0, 0.01
T = TypeVar("T")


async def until(
    read: Callable[[], T | Awaitable[T]], holds: Callable[[T], Any] = bool, *, limit_s: float = LIMIT_S
) -> T:
    """Read again and again until a condition holds of what is read, and return that."""
    found: Any = None
    try:
        async with asyncio.timeout(limit_s):
            while True:
                found = read()
                found = await found if inspect.isawaitable(found) else found
                if holds(found):
                    return found
                await asyncio.sleep(EVERY_S)
    except TimeoutError:
        raise AssertionError(f"not within {limit_s:g} s: {found!r}") from None


def wait_for(read: Callable[[], T], holds: Callable[[T], Any] = bool, *, limit_s: float = LIMIT_S) -> T:
    """Do the same as `until`, for tests without an event loop."""
    end_s = time.monotonic() + limit_s
    while not holds(found := read()):
        assert time.monotonic() < end_s, f"not within {limit_s:g} s: {found!r}"
        time.sleep(EVERY_S)
    return found


def walks(state: RobotState) -> bool:
    """Return whether a robot moves forward."""
    return (state.velocity_mps or (0.0,))[0] > 0.1
