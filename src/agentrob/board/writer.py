"""One thread that does all writing: it takes what waits as one transaction, each job in a savepoint of its own.

So a burst costs one commit, a job that fails undoes only itself, and nobody ever waits for a lock on the event loop.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

import structlog
from sqlalchemy import Connection, Engine
from sqlalchemy.exc import DBAPIError

from agentrob.board.database import unavailable
from agentrob.errors import BoardError

T = TypeVar("T")
Job = Callable[["Transaction"], T]
#: More jobs than this are not taken into one transaction: the first of them waits for all.
MAX_BATCH = 64
#: More than this waiting means that the disk cannot follow; then the forum says so, but takes a stop (law 15).
MAX_WAITING = 2000

log = structlog.get_logger(__name__)


@dataclass(slots=True)
class Transaction:
    """What a job gets: the connection, and the list of the ids of event rows that it wrote."""

    connection: Connection
    event_ids: list[int] = field(default_factory=list)


@dataclass(slots=True)
class _Waiting:
    job: Job[Any]
    loop: asyncio.AbstractEventLoop
    future: asyncio.Future[Any]
    result: Any = None
    error: BaseException | None = None


class Writer:
    """`published` is called on the event loop with the ids of the events of each commit, in order."""

    def __init__(self, engine: Engine, published: Callable[[list[int]], None]) -> None:
        self.engine = engine
        self.published = published
        self._queue: SimpleQueue[_Waiting | None] = SimpleQueue()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="board-writer", daemon=True)
        self._thread.start()

    async def do(self, job: Job[T], exempt: Callable[[], bool] = lambda: False) -> T:
        """Run a job and wait for its commit. Raises what the job raised, or `BoardError` 503.

        `exempt` is asked when too much waits: a job that says True is taken all the same, in its turn.
        """
        if self._closed:
            raise BoardError(503, "closing", "the forum is shutting down", "try again in a moment", 2.0)
        if self._queue.qsize() > MAX_WAITING and not exempt():
            raise BoardError(503, "overloaded", "too many writes are waiting", "try again in a moment", 2.0)
        loop = asyncio.get_running_loop()
        waiting = _Waiting(job, loop, loop.create_future())
        self._queue.put(waiting)
        return await waiting.future  # type: ignore[no-any-return]

    def close(self) -> None:
        """Finish what waits, then end the thread."""
        if not self._closed:
            self._closed = True
            self._queue.put(None)
        self._thread.join()

    # ---------------------------------------------------------------- in the thread
    def _run(self) -> None:
        while (first := self._queue.get()) is not None:
            batch, last = self._take(first)
            try:
                event_ids = self._commit(batch)
            except Exception as e:  # the thread outlives whatever happens: the next batch may well succeed
                error = unavailable(e) if isinstance(e, DBAPIError) else e
                log.error("board.write_failed", error=str(e), jobs=len(batch))
                event_ids = []
                for waiting in batch:
                    waiting.error = waiting.error or error
            self._answer(batch, event_ids)
            if last:
                return

    def _take(self, first: _Waiting) -> tuple[list[_Waiting], bool]:
        """What waits now, and whether the thread shall end after it."""
        batch = [first]
        while len(batch) < MAX_BATCH:
            try:
                waiting = self._queue.get_nowait()
            except Empty:
                break
            if waiting is None:
                return batch, True
            batch.append(waiting)
        return batch, False

    def _commit(self, batch: list[_Waiting]) -> list[int]:
        event_ids: list[int] = []
        with self.engine.begin() as connection:
            for waiting in batch:
                transaction = Transaction(connection)
                savepoint = connection.begin_nested()
                try:
                    waiting.result = waiting.job(transaction)
                    savepoint.commit()
                    event_ids += transaction.event_ids
                except Exception as e:
                    # For some errors (a full disk) SQLite itself ends the transaction: then nothing of it is kept.
                    if not _in_transaction(connection):
                        raise
                    savepoint.rollback()
                    waiting.error = unavailable(e) if isinstance(e, DBAPIError) else e
        return event_ids

    def _answer(self, batch: list[_Waiting], event_ids: list[int]) -> None:
        def on_loop() -> None:
            if event_ids:
                self.published(event_ids)
            for waiting in batch:
                if waiting.future.done():
                    continue  # whoever asked is gone; what was written stays written
                if waiting.error is not None:
                    waiting.future.set_exception(waiting.error)
                else:
                    waiting.future.set_result(waiting.result)

        try:
            batch[0].loop.call_soon_threadsafe(on_loop)
        except RuntimeError:  # the loop has ended: nobody waits any more
            log.warning("board.nobody_waits", jobs=len(batch))


def _in_transaction(connection: Connection) -> bool:
    """Whether the database still is where we think it is."""
    raw: Any = connection.connection.dbapi_connection
    return bool(getattr(raw, "in_transaction", True))
