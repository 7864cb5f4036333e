"""One robot's transactions, one after the other in the order of the calls, on threads that all robots share."""

from __future__ import annotations

import asyncio
import sqlite3
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future
from contextlib import AbstractContextManager
from functools import partial
from threading import Lock
from typing import Any, TypeVar
from uuid import uuid4

from sqlalchemy import Connection
from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from agentrob.agent.store.queries import CHECK_FENCE, MARK
from agentrob.errors import JournalError, JournalHeld
from agentrob.model import FencingToken

T = TypeVar("T")
Begin = Callable[[], AbstractContextManager[Connection]]

#: How long a transaction is tried again while PostgreSQL cannot be reached, and the pause between two tries.
RETRY_S, PAUSE_S = 10.0, 0.2
#: How long a caller waits for PostgreSQL, which may never answer.
PATIENCE_S = 15.0


class SerialExecutor:
    """Runs calls one after the other, in the order of `submit`, on the threads of another executor. It gives its thread
    back after each call, so that robots take turns."""

    def __init__(self, threads: Executor) -> None:
        self._threads = threads
        self._waiting: deque[tuple[Future[Any], Callable[[], Any]]] = deque()
        self._running = False
        self._lock = Lock()

    def submit(self, call: Callable[[], T]) -> Future[T]:
        future: Future[T] = Future()
        with self._lock:
            self._waiting.append((future, call))
            if not self._running:
                self._running = True
                self._threads.submit(self._run_next)
        return future

    async def run(self, call: Callable[..., T], *args: Any) -> T:
        return await asyncio.wrap_future(self.submit(partial(call, *args)))

    def _run_next(self) -> None:
        future, call = self._waiting.popleft()
        if future.set_running_or_notify_cancel():
            try:
                result = call()
            except BaseException as e:
                future.set_exception(e)
            else:
                future.set_result(result)
        with self._lock:
            self._running = bool(self._waiting)
            if self._running:
                self._threads.submit(self._run_next)


class RobotLock:
    """That this process holds a robot, until `lost` is set. `fence` is None where no other machine can take it."""

    def __init__(self, robot: str, fence: FencingToken | None = None) -> None:
        self.robot, self.fence = robot, fence
        self.lost = asyncio.Event()


class Transactions:
    """Transactions on the rows of one robot.

    On PostgreSQL each one that writes begins with an update of the robot's row in `holder`. It changes nothing if
    another worker has taken the robot: then `JournalHeld` is raised. It also locks the row, so that nobody takes the
    robot before the commit, and leaves a random mark in it. If the connection breaks, the mark tells whether the
    transaction was committed: it is repeated only if it was not.

    `reading` and `writing` begin a transaction that reads or writes.
    """

    def __init__(self, reading: Begin, writing: Begin, calls: SerialExecutor, lock: RobotLock) -> None:
        self.reading, self.writing, self.lock, self._calls = reading, writing, lock, calls
        self.patience_s = PATIENCE_S if lock.fence else None
        self.closed = False

    async def read(self, work: Callable[[Connection], T]) -> T:
        return await self._run(partial(self._attempt, partial(self._read, work)))

    async def write(self, work: Callable[[Connection], T], begins: bool = False) -> T:
        """`begins`: not after the robot was lost, even if nobody else has taken it yet."""
        once = _Write(self, work, begins)
        try:
            if begins:
                self.check_held()
            return await self._run(partial(self._attempt, once.run))
        except JournalHeld:
            self.lock.lost.set()
            raise

    def check_held(self) -> None:
        """Raise `JournalHeld` once the robot was lost."""
        if self.lock.lost.is_set():
            raise JournalHeld(f"this worker has lost {self.lock.robot}")

    async def close(self) -> None:
        """Let the calls that were made end, and refuse others."""
        self.closed = True
        await asyncio.wait({asyncio.wrap_future(self._calls.submit(lambda: None))}, timeout=self.patience_s)

    async def _run(self, call: Callable[[], T]) -> T:
        if self.closed:
            raise JournalError("the journal is closed")
        try:
            async with asyncio.timeout(self.patience_s):
                return await self._calls.run(call)
        except TimeoutError:
            raise JournalError("the journal's database does not answer") from None
        except (SQLAlchemyError, sqlite3.Error) as e:
            raise JournalError(f"the journal cannot be used: {getattr(e, 'orig', e)}") from None

    def _read(self, work: Callable[[Connection], T]) -> T:
        with self.reading() as db:
            return work(db)

    def _attempt(self, transaction: Callable[[], T]) -> T:
        until_s = time.monotonic() + RETRY_S
        while True:
            try:
                return transaction()
            except DBAPIError as e:
                if self.lock.fence is None or not lost_connection(e) or self.closed or time.monotonic() > until_s:
                    raise
            time.sleep(PAUSE_S)


class _Write:
    """One transaction that writes, however often it is tried."""

    def __init__(self, rows: Transactions, work: Callable[[Connection], Any], begins: bool) -> None:
        self._rows, self._lock, self._work, self._begins = rows, rows.lock, work, begins
        self._mark = uuid4().hex
        self._result: Any = None
        self._committing = False

    def run(self) -> Any:
        with self._rows.writing() as db:
            if (fence := self._lock.fence) is not None:
                if self._begins:
                    self._rows.check_held()
                if self._committing and self._committed(db):
                    return self._result
                self._check_fence(db, fence)
            self._result = self._work(db)
            self._committing = True
        return self._result

    def _committed(self, db: Connection) -> bool:
        """Whether an earlier try was committed. Waits for its end, if the server still works on it."""
        return db.execute(MARK, {"this_robot": self._lock.robot}).scalar() == self._mark

    def _check_fence(self, db: Connection, fence: FencingToken) -> None:
        row = {"this_robot": self._lock.robot, "this_number": fence.number, "written": self._mark}
        if not db.execute(CHECK_FENCE, row).rowcount:
            raise JournalHeld(f"another worker has taken {self._lock.robot}")


def lost_connection(error: DBAPIError) -> bool:
    """Whether the connection broke, could not be made, or failed in the commit; not an error of a statement."""
    return error.connection_invalidated or error.statement is None
