"""A process reads from a row of the journal how far its command is, and why it may not move.

Each rule is tested by itself, on both sides of its limit.
"""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from agentrob.agent.store.rows import (
    COMMAND,
    ApprovalDecision,
    ApprovalRequest,
    Claim,
    MotionState,
    PartWait,
    boot,
    boot_s,
    read_claim,
)
from agentrob.model import Account, AccountKind, Command, CommandState, EndReason, Role, ScheduledRun

NOW = datetime(2026, 5, 1, 12, tzinfo=UTC)
MAX_AGE_S = 60.0
LONG_AGO = NOW - timedelta(days=1)
MOMENT = timedelta(microseconds=1)
ALICE = Account("a1", "alice", AccountKind.HUMAN, Role.OPERATOR)


def before(seconds: float) -> datetime:
    return NOW - timedelta(seconds=seconds)


def posted(at: datetime) -> Claim:
    return Claim(Command("1", "1", "h", ALICE, "quadruped", "wave", "en", at, "trace"), new=False, waited_s=1.0)


def approved(at: datetime) -> ApprovalRequest:
    decision = ApprovalDecision(True, ALICE, "2", "h", at)
    return ApprovalRequest(before(3000), before(2000), decision)


def why_not(claim: Claim, watermark_at: datetime = LONG_AGO, stopped_at: datetime = LONG_AGO) -> EndReason | None:
    return claim.why_not(NOW, watermark_at, stopped_at, MAX_AGE_S)


FRESH = posted(before(10))


def test_a_fresh_command_may_move() -> None:
    assert why_not(FRESH) is None


@pytest.mark.parametrize("reason", EndReason)
def test_what_was_ended_stays_ended_for_its_reason(reason: EndReason) -> None:
    assert why_not(replace(FRESH, ended=reason)) is reason


@pytest.mark.parametrize(
    ("after", "reason"), [(-MOMENT, None), (timedelta(0), EndReason.STOP), (MOMENT, EndReason.STOP)]
)
def test_law_14_a_stop_ends_what_was_written_before_it(after: timedelta, reason: EndReason | None) -> None:
    assert why_not(FRESH, stopped_at=FRESH.command.posted_at + after) is reason


def test_law_14_a_stop_ends_the_later_runs_of_a_schedule_that_was_written_before_it() -> None:
    run = replace(FRESH.command, run=ScheduledRun(FRESH.command.posted_at, before(3600), "UTC"))
    assert why_not(replace(FRESH, command=run), stopped_at=before(1800)) is EndReason.STOP
    assert why_not(replace(FRESH, command=run), stopped_at=before(5400)) is None


@pytest.mark.parametrize(
    ("after", "reason"), [(-MOMENT, None), (timedelta(0), EndReason.STALE), (MOMENT, EndReason.STALE)]
)
def test_what_was_posted_before_the_watermark_is_stale(after: timedelta, reason: EndReason | None) -> None:
    assert why_not(FRESH, watermark_at=FRESH.command.posted_at + after) is reason


@pytest.mark.parametrize(
    ("age_s", "reason"), [(MAX_AGE_S - 1, None), (MAX_AGE_S, None), (MAX_AGE_S + 1e-6, EndReason.STALE)]
)
def test_a_command_is_stale_when_it_is_too_old(age_s: float, reason: EndReason | None) -> None:
    assert why_not(posted(before(age_s))) is reason


class TestApproval:
    @pytest.mark.parametrize(("left", "reason"), [(MOMENT, None), (timedelta(0), None), (-MOMENT, EndReason.LAPSED)])
    def test_an_open_question_lapses_at_its_time_however_old_its_command_is(
        self, left: timedelta, reason: EndReason | None
    ) -> None:
        for posted_s in (1.0, 3600.0):
            claim = replace(posted(before(posted_s)), asked=ApprovalRequest(before(3000), NOW + left))
            assert why_not(claim) is reason

    @pytest.mark.parametrize(("since_s", "reason"), [(MAX_AGE_S, None), (MAX_AGE_S + 1, EndReason.STALE)])
    def test_what_was_approved_is_as_fresh_as_its_approval(self, since_s: float, reason: EndReason | None) -> None:
        assert why_not(replace(posted(before(3600)), asked=approved(before(since_s)))) is reason

    def test_a_stop_after_the_post_ends_what_was_approved(self) -> None:
        claim = replace(posted(before(3600)), asked=approved(before(1)))
        assert why_not(claim, stopped_at=before(1800)) is EndReason.STOP


