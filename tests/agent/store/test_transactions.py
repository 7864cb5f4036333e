"""The transactions of one robot: in order, each committed once although its connection breaks, and cancelled at any
moment."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import Any

import pytest
from sqlalchemy import Column, Connection, Integer, MetaData, StaticPool, Table, create_engine, insert, select, update
from sqlalchemy.exc import IntegrityError, OperationalError

from agentrob.agent.store import transactions
from agentrob.agent.store.schema import HOLDER, METADATA
from agentrob.agent.store.transactions import RobotLock, SerialExecutor, Transactions
from agentrob.errors import JournalError, JournalHeld
from agentrob.model import FencingToken

LEDGER = Table("ledger", MetaData(), Column("number", Integer, primary_key=True))
#: When a connection breaks: before the transaction, in its commit, after the commit but before the answer, and in the
#: commit with another worker that takes the robot at once.
CONNECTING, LOST, COMMITTED, TAKEN = "connecting", "lost", "committed", "taken"


class Database:
    """One row in `holder`, that of rex under number 7. `breaks` says of each try whether and when it breaks."""

    def __init__(self) -> None:
        self.engine = create_engine("sqlite://", poolclass=StaticPool, connect_args={"check_same_thread": False})
        METADATA.create_all(self.engine)
        LEDGER.create(self.engine)
        self.breaks: deque[str] = deque()
        self.always = ""
        self.tries = 0
        self.tried = threading.Event()
        with self.engine.begin() as db:
            db.execute(insert(HOLDER).values(robot="rex", number=7))

    @contextmanager
    def begin(self) -> Iterator[Connection]:
        how = self.always or (self.breaks.popleft() if self.breaks else "")
        self.tries += 1
        self.tried.set()
        if how == CONNECTING:
            raise OperationalError(None, None, Exception("no connection"))
        with self.engine.connect() as db:
            yield db
            if how not in (LOST, TAKEN):
                db.commit()
        if how == TAKEN:
            self.take()
        if how:
            raise OperationalError("COMMIT", None, Exception("the server is gone"), connection_invalidated=True)

    @property
    def ledger(self) -> list[int]:
        with self.engine.connect() as db:
            return list(db.execute(select(LEDGER.c.number)).scalars())

    def take(self) -> None:
        """Another worker takes the robot."""
        with self.engine.begin() as db:
            db.execute(update(HOLDER).values(number=8))


def write_down(db: Connection) -> int:
    db.execute(insert(LEDGER).values(number=None))
    return 42


@pytest.fixture
def database() -> Database:
    return Database()


@pytest.fixture
def rows(database: Database, monkeypatch: pytest.MonkeyPatch) -> Iterator[Transactions]:
    monkeypatch.setattr(transactions, "PAUSE_S", 0.01)
    with ThreadPoolExecutor(2) as threads:
        lock = RobotLock("rex", FencingToken("store", 7))
        yield Transactions(database.begin, database.begin, SerialExecutor(threads), lock)


@pytest.mark.parametrize(
    "breaks",
    [
        [],
        [CONNECTING],
        [LOST],
        [COMMITTED],
        [LOST, CONNECTING, LOST],
        [LOST, COMMITTED],
        [COMMITTED, CONNECTING],
        [COMMITTED, LOST],
    ],
    ids=" ".join,
)
async def test_law_6_a_transaction_whose_connection_breaks_is_committed_once(
    database: Database, rows: Transactions, breaks: list[str]
) -> None:
    database.breaks.extend(breaks)
    assert await rows.write(write_down) == 42
    assert (database.tries, database.ledger) == (len(breaks) + 1, [1])
    assert await rows.write(write_down) == 42  # another transaction is another one
    assert database.ledger == [1, 2]


async def test_reading_is_tried_again_and_needs_no_fence(database: Database, rows: Transactions) -> None:
    await rows.write(write_down)
    database.take()
    database.breaks.extend([CONNECTING, CONNECTING])
    assert await rows.read(lambda db: db.execute(select(LEDGER.c.number)).scalars().all()) == [1]


@pytest.mark.parametrize("begins", [False, True])
async def test_law_6_nothing_is_written_once_another_worker_has_taken_the_robot(
    database: Database, rows: Transactions, begins: bool
) -> None:
    database.take()
    with pytest.raises(JournalHeld, match="another worker has taken rex"):
        await rows.write(write_down, begins)
    assert (database.ledger, rows.lock.lost.is_set()) == ([], True)


async def test_law_6_a_transaction_that_was_lost_is_not_repeated_after_another_worker_has_taken_the_robot(
    database: Database, rows: Transactions
) -> None:
    database.breaks.append(TAKEN)
    with pytest.raises(JournalHeld, match="another worker has taken rex"):
        await rows.write(write_down)
    assert (database.ledger, database.tries) == ([], 2)


async def test_law_11_with_a_lost_robot_what_waits_does_not_begin_and_ends_are_written(
    database: Database, rows: Transactions
) -> None:
    gate, running = threading.Event(), threading.Event()

    def wait(_: Connection) -> None:
        running.set()
        assert gate.wait(60)

    first = asyncio.create_task(rows.write(wait))
    begins = asyncio.create_task(rows.write(write_down, begins=True))  # waits behind the first
    assert await asyncio.to_thread(running.wait, 60)
    rows.lock.lost.set()
    gate.set()
    await first
    with pytest.raises(JournalHeld, match="this worker has lost rex"):
        await begins
    assert database.ledger == []
    assert await rows.write(write_down) == 42
    with pytest.raises(JournalHeld, match="this worker has lost rex"):
        await rows.write(write_down, begins=True)
    assert database.ledger == [1]


async def test_the_error_of_a_statement_is_told_at_once(database: Database, rows: Transactions) -> None:
    def fails(db: Connection) -> None:
        write_down(db)
        db.execute(insert(LEDGER).values(number=1))

    with pytest.raises(JournalError, match="the journal cannot be used: UNIQUE") as refused:
        await rows.write(fails)
    assert isinstance(refused.value.__context__, IntegrityError)
    assert (database.tries, database.ledger, rows.lock.lost.is_set()) == (1, [], False)


async def test_a_broken_connection_is_told_after_a_while(
    database: Database, rows: Transactions, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transactions, "RETRY_S", 1.0)
    database.always = CONNECTING
    with pytest.raises(JournalError, match="the journal cannot be used: no connection"):
        await rows.write(write_down)
    assert database.tries > 1


async def test_a_file_is_not_tried_again(database: Database) -> None:
    with ThreadPoolExecutor(1) as threads:
        rows = Transactions(database.begin, database.begin, SerialExecutor(threads), RobotLock("rex"))
        database.always = LOST
        with pytest.raises(JournalError, match="the server is gone"):
            await rows.write(write_down)
    assert database.tries == 1


async def test_closing_ends_what_is_tried_again_and_waits_for_it(
    database: Database, rows: Transactions, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transactions, "RETRY_S", 60.0)
    database.always = CONNECTING
    writing = asyncio.create_task(rows.write(write_down))
    assert await asyncio.to_thread(database.tried.wait, 60)
    await rows.close()
    tries = database.tries
    with pytest.raises(JournalError, match="no connection"):
        await writing
    with pytest.raises(JournalError, match="the journal is closed"):
        await rows.write(write_down)
    assert database.tries == tries


async def test_a_database_that_does_not_answer_is_not_waited_for(database: Database, rows: Transactions) -> None:
    gate = threading.Event()
    rows.patience_s = 0.05
    try:
        with pytest.raises(JournalError, match="does not answer"):
            await rows.write(lambda _: gate.wait(60))
        await rows.close()  # nor does closing wait for it
    finally:
        gate.set()


# ------------------------------------------------------------ order and cancellation
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
    rows = Transactions(no_database, no_database, SerialExecutor(threads), lock)
    begun = asyncio.Event()
    loop = asyncio.get_running_loop()

    def work(_: Any) -> str:
        loop.call_soon_threadsafe(begun.set)
        return "answer"

    reading = asyncio.create_task(rows.read(work))
    await begun.wait()
    threads.submit(lambda: None).result()  # the thread has answered, and the event loop has not seen it
    for _ in range(turns):
        await asyncio.sleep(0)
    if reading.cancel():
        await asyncio.wait({reading})
        assert reading.cancelled()
    else:
        assert reading.result() == "answer"
