"""The agent's journal: which posts it claimed, whether their motion began, and the result of each.

A claim row is written before anything about a post is written on the forum, and a motion row before anything moves: its
first insert wins, so that no restart moves a robot twice. The assessment of a post is kept until its final reply is on
the forum, so that a restart does not assess it again. The final reply needs no row: before the agent writes it again,
it checks whether the reply is there.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any

from pydantic import TypeAdapter
from sqlalchemy import Connection, Executable, Row

from agentrob.agent.store import queries, rows
from agentrob.agent.store.queries import insert_new, put
from agentrob.agent.store.rows import (
    COMMAND,
    DECIDED,
    SCHEDULED,
    ApprovalDecision,
    ApprovalRequest,
    Claim,
    KeptPreview,
    KeptSchedule,
    MotionState,
    PartWait,
    ScheduledCommand,
    read_claim,
    read_schedule,
    read_wait,
)
from agentrob.agent.store.schema import APPROVAL, ASSESSMENT, CLAIM, JOINT, MOTION, PREVIEW, SCHEDULE
from agentrob.agent.store.transactions import Transactions
from agentrob.errors import JournalError
from agentrob.model import Command, CommandState, EndReason, FencingToken, Plan, ScheduleEnd
from agentrob.model.lifecycle import check_transition

Work = Callable[[], Awaitable[str]]

#: Increase it when an assessment that an older version kept must not be used by the new one.
VERSION = "agentrob-2"
#: A claim is kept at least this long: a younger post must be recognized again (law 6).
AT_LEAST_S = 86400.0

_PLAN = TypeAdapter(Plan)


class NotBegun(Exception):
    """Raised by a motion that has done nothing yet: it has not begun, and is left to the next start."""


class Journal:
    """The journal of one robot, which this process holds until `close`. `Journals.open` makes it."""

    def __init__(self, rows: Transactions, release: Callable[[], Awaitable[None]]) -> None:
        self._rows, self._release = rows, release
        self._robot = rows.lock.robot
        #: Motions from their row to their result, and the part of each that drives the robot.
        self._motions: set[asyncio.Task[str]] = set()
        self._driving: set[asyncio.Task[str]] = set()
        self._closing = False

    # ---------------------------------------------------------------- hold and close
    @property
    def fence(self) -> FencingToken | None:
        """The number by which the driver tells this holder from earlier ones; None if only this machine can hold it."""
        return self._rows.lock.fence

    async def until_lost(self) -> None:
        """Return when this process no longer holds the robot, so that another may; never with SQLite."""
        await self._rows.lock.lost.wait()

    async def begin(self) -> None:
        """Delete assessments of another version."""

        def work(db: Connection) -> None:
            if db.execute(queries.VALUE, self._this("version")).scalar() != VERSION:
                db.execute(queries.FORGET_ASSESSMENTS, self._this())
                put(db, self._robot, version=VERSION)

        await self._rows.write(work)

    async def close(self) -> None:
        """End running motions, without a result if they have begun. Calling again does nothing."""
        self._closing = True
        for work in self._driving:
            work.cancel()
        if self._motions:
            await asyncio.wait(self._motions, timeout=self._rows.patience_s)
        if not self._rows.closed:
            await self._rows.close()
            await self._release()

    def _this(self, key: str = "", **values: Any) -> dict[str, Any]:
        """The parameters of a query."""
        return {"this_robot": self._robot, "this_key": key, **values}

    async def _first(self, query: Executable, key: str = "") -> Row[Any] | None:
        return await self._rows.read(lambda db: db.execute(query, self._this(key)).first())

    async def _do(self, query: Executable, key: str, **values: Any) -> None:
        await self._rows.write(lambda db: db.execute(query, self._this(key, **values)))

    # ---------------------------------------------------------------- claims
    async def claim(self, command: Command, ended: EndReason | None = None) -> Claim:
        """Claim a post, before anything about it is written on the forum. Claiming it again changes nothing.

        `ended` is why it may never move; it is written together with the claim.
        """
        return await self._rows.write(lambda db: self._claim_row(db, command, ended), begins=True)

    def _claim_row(self, db: Connection, command: Command, ended: EndReason | None) -> Claim:
        before = self._claim(db, command.key)
        if before is not None:
            return before
        insert_new(
            db, CLAIM, robot=self._robot, post=command.key, topic=command.topic_id,
            command=COMMAND.dump_json(command).decode(), boot=rows.boot(), accepted_s=rows.boot_s(),
        )  # fmt: skip
        if ended is not None:
            self._end_row(db, command.key, ended)
        return Claim(command, new=True, waited_s=0.0, ended=ended)

    def _claim(self, db: Connection, post_id: str) -> Claim | None:
        found = db.execute(queries.THIS_CLAIM, self._this(post_id)).first()
        return self._read(found) if found else None

    def _read(self, row: Row[Any]) -> Claim:
        return read_claim(row, shared=self.fence is not None)

    async def claimed(self, post_id: str) -> Claim | None:
        return await self._rows.read(lambda db: self._claim(db, post_id))

    async def open_claims(self) -> Sequence[Claim]:
        """Claims without a final reply, oldest first."""
        found = await self._rows.read(lambda db: db.execute(queries.OPEN_CLAIMS, self._this()).all())
        return [self._read(row) for row in found]

    async def newest_claim(self) -> Claim | None:
        """The newest claim whose status post is on the forum."""
        found = await self._first(queries.NEWEST_CLAIM)
        return self._read(found) if found else None

    async def end(self, post_ids: Sequence[str], why: EndReason) -> None:
        """Keep these commands from beginning to move, also after a restart. The first reason counts. A command that
        moves already is ended by its own task. No state forbids this: a stop is never refused."""

        def work(db: Connection) -> None:
            for post_id in post_ids:
                self._end_row(db, post_id, why)

        await self._rows.write(work)

    def _end_row(self, db: Connection, post_id: str, why: EndReason) -> None:
        db.execute(queries.END_CLAIM, self._this(post_id, ended=str(why)))
        self._insert_motion(db, post_id, MotionState.CANCELLED)

    async def knows(self, post_id: str) -> bool:
        """Whether this post was ever claimed."""
        return await self._first(queries.KNOWN, post_id) is not None

    async def set_status_post(self, post_id: str, status_post: str) -> None:
        """Record that the status post of a claim is on the forum."""
        await self._do(queries.SET_CLAIM, post_id, status_post=status_post)

    async def set_plan(self, post_id: str, plan: Plan) -> None:
        """Record the plan of a command that is done."""
        await self._do(queries.SET_CLAIM, post_id, plan=_PLAN.dump_json(plan).decode())

    async def finish(self, post_id: str, final: CommandState) -> None:
        """Record that the final reply of a claim is on the forum. `IllegalTransition` for a state that cannot be its
        end."""

        def work(db: Connection) -> None:
            if (claim := self._claim(db, post_id)) is not None:
                check_transition(claim.state, final)
            db.execute(queries.SET_CLAIM, self._this(post_id, final=str(final)))
            db.execute(queries.FORGET_ASSESSMENT, self._this(post_id))
            db.execute(queries.FORGET_PREVIEW, self._this(post_id))

        await self._rows.write(work)

    async def ask(self, post_id: str, asked_at: datetime, until_at: datetime) -> ApprovalRequest:
        """Record that an approval is asked for, and return the request with what was decided since. The first
        request counts."""
        row = {
            "robot": self._robot, "post": post_id, "asked_at": asked_at.isoformat(), "until_at": until_at.isoformat()
        }  # fmt: skip

        def work(db: Connection) -> ApprovalRequest:
            claim = self._claim(db, post_id)
            if claim is None:
                raise JournalError(f"post {post_id} was never claimed")
            if claim.asked is not None:
                return claim.asked
            check_transition(claim.state, CommandState.WAITING)
            insert_new(db, APPROVAL, **row)
            return ApprovalRequest(asked_at, until_at)

        return await self._rows.write(work)

    async def decide(self, post_id: str, decided: ApprovalDecision) -> bool:
        """Record an approval or a denial. The first decision counts, but an approved command can be denied until it
        moves.

        False if it came too late. A denied command may not begin to move any more.
        """
        values = self._this(post_id, said=DECIDED.dump_json(decided).decode(), said_by=decided.post_id)
        query = queries.APPROVE if decided.approved else queries.DENY

        def work(db: Connection) -> bool:
            counts = bool(db.execute(query, values).rowcount)
            if counts and not decided.approved:
                self._end_row(db, post_id, EndReason.DENIED)
            return counts

        return await self._rows.write(work)

    async def keep_preview(self, key: str, data: str) -> None:
        """Keep the preview of a command before it is shown, instead of an earlier one, until the final reply."""

        def work(db: Connection) -> None:
            db.execute(queries.FORGET_PREVIEW, self._this(key))
            insert_new(db, PREVIEW, robot=self._robot, post=key, data=data, pictures=0)

        await self._rows.write(work)

    async def set_preview_shown(self, key: str, at: datetime, pictures: int) -> None:
        """Record since when a preview is beside its question, and with how many pictures."""
        await self._do(queries.SET_PREVIEW, key, shown_at=at.isoformat(), pictures=pictures)

    async def preview(self, key: str) -> KeptPreview | None:
        """Return the preview of a command that waits for its approval or has got it, if there is one."""
        found = await self._first(queries.THIS_PREVIEW, key)
        if found is None:
            return None
        at = datetime.fromisoformat(found.shown_at) if found.shown_at is not None else None
        return KeptPreview(str(found.data), at, int(found.pictures))

    async def has_decision(self, post_id: str) -> bool:
        """Whether this post approved or denied something."""
        return await self._first(queries.DECIDED_BY, post_id) is not None

    # ---------------------------------------------------------------- schedules
    async def add_schedule(self, asked: ScheduledCommand, next_at: datetime) -> KeptSchedule:
        """Keep a schedule whose first run is at `next_at`. Its own post never moves anything. The first one counts."""
        row = {
            "robot": self._robot, "post": asked.command.post_id, "data": SCHEDULED.dump_json(asked).decode(),
            "next_at": next_at.isoformat(), "runs_left": asked.schedule.runs_left, "told": 0,
        }  # fmt: skip

        def work(db: Connection) -> KeptSchedule:
            insert_new(db, SCHEDULE, **row)
            self._insert_motion(db, asked.command.post_id, MotionState.CANCELLED)
            return read_schedule(db.execute(queries.THIS_SCHEDULE, self._this(asked.command.post_id)).one())

        return await self._rows.write(work, begins=True)

    async def schedule(self, post_id: str) -> KeptSchedule | None:
        found = await self._first(queries.THIS_SCHEDULE, post_id)
        return read_schedule(found) if found else None

    async def schedules(self) -> Sequence[KeptSchedule]:
        """Those with further runs, and those whose end must still be reported; the next run first."""
        found = await self._rows.read(lambda db: db.execute(queries.SCHEDULES, self._this()).all())
        return [read_schedule(row) for row in found]

    async def begin_run(
        self, kept: KeptSchedule, command: Command, ended: EndReason | None, after: KeptSchedule
    ) -> Claim | None:
        """Claim the next run of a schedule and set the schedule to `after`, both or neither (law 6). `ended` is why the
        run may not move. None if the run is not the next one any more."""
        values = self._this(
            kept.post_id, was_next=kept.next_at.isoformat() if kept.next_at else "", runs_left=after.runs_left,
            next_at=after.next_at.isoformat() if after.next_at else None,
            ended=str(after.ended) if after.ended else None, told=int(after.reported),
        )  # fmt: skip

        def work(db: Connection) -> Claim | None:
            if not db.execute(queries.ADVANCE_SCHEDULE, values).rowcount:
                return None
            return self._claim_row(db, command, ended)

        return await self._rows.write(work, begins=True)

    async def move_schedule(self, post_id: str, topic_id: str) -> KeptSchedule:
        """Record that the post of a schedule is in another thread now, and return the schedule."""

        def work(db: Connection) -> KeptSchedule:
            kept = read_schedule(db.execute(queries.THIS_SCHEDULE, self._this(post_id)).one())
            asked = replace(kept.asked, command=replace(kept.asked.command, topic_id=topic_id))
            db.execute(queries.SET_SCHEDULE, self._this(post_id, data=SCHEDULED.dump_json(asked).decode()))
            return replace(kept, asked=asked)

        return await self._rows.write(work)

    async def end_schedule(self, post_id: str, why: ScheduleEnd, *, reported: bool = False) -> None:
        """End a schedule, if there is one; the first reason counts. `reported`: it needs no report."""
        await self._do(queries.END_SCHEDULE, post_id, ended=str(why), next_at=None, told=int(reported))

    async def renewable_schedules(self) -> Sequence[KeptSchedule]:
        """Those that ended by the limit of runs or days."""
        found = await self._rows.read(lambda db: db.execute(queries.RENEWABLE_SCHEDULES, self._this()).all())
        return [read_schedule(row) for row in found]

    async def renew_schedule(self, renewed: KeptSchedule) -> bool:
        """Continue a schedule that ended by the limit of runs or days. Returns False, and changes nothing, if it did
        not end so."""
        values = self._this(
            renewed.post_id, data=SCHEDULED.dump_json(renewed.asked).decode(), runs_left=renewed.runs_left,
            next_at=renewed.next_at.isoformat() if renewed.next_at else None, ended=None, told=0,
        )  # fmt: skip
        return await self._rows.write(lambda db: bool(db.execute(queries.SET_RENEWABLE, values).rowcount), begins=True)

    async def refuse_renewal(self, post_id: str, why: ScheduleEnd) -> None:
        """Forbid the renewal of a schedule that ended by the limit of runs or days."""
        await self._do(queries.SET_RENEWABLE, post_id, ended=str(why), told=1)

    async def set_schedule_reported(self, post_id: str) -> None:
        """Record that the end of a schedule was reported, unless it was renewed meanwhile."""
        await self._do(queries.SET_ENDED, post_id, told=1)

    # ---------------------------------------------------------------- parts of posts to several robots
    async def begin_wait(self, key: str, at: datetime) -> PartWait:
        """Record that a part waits for others, and return its wait; the first one counts, also after a restart."""

        def work(db: Connection) -> PartWait:
            insert_new(db, JOINT, robot=self._robot, post=key, told=1)
            db.execute(queries.BEGIN_WAIT, self._this(key, waits_since=at.isoformat()))
            wait = read_wait(*db.execute(queries.THIS_WAIT, self._this(key)).one())
            assert wait is not None
            return wait

        return await self._rows.write(work)

    async def end_wait(self, key: str, at: datetime) -> None:
        """Record when the wait of a part ended; the first end counts."""
        await self._do(queries.END_WAIT, key, released_at=at.isoformat())

    async def add_summary(self, command: Command) -> None:
        """Record that this robot sums up the post of a command once all parts have ended. The first one counts."""
        row = {"summary": COMMAND.dump_json(command).decode(), "told": 0}

        def work(db: Connection) -> None:
            if not insert_new(db, JOINT, robot=self._robot, post=command.key, **row):
                db.execute(queries.SET_SUMMARY, self._this(command.key, **row))

        await self._rows.write(work)

    async def summaries(self) -> Sequence[Command]:
        """The commands whose posts this robot has still to sum up."""
        found = await self._rows.read(lambda db: db.execute(queries.SUMMARIES, self._this()).all())
        return [COMMAND.validate_json(row.summary) for row in found]

    async def set_summary_reported(self, key: str) -> None:
        await self._do(queries.SET_JOINT, key, told=1)

    async def prune(self, days: float, commands: int) -> None:
        """Delete claims that ended more than `days` ago, or more than a day ago and more than `commands` claims ago.
        Open claims are kept. Raises `JournalError`.

        A post whose claim is deleted could be claimed again if the forum delivered it again. It still moves nothing
        (law 6): it is at least a day old, and a post moves something only within minutes (law 5). Its claim on the
        forum stays.
        """
        limits = self._this(age_s=days * 86400.0, least_s=AT_LEAST_S, commands=commands)
        await self._rows.write(lambda db: [db.execute(query, limits) for query in queries.PRUNE])

    async def history(self, topic_id: str, limit: int = 5) -> list[Plan]:
        """The plans that were done in a topic, oldest first."""
        wanted = self._this(topic_id, limit=limit)
        found = await self._rows.read(lambda db: db.execute(queries.PLANS, wanted).all())
        return [_PLAN.validate_json(row.plan) for row in reversed(found)]

    # ---------------------------------------------------------------- what is done once
    async def assess(self, post_id: str, work: Work) -> str:
        """Do `work` and keep its result until the final reply of the post is on the forum. The same post again, also
        after a restart, returns the kept result."""
        found = await self._first(queries.THIS_ASSESSMENT, post_id)
        if found is not None:
            return str(found.result)
        result = await work()
        await self._rows.write(lambda db: insert_new(db, ASSESSMENT, robot=self._robot, post=post_id, result=result))
        return result

    async def move(self, post_id: str, work: Work) -> str:
        """Do `work`, which moves a robot, at most once ever, and return its result, or the kept one.

        `CommandState.INTERRUPTED`: it had begun before, and its end is not known. `CommandState.CANCELLED`: it was
        cancelled before it began. Raises `IllegalTransition` for a command that may not run: one that waits for its
        approval, or whose end was reported; and `JournalHeld` if the robot was lost. A motion continues when its caller
        is cancelled; only `close` ends it.
        """
        self._rows.check_held()
        claim = await self.claimed(post_id)
        if claim is not None and claim.motion is None:
            check_transition(claim.state, CommandState.RUNNING)
        motion = asyncio.get_running_loop().create_task(self._moved(post_id, work))
        self._motions.add(motion)
        motion.add_done_callback(self._forget)
        return await asyncio.shield(motion)

    async def _moved(self, post_id: str, work: Work) -> str:
        instead = await self._begin(post_id)
        if instead is not None:
            return instead
        try:
            if self._closing or self._rows.lock.lost.is_set():
                raise NotBegun
            working = asyncio.ensure_future(work())
            self._driving.add(working)
            working.add_done_callback(self._driving.discard)
            result = await working
        except NotBegun:
            with contextlib.suppress(JournalError):  # then it counts as interrupted
                await self._do(queries.UNDO_BEGIN, post_id)
            raise asyncio.CancelledError from None
        await self._end(post_id, result)
        return result

    def _forget(self, motion: asyncio.Task[str]) -> None:
        self._motions.discard(motion)
        if not motion.cancelled():
            motion.exception()  # its caller, if it still waits, gets it

    # ---------------------------------------------------------------- motion rows
    async def _begin(self, post_id: str) -> str | None:
        """None if the motion may begin now, and is on disk as begun; else the result to return instead."""

        def work(db: Connection) -> str | None:
            if self._insert_motion(db, post_id, MotionState.BEGUN):
                return None
            state, result = db.execute(queries.THIS_MOTION, self._this(post_id)).one()
            if state == MotionState.ENDED and result is not None:
                return str(result)
            return CommandState.CANCELLED if state == MotionState.CANCELLED else CommandState.INTERRUPTED

        return await self._rows.write(work, begins=True)

    def _insert_motion(self, db: Connection, post_id: str, state: MotionState) -> bool:
        """False when the motion has a row already: the first one wins."""
        number = self.fence.number if self.fence else None
        return insert_new(db, MOTION, robot=self._robot, post=post_id, state=str(state), fence=number)

    async def _end(self, post_id: str, result: str) -> None:
        await self._do(queries.SET_MOTION, post_id, state=str(MotionState.ENDED), result=result)

    async def cancel(self, post_id: str) -> bool:
        """Keep a motion from ever beginning. False if it has a row already: it has begun, or was cancelled before."""
        return await self._rows.write(lambda db: self._insert_motion(db, post_id, MotionState.CANCELLED))

    async def moved(self, post_id: str, ended: bool = False) -> bool:
        """Whether a motion of this post ever began, or (`ended`) what came of it is kept."""
        found = await self._first(queries.THIS_MOTION, post_id)
        if found is None:
            return False
        return bool(found.state == MotionState.ENDED if ended else found.state != MotionState.CANCELLED)

    async def motion_result(self, post_id: str) -> str | None:
        """The result of a motion that ended; None if it is not known."""
        found = await self._first(queries.THIS_MOTION, post_id)
        return str(found.result) if found and found.state == MotionState.ENDED and found.result is not None else None

    async def set_aside(self) -> None:
        """Forget the posts of a forum that was replaced, since its ids mean other posts now: open claims end."""
        mark = f"before-{time.time_ns()}-"  # no post's id begins so
        await self._rows.write(lambda db: [db.execute(query, self._this(mark=mark)) for query in queries.SET_ASIDE])

    # ---------------------------------------------------------------- values
    async def get(self, key: str) -> str | None:
        found = await self._first(queries.VALUE, key)
        return str(found.value) if found else None

    async def put(self, key: str, value: str) -> None:
        await self.put_all(**{key: value})

    async def put_all(self, **values: str) -> None:
        """Write all values in one transaction."""
        await self._rows.write(lambda db: put(db, self._robot, **values))

    async def get_time(self, key: str) -> datetime | None:
        found = await self.get(key)
        return datetime.fromisoformat(found) if found else None
