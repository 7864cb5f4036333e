"""Run all writes on one thread, in batches: one transaction per batch, one savepoint per job.

A burst of writes costs one commit, a failing job rolls back only itself, and the event loop never waits for a lock.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import structlog
from sqlalchemy import Connection, Engine
from sqlalchemy.exc import DBAPIError

from agentrob.board.db.database import unavailable
from agentrob.errors import BoardError

T = TypeVar("T")
Job = Callable[["Transaction"], T]
#: The largest number of jobs in a transaction, and the seconds after which it takes no more, since the first job waits
#: for
#: all.
MAX_BATCH, MAX_BATCH_S = 64, 0.02
#: With more waiting jobs than this the disk is too slow: the forum refuses all writes but stops (law 15).
MAX_WAITING = 2000

log = structlog.get_logger(__name__)


@dataclass(slots=True)
class Transaction:
    """The argument of a job: the connection, and the ids of the event rows that it wrote."""

    connection: Connection
    event_ids: list[int] = field(default_factory=list)


@dataclass(slots=True)
class _Waiting:
    """A waiting job; `job` is None for a proof that jobs are run."""

    job: Job[Any] | None
    first: bool
    loop: asyncio.AbstractEventLoop
    future: asyncio.Future[Any]
    result: Any = None
    error: BaseException | None = None


class Writer:
    """`published` is called on the event loop with the ids of the events of each commit, in order.

    Jobs that come `first`, as stops do, wait only for the one that runs, and are committed at once.
    """

    def __init__(self, engine: Engine, published: Callable[[list[int]], None]) -> None:
        self.engine = engine
        self.published = published
        self._more = threading.Condition()
        self._first: deque[_Waiting] = deque()
        self._rest: deque[_Waiting] = deque()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="board-writer", daemon=True)
        self._thread.start()

    async def do(self, job: Job[T], first: bool = False) -> T:
        """Run a job and wait for its commit. Raises what the job raised, or `BoardError` 503: when too much waits,
        unless it comes `first`."""
        return await self._wait(job, first)  # type: ignore[no-any-return]

    async def prove(self) -> None:
        """Pass through the queue like a job that comes first, without writing. Raises `BoardError` as `do`."""
        await self._wait(None, first=True)

    async def _wait(self, job: Job[Any] | None, first: bool) -> Any:
        if len(self._rest) > MAX_WAITING and not first:
            raise BoardError(503, "overloaded", "too many writes are waiting", "try again in a moment", 2.0)
        loop = asyncio.get_running_loop()
        waiting = _Waiting(job, first, loop, loop.create_future())
        with self._more:
            if self._closed:
                raise BoardError(503, "closing", "the forum is shutting down", "try again in a moment", 2.0)
            (self._first if first else self._rest).append(waiting)
            self._more.notify()
        return await waiting.future

    def close(self) -> None:
        """Finish the waiting jobs, then end the thread."""
        with self._more:
            self._closed = True
            self._more.notify()
        self._thread.join()

    # ---------------------------------------------------------------- in the thread
    def _run(self) -> None:
        while self._something_waits():
            batch: list[_Waiting] = []
            try:
                event_ids = self._commit(batch)
            except Exception as e:  # the thread must survive any error: the next batch may well succeed
                error = unavailable(e) if isinstance(e, DBAPIError) else e
                batch = batch or self._all_waiting()
                log.error("board.write_failed", error=str(e), jobs=len(batch))
                event_ids = []
                for waiting in batch:
                    waiting.error = waiting.error or error
            self._answer(batch, event_ids)

    def _something_waits(self) -> bool:
        """Wait for a job; False if the writer is closed and nothing is left."""
        with self._more:
            self._more.wait_for(lambda: self._first or self._rest or self._closed)
            return bool(self._first or self._rest)

    def _all_waiting(self) -> list[_Waiting]:
        """Take all waiting jobs, when no transaction can be started."""
        taken: list[_Waiting] = []
        while len(taken) < MAX_BATCH and (self._first or self._rest):
            taken.append((self._first or self._rest).popleft())
        return taken

    def _commit(self, batch: list[_Waiting]) -> list[int]:
        """Run waiting jobs as one transaction, adding them to `batch`; return the ids of its events."""
        event_ids: list[int] = []
        with self.engine.connect() as connection:
            whole = connection.begin()
            until_s = time.monotonic() + MAX_BATCH_S
            while (waiting := self._next(batch, until_s)) is not None:
                batch.append(waiting)
                event_ids += self._run_one(waiting, connection)
            if any(waiting.job for waiting in batch):
                whole.commit()
            else:
                whole.rollback()  # other processes need not be notified
        return event_ids

    def _next(self, batch: list[_Waiting], until_s: float) -> _Waiting | None:
        """The next job of this transaction; None to commit it."""
        if self._first:
            return self._first.popleft()
        enough = len(batch) >= MAX_BATCH or time.monotonic() > until_s or any(waiting.first for waiting in batch)
        return self._rest.popleft() if self._rest and not (batch and enough) else None

    def _run_one(self, waiting: _Waiting, connection: Connection) -> list[int]:
        """Run one job in a savepoint; return the ids of its events."""
        if waiting.job is None:
            return []
        transaction = Transaction(connection)
        savepoint = connection.begin_nested()
        try:
            waiting.result = waiting.job(transaction)
            savepoint.commit()
        except Exception as e:
            # For some errors (a full disk) SQLite itself ends the transaction: then nothing of it is kept.
            if not _in_transaction(connection):
                raise
            savepoint.rollback()
            waiting.error = unavailable(e) if isinstance(e, DBAPIError) else e
            return []
        return transaction.event_ids

    def _answer(self, batch: list[_Waiting], event_ids: list[int]) -> None:
        def on_loop() -> None:
            if event_ids:
                self.published(event_ids)
            for waiting in batch:
                if waiting.future.done():
                    continue  # the caller was cancelled; the write stays
                if waiting.error is not None:
                    waiting.future.set_exception(waiting.error)
                else:
                    waiting.future.set_result(waiting.result)

        try:
            batch[0].loop.call_soon_threadsafe(on_loop)
        except RuntimeError:  # the loop has ended: nobody waits anymore
            log.warning("board.nobody_waits", jobs=len(batch))


def _in_transaction(connection: Connection) -> bool:
    """Whether the database is still in our transaction."""
    raw: Any = connection.connection.dbapi_connection
    return bool(getattr(raw, "in_transaction", True))
