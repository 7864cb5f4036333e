"""Deliver events to all listeners of this process.

Each event is read and encoded once for all listeners. A listener that falls behind is disconnected and resumes after
the last id it received; events are never dropped from the middle of a stream.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass

import structlog

from agentrob.board.db.reader import BEFORE_ALL, Reader, event_number
from agentrob.board.db.records import Board, StoredEvent
from agentrob.errors import BoardError
from agentrob.model import Role

#: A listener with more pending events than this does not read, and is closed.
MAX_PENDING = 1000
MAX_LISTENERS = 2000
#: A limit for each account, so that robots' agents always get the stream that they need to receive a stop.
MAX_PER_ACCOUNT = 50
MAX_ANONYMOUS = MAX_LISTENERS // 2
#: Seconds between two checks for events of other processes: on SQLite, where a check takes microseconds, and elsewhere.
FOLLOW_S, FOLLOW_ELSEWHERE_S = 0.02, 0.1
#: A heartbeat is sent only if, within these seconds, a write went through and, on PostgreSQL, other processes were
#: heard.
PROVEN_S = 1.0
#: Seconds between two proofs that a stop in a post would be written.
PROOF_S = 0.2

log = structlog.get_logger(__name__)


@dataclass(frozen=True, slots=True)
class EncodedEvent:
    """An event, its number, and its encodings for everybody and for the author of its post.

    `written`: whether it is in the database.
    """

    event: StoredEvent
    number: int
    frame: bytes
    frame_for_author: bytes
    written: bool = True

    @property
    def topic_id(self) -> str | None:
        return self.event.post.topic_id if self.event.post else None


class Listener:
    """The queue of one open stream of an account (None: not signed in), for one topic or all.

    `ended` is set when the stream must end: it was closed, or its queue overflowed because its client does not read.
    It receives the posts of the boards that its `role` may read when they are written; None means every board, for the
    server's own listeners only.
    """

    def __init__(
        self, topic_id: str | None = None, account_id: str | None = None, role: Role | None = Role.GUEST
    ) -> None:
        self.topic_id, self.account_id, self.role = topic_id, account_id, role
        self.ended = asyncio.Event()
        self._pending: deque[EncodedEvent] = deque()
        self._waiter: asyncio.Future[None] | None = None

    @property
    def closed(self) -> bool:
        return self.ended.is_set()

    def may_read(self, board: Board | None) -> bool:
        """Whether it receives the posts of a board; None is one that is not known."""
        return self.role is None or (board is not None and self.role.rank >= board.read_role.rank)

    def offer(self, encoded: EncodedEvent, board: Board | None) -> None:
        """Queue an event, if it is for this listener. `board` is that of its post."""
        if self.closed or self.topic_id not in (None, encoded.topic_id):
            return
        if encoded.event.post is not None and not self.may_read(board):
            return
        self._pending.append(encoded)
        if len(self._pending) > MAX_PENDING:
            self.close()
        self._wake()

    def close(self) -> None:
        self._pending.clear()
        self.ended.set()
        self._wake()

    async def next(self, timeout_s: float) -> EncodedEvent | None:
        """The next event, or None when there was none in time or the stream is closed."""
        if not self._pending and not self.closed:
            loop = asyncio.get_running_loop()
            self._waiter = loop.create_future()
            timer = loop.call_later(timeout_s, self._wake)
            try:
                await self._waiter
            finally:
                timer.cancel()
                self._waiter = None
        return self._pending.popleft() if self._pending else None

    def _wake(self) -> None:
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)


class Hub:
    """All listeners of this process. Use it on the event loop only."""

    def __init__(self, encode: Callable[[StoredEvent, bool], EncodedEvent]) -> None:
        """`encode` encodes an event; its second argument is whether the event is in the database."""
        self.encode = encode
        self.closed = False
        self.reader: Reader | None = None
        self._listeners: set[Listener] = set()
        self._boards: tuple[Board, ...] = ()
        self._last, self._last_id = 0, BEFORE_ALL
        self._proven_s: float | None = None
        self._written_s: float | None = None
        #: Sends to other processes an event that could not be written.
        self.announce_elsewhere: Callable[[StoredEvent], None] = lambda event: None
        #: Counts an event that is delivered here.
        self.count: Callable[[StoredEvent], None] = lambda event: None

    def start(self, reader: Reader) -> None:
        """Start after the newest event."""
        self.reader = reader
        self._last_id = reader.newest_event_id()
        self._last = event_number(self._last_id)

    def close(self) -> None:
        """End all streams now, so that the server can end."""
        self.closed = True
        self._cut_off()

    def published(self, event_ids: list[int]) -> None:
        """Deliver the events up to these. Called by the writer after each commit."""
        self._catch_up(event_ids[-1])

    async def follow(self) -> None:
        """Deliver the events that other processes write, such as the command line; until cancelled."""
        assert self.reader is not None
        seen, well = None, True
        while not self.closed:
            await asyncio.sleep(FOLLOW_S if seen is not None else FOLLOW_ELSEWHERE_S)
            version = self.reader.version()
            if version is not None and version == seen:
                continue
            try:
                self._catch_up(event_number(self.reader.newest_event_id()))
                seen, well = version, True
            except BoardError as e:  # the database may come back, for example after a restart
                if well:
                    log.error("board.events_unreadable", error=str(e))
                seen, well = None, False

    def proven(self, newest: int) -> None:
        """Record that other processes are heard; `newest` is the newest event that the database just reported."""
        if newest < self._last:
            self._look_back()
        if self._catch_up(newest):
            self._proven_s = time.monotonic()

    def _look_back(self) -> None:
        """Check whether the database was restored from a backup; then end all streams, so that clients learn of it."""
        assert self.reader is not None
        newest_id = self.reader.newest_event_id()
        if event_number(newest_id) < self._last:
            log.error("board.other_history", newest=newest_id, known=self._last_id)
            self._last, self._last_id = event_number(newest_id), newest_id
            self._cut_off()

    async def prove_writing(self, prove: Callable[[], Awaitable[None]]) -> None:
        """Prove again and again, until cancelled, that a stop in a post would be written: from this loop through the
        writer and back (`prove`). Each proof counts from when it was due, so that a blocked event loop proves
        nothing."""
        self._written_s, well = time.monotonic(), True
        while not self.closed:
            due_s = time.monotonic() + PROOF_S
            await asyncio.sleep(PROOF_S)
            try:
                await prove()
                self._written_s, well = due_s, True
            except Exception as e:  # the task must survive any error: the next try may well succeed
                if well:
                    log.error("board.stops_not_written", error=str(e))
                well = False

    @property
    def delivers_stops(self) -> bool:
        """Whether a stop on any process, by the button or in a post, is delivered here within a second. Without that no
        heartbeat is sent, and after 2 s of silence robots stop by themselves (law 16)."""
        since_s = time.monotonic() - PROVEN_S
        return all(proven_s is None or proven_s > since_s for proven_s in (self._proven_s, self._written_s))

    def _catch_up(self, newest: int) -> bool:
        assert self.reader is not None
        try:
            while self._last < newest and (events := self.reader.events(self._last, 100)):
                for event in events:
                    self._deliver(event)
                    self._last, self._last_id = event_number(event.id), event.id
        except BoardError as e:
            # Every listener must get every event: end all streams, and clients resume.
            log.error("board.events_unreadable", error=str(e))
            self._cut_off()
            return False
        return True

    def _cut_off(self) -> None:
        for listener in list(self._listeners):
            listener.close()

    def announce(self, event: StoredEvent) -> None:
        """Deliver an event that could not be written, since a stop must always get through.

        Its id is that of the newest written event, so that resuming after it misses nothing.
        """
        self._deliver(event, written=False)
        self.announce_elsewhere(event)

    def receive_unwritten(self, event: StoredEvent) -> None:
        """Deliver an event that another process could not write."""
        self._deliver(event, written=False)

    def listen(
        self, topic_id: str | None = None, account_id: str | None = None, role: Role | None = Role.GUEST
    ) -> Listener:
        """Open a listener; close it with `leave`. 503 if there are too many, 429 if this account has too many."""
        if self.closed or len(self._listeners) >= MAX_LISTENERS:
            raise BoardError(503, "no_more_streams", "too many event streams are open", "poll /api/v1/changes", 5.0)
        most = MAX_ANONYMOUS if account_id is None else MAX_PER_ACCOUNT
        if sum(other.account_id == account_id for other in self._listeners) >= most:
            who = "visitors who are not signed in have" if account_id is None else "this account has"
            hint = f"at most {most}: close one, or poll /api/v1/changes"
            raise BoardError(429, "too_many_streams", f"{who} too many event streams open", hint, 5.0)
        listener = Listener(topic_id, account_id, role)
        self._listeners.add(listener)
        return listener

    def leave(self, listener: Listener) -> None:
        self._listeners.discard(listener)

    @property
    def listeners(self) -> int:
        return len(self._listeners)

    @property
    def last_id(self) -> str:
        """The id of the newest event that was delivered."""
        return self._last_id

    def boards_of(self, listener: Listener) -> frozenset[str] | None:
        """The boards whose posts a listener receives now; None for all."""
        if listener.role is None:
            return None
        return frozenset(board.id for board in self._current_boards() if listener.may_read(board))

    def _current_boards(self) -> tuple[Board, ...]:
        """All boards, as they are now; as they were when the database could be read last."""
        if self.reader is not None:
            with suppress(BoardError):
                self._boards = self.reader.all_boards()
        return self._boards

    def _deliver(self, event: StoredEvent, written: bool = True) -> None:
        encoded, post = self.encode(event, written), event.post
        boards = self._current_boards() if post is not None else ()
        board = next((board for board in boards if post is not None and board.id == post.board_id), None)
        for listener in self._listeners:
            listener.offer(encoded, board)
        self.count(event)
