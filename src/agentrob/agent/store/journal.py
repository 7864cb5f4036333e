"""The agent's journal: which posts it claimed, whether their motion began, and the result of each.

Two things share one SQLite file. The rows (`claim`, `motion`, `meta`) are ours and decide whether anything may move.
The workflows are DBOS's: each assessment and each motion is one, with an id made of the post, so that what was finished
before a crash is not done again. Unfinished workflows are dropped at the start and begun again from the claim rows:
what must not be repeated is guarded by its own row, never by the engine.

    post-<id>            read the post, understand it, screen it
    post-<id>:motion     move; the motion row is written before, and the first insert wins

The final reply needs no workflow: before it is written again, the agent checks whether it is there.
"""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import socket
import sqlite3
import threading
import time
from collections.abc import Awaitable, Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import IO, TypeVar

from dbos import DBOS, DBOSConfig, DBOSPortableJSONSerializer, SetWorkflowID
from dbos import error as dbos_error
from pydantic import TypeAdapter
from sqlalchemy.exc import SQLAlchemyError

from agentrob.agent.store import rows as db
from agentrob.agent.store.engine_cleanup import forget_finished, forget_unfinished
from agentrob.agent.store.rows import COMMAND, DECIDED, ApprovalDecision, ApprovalRequest, Claim, MotionState, Rows
from agentrob.errors import JournalError
from agentrob.model import Command, CommandState, EndReason, Plan
from agentrob.model.lifecycle import check_transition

T = TypeVar("T")
Work = Callable[[], Awaitable[str]]

#: Increase it when stored workflows of the old version must not be taken for those of the new.
VERSION = "agentrob-1"
#: How many results are written at once.
KEEPING = 8
#: A claim is kept at least this long: a younger post must be recognized again (law 6).
AT_LEAST_S = 86400.0

_PLAN = TypeAdapter(Plan)


class _Ended(BaseException):
    """Ends a workflow's thread at shutdown without an outcome, so that the next start begins it anew."""


class NotBegun(_Ended):
    """Raised by a motion that has done nothing yet: it has not begun, and is left to the next start."""


