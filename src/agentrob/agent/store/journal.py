"""The agent's journal: which posts it claimed, whether their motion began, and the result of each.

One SQLite file. A claim row is written before anything about a post is written on the forum, and a motion row before
anything moves: its first insert wins, so that no restart moves a robot twice. The assessment of a post is kept until
its final reply is on the forum, so that a restart does not assess it again. The final reply needs no row: before the
agent writes it again, it checks whether the reply is there.
"""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import sqlite3
import time
from collections.abc import Awaitable, Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import IO

from pydantic import TypeAdapter

from agentrob.agent.store import rows as db
from agentrob.agent.store.rows import COMMAND, DECIDED, ApprovalDecision, ApprovalRequest, Claim, MotionState, Rows
from agentrob.errors import JournalError
from agentrob.model import Command, CommandState, EndReason, Plan
from agentrob.model.lifecycle import check_transition

Work = Callable[[], Awaitable[str]]

#: Increase it when an assessment that an older version kept must not be used by the new one.
VERSION = "agentrob-2"
#: A claim is kept at least this long: a younger post must be recognized again (law 6).
AT_LEAST_S = 86400.0

_PLAN = TypeAdapter(Plan)


class NotBegun(Exception):
    """Raised by a motion that has done nothing yet: it has not begun, and is left to the next start."""


