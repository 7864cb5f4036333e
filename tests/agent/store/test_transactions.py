"""The transactions of one robot: cancelled at any moment, they end the task that waits for them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from typing import Any

import pytest

from agentrob.agent.store.transactions import RobotLock, SerialExecutor, Transactions
from agentrob.model import FencingToken


@pytest.fixture
def threads() -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(1) as made:
        yield made


@pytest.mark.parametrize("turns", range(6))
async def test_a_cancellation_that_comes_with_the_answer_is_not_swallowed(
    threads: ThreadPoolExecutor, turns: int
) -> None:
    """Else a loop around it, such as that of the schedules, would go on, and its agent never end."""
    no_database: Callable[[], Any] = nullcontext
    lock = RobotLock("rex", FencingToken("store", 1))
    transactions = Transactions(no_database, no_database, SerialExecutor(threads), lock)
    begun = asyncio.Event()
    loop = asyncio.get_running_loop()

    def work(_: Any) -> str:
        loop.call_soon_threadsafe(begun.set)
        return "answer"

    reading = asyncio.create_task(transactions.read(work))
    await begun.wait()
    threads.submit(lambda: None).result()  # the thread has answered, and the event loop has not seen it
    for _ in range(turns):
        await asyncio.sleep(0)
    if reading.cancel():
        await asyncio.wait({reading})
        assert reading.cancelled()
    else:
        assert reading.result() == "answer"