class Journal(Rows):
    """Open with `await Journal.open(...)`; one per process and one per robot and data folder."""

    def __init__(self, folder: Path, robot: str) -> None:
        super().__init__(f"{robot}-journal")
        self._folder = folder
        self._robot = robot
        self._lock: IO[str] | None = None
        self._loop = asyncio.get_running_loop()
        # Apart, so that nothing that is kept holds up a motion; motions run one at a time.
        self._keeping = ThreadPoolExecutor(KEEPING, thread_name_prefix=f"{robot}-keeping")
        self._motions = ThreadPoolExecutor(2, thread_name_prefix=f"{robot}-motions")
        self._work: dict[str, Work] = {}
        self._ended = threading.Event()
        self._era = ""

    # ---------------------------------------------------------------- open and close
    @classmethod
    async def open(cls, folder: Path, robot: str) -> Journal:
        """Take the lock, make or read the file, start the engine. `JournalError` when that cannot be done."""
        journal = cls(folder, robot)
        try:
            await journal._in_rows(journal._open)
            await asyncio.get_running_loop().run_in_executor(journal._motions, journal._launch)
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
            # WAL must be set before the engine opens the file: three times the throughput of the default.
            self._db = sqlite3.connect(path, timeout=30.0, isolation_level=None)
            self._db.execute("PRAGMA journal_mode=wal")
            self._db.execute("PRAGMA synchronous=FULL")
            self._db.executescript(db.TABLES)
            db.migrate(self._db)
            self._era = (self._one("SELECT value FROM meta WHERE key = 'era'") or ("",))[0]
        except BlockingIOError:
            raise JournalError(
                f"an agent for {self._robot} already runs with {self._folder}; end it first, or use another data folder"
            ) from None
        except (OSError, sqlite3.Error) as e:
            raise JournalError(f"the journal {path} cannot be opened: {e}") from None

    def _launch(self) -> None:
        if _open:
            raise JournalError("this process already has an open journal; run one agent per process")
        url = f"sqlite:///{self._folder / 'journal.sqlite'}"
        config: DBOSConfig = {
            "name": "agentrob",
            "system_database_url": url,
            # A name of its own per machine and robot: the engine re-runs whatever bears the same one.
            "executor_id": f"{socket.gethostname()}-{self._robot}",
            "application_version": VERSION,
            "serializer": DBOSPortableJSONSerializer(),
            # Nothing of ours waits for notifications; this is only how long closing takes.
            "notification_listener_polling_interval_sec": 0.2,
            "log_level": "ERROR",
            "console_log_level": "ERROR",
        }
        try:
            forget_unfinished(url, self._has_workflows())
            DBOS(config=config)
            DBOS.launch()
        except Exception as e:
            raise JournalError(f"the journal's engine does not start: {e}") from e
        _open.append(self)

    def _has_workflows(self) -> bool:
        found = self._rows.submit(self._one, "SELECT 1 FROM sqlite_master WHERE name = 'workflow_status'").result()
        return found is not None

    async def close(self) -> None:
        """End the engine and leave running work unfinished. Calling again does nothing."""
        self._ended.set()
        if self in _open:
            _open.remove(self)
            await asyncio.to_thread(DBOS.destroy, workflow_completion_timeout_sec=0)
        if self._db is not None:
            await self._in_rows(self._db.close)
            self._db = None
        if self._lock is not None:
            self._lock.close()
            self._lock = None
        self._rows.shutdown(wait=False)
        self._keeping.shutdown(wait=False)
        self._motions.shutdown(wait=False)

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
            self._do("UPDATE claim SET final = ? WHERE post = ?", (final, post_id))

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
        """Delete claims that ended more than `days` ago, or more than a day ago and more than `commands` claims ago,
        and the engine's workflows of ended commands. Raises `JournalError`."""

        def rows() -> list[str]:
            now = time.time()
            with self._together():
                assert self._db is not None
                db.prune(self._db, now - days * 86400.0, commands, now - AT_LEAST_S)
            return [row[0] for row in self._all("SELECT post FROM claim WHERE final IS NULL")]

        open_posts = await self._in_rows(rows)
        needed = {f"{self._era}post-{post}{part}" for post in open_posts for part in ("", ":motion")}
        try:
            await self._loop.run_in_executor(self._keeping, forget_finished, needed)
        except (sqlite3.Error, SQLAlchemyError, dbos_error.DBOSException) as e:
            raise JournalError(f"old workflows cannot be dropped: {e}") from None

    async def history(self, topic_id: str, limit: int = 5) -> list[Plan]:
        """The plans that were done in a topic, oldest first."""
        query = (
            "SELECT plan FROM claim WHERE topic = ? AND plan NOT NULL AND coalesce(final, 'done') = 'done'"
            " ORDER BY number DESC LIMIT ?"
        )
        found = await self._in_rows(self._all, query, (topic_id, limit))
        return [_PLAN.validate_json(row[0]) for row in reversed(found)]

    # ---------------------------------------------------------------- workflows
    async def once(self, workflow_id: str, work: Work) -> str:
        """Do `work` and keep its result. The same id again, also after a restart, returns the kept result."""
        return await self._run(self._keeping, _keep, workflow_id, work)

    async def move(self, post_id: str, work: Work) -> str:
        """Do `work`, which moves a robot, at most once ever, and return its result, or the kept one.

        `CommandState.INTERRUPTED`: it had begun before, and its end is not known. `CommandState.CANCELLED`: it was
        cancelled before it began. Raises `IllegalTransition` for a command that may not run: one that waits for its
        approval, or whose end was told.
        """

        def may_begin() -> None:
            claim = self._claimed(post_id)
            if claim is not None and claim.motion is None:
                check_transition(claim.state, CommandState.RUNNING)

        await self._in_rows(may_begin)
        return await self._run(self._motions, _move, f"post-{post_id}:motion", work)

    async def _run(self, pool: ThreadPoolExecutor, workflow: Callable[[str], str], workflow_id: str, work: Work) -> str:
        workflow_id = self._era + workflow_id
        self._work[workflow_id] = work
        try:
            return await self._loop.run_in_executor(pool, partial(self._start, workflow, workflow_id))
        except asyncio.CancelledError:
            raise
        except _Ended:
            raise asyncio.CancelledError from None
        except (sqlite3.Error, SQLAlchemyError, dbos_error.DBOSException) as e:
            raise JournalError(f"the journal cannot be written: {e}") from None
        finally:
            self._work.pop(workflow_id, None)

    def _start(self, workflow: Callable[[str], str], workflow_id: str) -> str:
        if self._ended.is_set():
            raise _Ended
        with SetWorkflowID(workflow_id):
            return DBOS.start_workflow(workflow, workflow_id).get_result()

    def _perform(self, workflow_id: str) -> str:
        """Called in a workflow's thread: do the work on the agent's own loop, where its connections live."""
        work = self._work.get(workflow_id)
        if work is None or self._ended.is_set():
            raise NotBegun
        future = asyncio.run_coroutine_threadsafe(_awaited(work), self._loop)
        while True:
            try:
                return future.result(0.5)
            except TimeoutError:
                if self._ended.is_set():
                    future.cancel()
                    raise _Ended from None
            except NotBegun:
                raise
            except BaseException as e:
                if self._ended.is_set():
                    raise _Ended from None
                raise e

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
            era = f"before-{time.time_ns()}-"
            with self._together():
                for query in db.SET_ASIDE:
                    self._do(query, (era,))
            self._era = era

        await self._in_rows(rows)


# -------------------------------------------------------------------- the engine's side
#: The one open journal of this process: the engine is one per process too.
_open: list[Journal] = []


def _journal() -> Journal:
    if not _open:
        raise _Ended
    return _open[0]


@DBOS.workflow(name="keep")
def _keep(workflow_id: str) -> str:
    return _perform(workflow_id)


@DBOS.workflow(name="move")
def _move(workflow_id: str) -> str:
    return _perform_motion(workflow_id)


@DBOS.step(name="perform")
def _perform(workflow_id: str) -> str:
    return _journal()._perform(workflow_id)


@DBOS.step(name="perform_motion")
def _perform_motion(workflow_id: str) -> str:
    """Steps run at least once, motion at most once: between the two stands the motion row."""
    journal = _journal()
    post_id = workflow_id.partition("post-")[2].removesuffix(":motion")
    instead = journal._rows.submit(journal._begin, post_id).result()
    if instead is not None:
        return instead
    try:
        result = journal._perform(workflow_id)
    except NotBegun:
        with contextlib.suppress(Exception):  # closed already: then it counts as interrupted
            journal._rows.submit(journal._not_begun, post_id).result()
        raise
    journal._rows.submit(journal._end, post_id, result).result()
    return result


async def _awaited(work: Work) -> str:
    return await work()
