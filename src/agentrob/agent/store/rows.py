"""The rows of a journal: claims, requests for approval, and how far a motion is."""

from __future__ import annotations

import contextlib
import os
import time
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import StrEnum
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from agentrob.model import Account, Command, CommandState, EndReason, Pose, Schedule, ScheduleEnd
from agentrob.model.lifecycle import stored_reason, stored_state


class MotionState(StrEnum):
    """The state of a motion row, which is written before anything moves: its first insert wins."""

    BEGUN = "begun"
    ENDED = "ended"  # and its result is kept
    CANCELLED = "cancelled"  # it never begins


@dataclass(frozen=True, slots=True)
class ApprovalDecision:
    """An approval or a denial of a command, bound to its post as a command is bound to its own.

    `preview` is the hash of the preview that was shown before, empty if there was none, and `start` where it begins.
    """

    approved: bool
    by: Account
    post_id: str
    content_hash: str
    at: datetime
    preview: str = ""
    start: Pose | None = None


@dataclass(frozen=True, slots=True)
class ApprovalRequest:
    """A request for approval, made at `asked_at` by the forum's clock, and the decision, if there is one."""

    asked_at: datetime
    until_at: datetime
    decided: ApprovalDecision | None = None


@dataclass(frozen=True, slots=True)
class KeptPreview:
    """A preview as its room writes it, since when it is beside its question, by the forum's clock, and the number of
    pictures that the status post has by it. `shown_at` is None if the process ended before that was known."""

    data: str
    shown_at: datetime | None
    pictures: int


@dataclass(frozen=True, slots=True)
class ScheduledCommand:
    """A command for later times: the post that asked for it, the command without the time, and what that is in our
    words. `renewed_by` is the post by which its author last renewed it; then the command's `posted_at` is that of this
    post."""

    command: Command
    schedule: Schedule
    text: str
    understood: str
    renewed_by: str = ""


@dataclass(frozen=True, slots=True)
class KeptSchedule:
    """A scheduled command with its next run, how many runs are left, and why it has ended, if it has. `reported`:
    its end was reported, or needs no report."""

    asked: ScheduledCommand
    next_at: datetime | None
    runs_left: int
    ended: ScheduleEnd | None = None
    reported: bool = False

    @property
    def post_id(self) -> str:
        return self.asked.command.post_id


@dataclass(frozen=True, slots=True)
class PartWait:
    """The wait of a part for others of its post, since `since`, until `released_at`, by the forum's clock."""

    since: datetime
    released_at: datetime | None = None


COMMAND, DECIDED = TypeAdapter(Command), TypeAdapter(ApprovalDecision)
SCHEDULED = TypeAdapter(ScheduledCommand)


@dataclass(frozen=True, slots=True)
class Claim:
    """A post that this journal claimed. `new` is False if it was claimed before, perhaps by an earlier process.

    `waited_s` is how long ago it was accepted, by the machine's clock that cannot be set. If the machine was restarted
    since, it is infinite; if workers share the journal's database, it is then the time by the database's clock.
    `final` is the state of its final reply, None while it is open. `ended` is why it may never move, None while it may.
    `asked` is its request for approval, `wait` its wait for other parts of its post. `motion` is the state of its
    motion row.
    """

    command: Command
    new: bool
    waited_s: float
    status_post: str | None = None
    final: CommandState | None = None
    ended: EndReason | None = None
    asked: ApprovalRequest | None = None
    motion: MotionState | None = None
    wait: PartWait | None = None

    @property
    def state(self) -> CommandState:
        """How far the command is, as far as the journal knows: it keeps no place in the queue."""
        if self.final is not None:
            return self.final
        if self.motion in (MotionState.BEGUN, MotionState.ENDED):
            return CommandState.RUNNING
        if self.asked is None:
            return CommandState.SEEN
        return CommandState.WAITING if self.asked.decided is None else CommandState.QUEUED

    def why_not(
        self, now_at: datetime, watermark_at: datetime, stopped_at: datetime, max_age_s: float
    ) -> EndReason | None:
        """Why a claim of an earlier process may not begin to move; None if it is still fresh."""
        posted_at = self.command.posted_at
        if self.ended is not None:
            return self.ended
        if self.command.written_at <= stopped_at:
            return EndReason.STOP
        if posted_at <= watermark_at:
            return EndReason.STALE
        if self.wait is not None and self.wait.released_at is None:
            return None  # it ends by itself, at a time that the other parts decide
        if self.asked is not None and self.asked.decided is None:
            return EndReason.LAPSED if now_at > self.asked.until_at else None
        # A command that was approved is as fresh as its approval.
        since_at = self.asked.decided.at if self.asked is not None and self.asked.decided is not None else posted_at
        if self.wait is not None and self.wait.released_at is not None:
            since_at = max(since_at, self.wait.released_at)  # and what waited, as the end of its wait
        return None if now_at - since_at <= timedelta(seconds=max_age_s) else EndReason.STALE


def read_claim(row: Any, shared: bool) -> Claim:
    """A row of `CLAIMS`; its `waited_s` counts until now. `shared`: another machine may have accepted it."""
    command, taken_in, accepted_s, age_s, status_post, final, ended, motion, waits_since, released_at, *asked = row
    elsewhere_s = age_s if shared and age_s >= 0.0 else float("inf")
    return Claim(
        COMMAND.validate_json(command),
        new=False,
        waited_s=boot_s() - accepted_s if taken_in == boot() else elsewhere_s,
        status_post=status_post,
        final=stored_state(final) if final is not None else None,
        ended=stored_reason(ended) if ended is not None else None,
        asked=read_asked(*asked),
        motion=MotionState(motion) if motion is not None else None,
        wait=read_wait(waits_since, released_at),
    )


def read_schedule(row: Any) -> KeptSchedule:
    """A row of `SCHEDULES`."""
    data, next_at, runs_left, ended, reported = row
    at = datetime.fromisoformat(next_at) if next_at is not None else None
    end = ScheduleEnd(ended) if ended is not None else None
    return KeptSchedule(SCHEDULED.validate_json(data), at, int(runs_left), end, bool(reported))


def read_wait(waits_since: str | None, released_at: str | None) -> PartWait | None:
    if waits_since is None:
        return None
    ended = datetime.fromisoformat(released_at) if released_at is not None else None
    return PartWait(datetime.fromisoformat(waits_since), ended)


def read_asked(asked_at: str | None, until_at: str | None, decision: str | None) -> ApprovalRequest | None:
    if asked_at is None or until_at is None:
        return None
    decided = DECIDED.validate_json(decision) if decision else None
    return ApprovalRequest(datetime.fromisoformat(asked_at), datetime.fromisoformat(until_at), decided)


def boot_s() -> float:
    """Seconds since this machine started, sleep included: a clock that cannot be set."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def boot() -> str:
    """The id of this start of the machine."""
    with contextlib.suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    return f"{os.uname().nodename}"