class Journal(Rows):
    """Open with `await Journal.open(...)`; one per robot and data folder."""

    def __init__(self, folder: Path, robot: str) -> None:
        super().__init__(f"{robot}-journal")
        self._folder = folder
        self._robot = robot
        self._lock: IO[str] | None = None
        #: Motions from their row to their result, and the part of each that drives the robot.
        self._motions: set[asyncio.Task[str]] = set()
        self._driving: set[asyncio.Task[str]] = set()
        self._closing = False

    # ---------------------------------------------------------------- open and close
    @classmethod
    async def open(cls, folder: Path, robot: str) -> Journal:
        """Take the lock and open or create the file. Raises `JournalError`."""
        journal = cls(folder, robot)
        try:
            await journal._in_rows(journal._open)
        except BaseException:
            await journal.close()
            raise
        return journal

    def _open(self) -> None:
        path = self._folder / "journal.sqlite"
        try:
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._lock = (self._folder / "journal.lock").open("w")
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._db = sqlite3.connect(path, timeout=30.0, isolation_level=None)
            self._db.execute("PRAGMA journal_mode=wal")
            self._db.execute("PRAGMA synchronous=FULL")
            self._db.executescript(db.TABLES)
            with self._together():
                db.migrate(self._db, VERSION)
        except BlockingIOError:
            raise JournalError(
                f"an agent for {self._robot} already runs with {self._folder}; end it first, or use another data folder"
            ) from None
        except (OSError, sqlite3.Error) as e:
            raise JournalError(f"the journal {path} cannot be opened: {e}") from None

    async def close(self) -> None:
        """End running motions, without a result if they have begun. Calling again does nothing."""
        self._closing = True
        for work in self._driving:
            work.cancel()
        await asyncio.gather(*self._motions, return_exceptions=True)
        if self._db is not None:
            await self._in_rows(self._db.close)
            self._db = None
        if self._lock is not None:
            self._lock.close()
            self._lock = None
        self._rows.shutdown(wait=False)

    # ---------------------------------------------------------------- claims
    async def claim(self, command: Command, ended: EndReason | None = None) -> Claim:
        """Claim a post, before anything about it is written on the forum. Claiming it again changes nothing.

        `ended` is why it may never move; it is written together with the claim.
        """
        return await self._in_rows(self._claim, command, ended)

    def _claim(self, command: Command, ended: EndReason | None) -> Claim:
        before = self._claimed(command.post_id)
        if before is not None:
            return before
        kept = COMMAND.dump_json(command).decode()
        row = (command.post_id, command.topic_id, kept, db.boot(), db.boot_s(), time.time())
        with self._together():
            self._do("INSERT INTO claim (post, topic, command, boot, accepted_s, at) VALUES (?, ?, ?, ?, ?, ?)", row)
            if ended is not None:
                self._end_row(command.post_id, ended)
        return Claim(command, new=True, waited_s=0.0, ended=ended)

    def _claimed(self, post_id: str) -> Claim | None:
        found = self._one(f"{db.CLAIMS} WHERE claim.post = ?", (post_id,))
        return db.read_claim(found) if found else None

    async def claimed(self, post_id: str) -> Claim | None:
        return await self._in_rows(self._claimed, post_id)

    async def open_claims(self) -> Sequence[Claim]:
        """Claims without a final reply, oldest first."""
        found = await self._in_rows(self._all, f"{db.CLAIMS} WHERE final IS NULL ORDER BY number")
        return [db.read_claim(row) for row in found]

    async def newest_claim(self) -> Claim | None:
        """The newest claim whose status post is on the forum."""
        query = f"{db.CLAIMS} WHERE status_post NOT NULL ORDER BY number DESC LIMIT 1"
        found = await self._in_rows(self._one, query)
        return db.read_claim(found) if found else None

    async def end(self, post_ids: Sequence[str], why: EndReason) -> None:
        """Keep these commands from beginning to move, also after a restart. The first reason counts. A command that
        moves already is ended by its own task. No state forbids this: a stop is never refused."""

        def all_of_them() -> None:
            with self._together():
                for post_id in post_ids:
                    self._end_row(post_id, why)

        await self._in_rows(all_of_them)

    def _end_row(self, post_id: str, why: EndReason) -> None:
        self._do("UPDATE claim SET ended = ? WHERE post = ? AND ended IS NULL", (why, post_id))
        self._cancel(post_id)

    async def knows(self, post_id: str) -> bool:
        """Whether this post was ever claimed."""
        return await self._in_rows(self._one, "SELECT 1 FROM claim WHERE post = ?", (post_id,)) is not None

    async def set_status_post(self, post_id: str, status_post: str) -> None:
        """Record that the status post of a claim is on the forum."""
        await self._in_rows(self._do, "UPDATE claim SET status_post = ? WHERE post = ?", (status_post, post_id))

    async def set_plan(self, post_id: str, plan: Plan) -> None:
        """Record the plan of a command that is done."""
        kept = _PLAN.dump_json(plan).decode()
        await self._in_rows(self._do, "UPDATE claim SET plan = ? WHERE post = ?", (kept, post_id))

    async def finish(self, post_id: str, final: CommandState) -> None:
        """Record that the final reply of a claim is on the forum. `IllegalTransition` for a state that cannot be its
        end."""

        def rows() -> None:
            self._check(post_id, final)
            with self._together():
                self._do("UPDATE claim SET final = ? WHERE post = ?", (final, post_id))
                self._do("DELETE FROM assessment WHERE post = ?", (post_id,))

        await self._in_rows(rows)

    def _check(self, post_id: str, state: CommandState) -> None:
        """Raise `IllegalTransition` when a claimed command cannot enter this state."""
        if (claim := self._claimed(post_id)) is not None:
            check_transition(claim.state, state)

    async def ask(self, post_id: str, asked_at: datetime, until_at: datetime) -> ApprovalRequest:
        """Record that an approval is asked for, and return the request with what was decided since. The first
        request counts."""

        def rows() -> ApprovalRequest:
            claim = self._claimed(post_id)
            if claim is None:
                raise JournalError(f"post {post_id} was never claimed")
            if claim.asked is not None:
                return claim.asked
            check_transition(claim.state, CommandState.WAITING)
            self._do(db.ASK, (post_id, asked_at.isoformat(), until_at.isoformat()))
            return ApprovalRequest(asked_at, until_at)

        return await self._in_rows(rows)

    async def decide(self, post_id: str, decided: ApprovalDecision) -> bool:
        """Record an approval or a denial. The first decision counts, but an approved command can be denied until it
        moves.

        False if it came too late. A denied command may not begin to move any more.
        """

        def rows() -> bool:
            values = (DECIDED.dump_json(decided).decode(), decided.post_id, post_id, decided.approved)
            with self._together():
                counts = bool(self._do(db.DECIDE, values))
                if counts and not decided.approved:
                    self._end_row(post_id, EndReason.DENIED)
            return counts

        return await self._in_rows(rows)

    async def has_decision(self, post_id: str) -> bool:
        """Whether this post approved or denied something."""
        return await self._in_rows(self._one, "SELECT 1 FROM approval WHERE said_by = ?", (post_id,)) is not None

    async def prune(self, days: float, commands: int) -> None:
        """Delete claims that ended more than `days` ago, or more than a day ago and more than `commands` claims ago.
        Raises `JournalError`."""

        def rows() -> None:
            now = time.time()
            with self._together():
                assert self._db is not None
                db.prune(self._db, now - days * 86400.0, commands, now - AT_LEAST_S)

        await self._in_rows(rows)

    async def history(self, topic_id: str, limit: int = 5) -> list[Plan]:
        """The plans that were done in a topic, oldest first."""
        query = (
            "SELECT plan FROM claim WHERE topic = ? AND plan NOT NULL AND coalesce(final, 'done') = 'done'"
            " ORDER BY number DESC LIMIT ?"
        )
        found = await self._in_rows(self._all, query, (topic_id, limit))
        return [_PLAN.validate_json(row[0]) for row in reversed(found)]

    # ---------------------------------------------------------------- what is done once
    async def assess(self, post_id: str, work: Work) -> str:
        """Do `work` and keep its result until the final reply of the post is on the forum. The same post again, also
        after a restart, returns the kept result."""
        found = await self._in_rows(self._one, "SELECT result FROM assessment WHERE post = ?", (post_id,))
        if found is not None:
            return str(found[0])
        result = await work()
        query = "INSERT INTO assessment (post, result) VALUES (?, ?) ON CONFLICT DO NOTHING"
        await self._in_rows(self._do, query, (post_id, result))
        return result

    async def move(self, post_id: str, work: Work) -> str:
        """Do `work`, which moves a robot, at most once ever, and return its result, or the kept one.

        `CommandState.INTERRUPTED`: it had begun before, and its end is not known. `CommandState.CANCELLED`: it was
        cancelled before it began. Raises `IllegalTransition` for a command that may not run: one that waits for its
        approval, or whose end was told. A motion goes on when its caller is cancelled; only `close` ends it.
        """

        def may_begin() -> None:
            claim = self._claimed(post_id)
            if claim is not None and claim.motion is None:
                check_transition(claim.state, CommandState.RUNNING)

        await self._in_rows(may_begin)
        motion = asyncio.get_running_loop().create_task(self._moved(post_id, work))
        self._motions.add(motion)
        motion.add_done_callback(self._forget)
        return await asyncio.shield(motion)

    async def _moved(self, post_id: str, work: Work) -> str:
        instead = await self._in_rows(self._begin, post_id)
        if instead is not None:
            return instead
        try:
            if self._closing:
                raise NotBegun
            working = asyncio.ensure_future(work())
            self._driving.add(working)
            working.add_done_callback(self._driving.discard)
            result = await working
        except NotBegun:
            with contextlib.suppress(JournalError):  # then it counts as interrupted
                await self._in_rows(self._not_begun, post_id)
            raise asyncio.CancelledError from None
        await self._in_rows(self._end, post_id, result)
        return result

    def _forget(self, motion: asyncio.Task[str]) -> None:
        self._motions.discard(motion)
        if not motion.cancelled():
            motion.exception()  # its caller, if it still waits, is told

    # ---------------------------------------------------------------- motion rows
    def _begin(self, post_id: str) -> str | None:
        """None if the motion may begin now, and is on disk as begun; else the result to return instead."""
        if self._insert_motion(post_id, MotionState.BEGUN):
            return None
        state, result = self._one("SELECT state, result FROM motion WHERE post = ?", (post_id,)) or ("", None)
        if state == MotionState.ENDED and result is not None:
            return str(result)
        return CommandState.CANCELLED if state == MotionState.CANCELLED else CommandState.INTERRUPTED

    def _insert_motion(self, post_id: str, state: MotionState) -> bool:
        """False when the motion has a row already: the first one wins."""
        query = "INSERT INTO motion (post, state, at) VALUES (?, ?, ?) ON CONFLICT DO NOTHING"
        return bool(self._do(query, (post_id, state, time.time())))

    def _not_begun(self, post_id: str) -> None:
        self._do("DELETE FROM motion WHERE post = ? AND state = ?", (post_id, MotionState.BEGUN))

    def _end(self, post_id: str, result: str) -> None:
        self._do("UPDATE motion SET state = ?, result = ? WHERE post = ?", (MotionState.ENDED, result, post_id))

    async def cancel(self, post_id: str) -> bool:
        """Keep a motion from ever beginning. False if it has a row already: it has begun, or was cancelled before."""
        return await self._in_rows(self._cancel, post_id)

    def _cancel(self, post_id: str) -> bool:
        return self._insert_motion(post_id, MotionState.CANCELLED)

    async def moved(self, post_id: str, ended: bool = False) -> bool:
        """Whether a motion of this post ever began, or (`ended`) what came of it is kept."""
        found = await self._in_rows(self._one, "SELECT state FROM motion WHERE post = ?", (post_id,))
        if found is None:
            return False
        return bool(found[0] == MotionState.ENDED if ended else found[0] != MotionState.CANCELLED)

    async def kept(self, post_id: str) -> str | None:
        """The result of a motion that ended; None if it is not known."""
        query = "SELECT result FROM motion WHERE post = ? AND state = ?"
        found = await self._in_rows(self._one, query, (post_id, MotionState.ENDED))
        return None if found is None or found[0] is None else str(found[0])

    async def set_aside(self) -> None:
        """Forget the posts of a forum that was replaced, since its ids mean other posts now: open claims end."""

        def rows() -> None:
            mark = f"before-{time.time_ns()}-"
            with self._together():
                for query in db.SET_ASIDE:
                    self._do(query, (mark,))
                self._do("DELETE FROM assessment")

        await self._in_rows(rows)