class TestParts:
    def test_what_still_waits_for_other_parts_is_left_to_its_wait(self) -> None:
        assert why_not(replace(posted(before(3600)), wait=PartWait(before(3600)))) is None

    def test_a_wait_does_not_outlast_a_stop_or_the_watermark(self) -> None:
        claim = replace(posted(before(3600)), wait=PartWait(before(3600)))
        assert why_not(claim, stopped_at=before(3599)) is EndReason.STOP
        assert why_not(claim, watermark_at=before(3599)) is EndReason.STALE

    @pytest.mark.parametrize(("since_s", "reason"), [(MAX_AGE_S, None), (MAX_AGE_S + 1, EndReason.STALE)])
    def test_what_waited_is_as_fresh_as_the_end_of_its_wait(self, since_s: float, reason: EndReason | None) -> None:
        waited = PartWait(before(3600), before(since_s))
        assert why_not(replace(posted(before(3600)), wait=waited)) is reason

    @pytest.mark.parametrize("approval_first", [True, False])
    def test_of_an_approval_and_the_end_of_a_wait_the_later_one_counts(self, approval_first: bool) -> None:
        late, early = before(MAX_AGE_S - 1), before(MAX_AGE_S + 1)
        first, second = (early, late) if approval_first else (late, early)
        claim = replace(posted(before(3600)), asked=approved(first), wait=PartWait(before(3600), second))
        assert why_not(claim) is None


UNDECIDED = ApprovalRequest(before(10), NOW)


@pytest.mark.parametrize(
    ("claim", "state"),
    [
        (FRESH, CommandState.SEEN),
        (replace(FRESH, asked=UNDECIDED), CommandState.WAITING),
        (replace(FRESH, asked=approved(before(1))), CommandState.QUEUED),
        (replace(FRESH, motion=MotionState.CANCELLED), CommandState.SEEN),
        (replace(FRESH, motion=MotionState.BEGUN, asked=approved(before(1))), CommandState.RUNNING),
        (replace(FRESH, motion=MotionState.ENDED), CommandState.RUNNING),
        (replace(FRESH, motion=MotionState.ENDED, final=CommandState.DONE), CommandState.DONE),
        (replace(FRESH, asked=UNDECIDED, final=CommandState.CANCELLED), CommandState.CANCELLED),
    ],
)
def test_the_state_follows_from_the_rows(claim: Claim, state: CommandState) -> None:
    assert claim.state is state


class TestReading:
    """The columns of `queries._CLAIMS`."""

    @staticmethod
    def read(shared: bool = False, **columns: object) -> Claim:
        row = {
            "command": COMMAND.dump_json(FRESH.command).decode(), "boot": boot(), "accepted_s": boot_s(), "age_s": 7.0,
            "status_post": None, "final": None, "ended": None, "state": None, "waits_since": None, "released_at": None,
            "asked_at": None, "until_at": None, "said": None,
        }  # fmt: skip
        assert set(columns) <= set(row)
        return read_claim(tuple((row | columns).values()), shared)

    def test_a_row_with_nothing_more_is_its_command(self) -> None:
        claim = self.read()
        assert claim == replace(FRESH, waited_s=claim.waited_s)
        assert not claim.new, "an earlier call claimed it"

    def test_what_this_start_of_the_machine_accepted_waited_by_its_clock(self) -> None:
        assert 100.0 <= self.read(accepted_s=boot_s() - 100.0).waited_s < 160.0

    def test_what_an_earlier_start_accepted_has_waited_too_long(self) -> None:
        assert math.isinf(self.read(boot="before").waited_s)

    def test_what_another_machine_accepted_waited_by_the_clock_of_the_database(self) -> None:
        assert self.read(shared=True, boot="elsewhere").waited_s == 7.0
        assert self.read(shared=True, boot="elsewhere", age_s=0.0).waited_s == 0.0
        assert math.isinf(self.read(shared=True, boot="elsewhere", age_s=-1.0).waited_s), "that clock was set back"

    def test_all_columns(self) -> None:
        claim = self.read(
            status_post="9", final="done", ended="stop", state="ended",
            waits_since=before(9).isoformat(), released_at=before(8).isoformat(),
            asked_at=before(7).isoformat(), until_at=before(6).isoformat(), said=None,
        )  # fmt: skip
        assert claim.status_post == "9"
        assert claim.final is CommandState.DONE
        assert claim.ended is EndReason.STOP
        assert claim.motion is MotionState.ENDED
        assert claim.wait == PartWait(before(9), before(8))
        assert claim.asked == ApprovalRequest(before(7), before(6))


def test_each_start_of_the_machine_has_its_own_id() -> None:
    assert boot() == Path("/proc/sys/kernel/random/boot_id").read_text().strip()
