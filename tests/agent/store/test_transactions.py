"""The transactions of one robot: cancelled at any moment, they end the task that waits for them."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from typing import Any

import pytest

from agentrob.agent.store.transactions import RobotLock, SerialExecutor, Transactions
from agentrob.model import FencingToken


@pytest.fixture
def threads() -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(1) as made:
        yield made


def test_calls_of_one_robot_run_one_after_the_other_in_their_order_and_those_of_another_beside_them() -> None:
    with ThreadPoolExecutor(4) as threads:
        mine, others = SerialExecutor(threads), SerialExecutor(threads)
        gate, told = threading.Event(), list[str]()

        def call(number: int) -> int:
            told.append(f"begins {number}")
            if number == 0:
                assert gate.wait(60)
            told.append(f"ends {number}")
            return number

        futures = [mine.submit(partial(call, number)) for number in range(5)]
        assert others.submit(lambda: "beside").result(60) == "beside"  # behind all that wait for a thread
        assert told == ["begins 0"]
        gate.set()
        assert [future.result(60) for future in futures] == [0, 1, 2, 3, 4]
        assert told == [f"{does} {number}" for number in range(5) for does in ("begins", "ends")]


def test_a_call_that_fails_or_is_cancelled_does_not_hold_up_those_behind_it() -> None:
    with ThreadPoolExecutor(2) as threads:
        calls, gate = SerialExecutor(threads), threading.Event()
        first = calls.submit(partial(gate.wait, 60))
        fails, taken_back, last = calls.submit(lambda: 1 // 0), calls.submit(lambda: "no"), calls.submit(lambda: "yes")
        assert taken_back.cancel()
        gate.set()
        assert last.result(60) == "yes"
        assert first.result(60)
        assert isinstance(fails.exception(60), ZeroDivisionError)
        assert taken_back.cancelled()


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
