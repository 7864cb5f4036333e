"""The journal's schedules: a run is taken once, together with its claim, and the first end counts."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from agentrob.agent.store.rows import KeptSchedule, ScheduledCommand
from agentrob.model import CommandState, EndReason, Schedule, ScheduleEnd
from tests.agent.store.journal_store import JournalStore, open_journal
from tests.agent.store.test_journal import command, says

pytestmark = pytest.mark.usefixtures("database")
REX = "rex"
NOON = datetime(2026, 11, 24, 12, tzinfo=UTC)
HOUR = timedelta(hours=1)


def asked(post: str) -> ScheduledCommand:
    schedule = Schedule(NOON, NOON + 9 * HOUR, "UTC", runs_left=3, every_s=3600)
    return ScheduledCommand(command(post), schedule, "wave", "wave")


async def test_law_6_a_schedule_is_kept_once_and_its_own_post_never_moves(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    kept = await journal.add_schedule(asked("1"), NOON)
    assert kept == KeptSchedule(kept.asked, NOON, 3, None, False)
    assert (kept.post_id, kept.asked.schedule) == ("1", asked("1").schedule)
    assert (await journal.add_schedule(asked("1"), NOON + HOUR)).next_at == NOON, "the first one counts"
    assert await journal.move("1", says("moved")) == CommandState.CANCELLED
    await journal.close()
    journal = await open_journal(tmp_path, REX)
    assert await journal.schedule("1") == kept
    assert await journal.schedule("2") is None
    await journal.close()


async def test_schedules_come_in_the_order_of_their_runs_until_their_end_was_told(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    for post, hours in (("1", 3), ("2", 1), ("3", 2), ("5", 4), ("4", 4)):
        await journal.add_schedule(asked(post), NOON + hours * HOUR)
    assert [kept.post_id for kept in await journal.schedules()] == ["2", "3", "1", "4", "5"]
    await journal.end_schedule("3", ScheduleEnd.STOP)
    await journal.end_schedule("2", ScheduleEnd.CANCELLED, reported=True)
    assert {kept.post_id for kept in await journal.schedules()} == {"1", "3", "4", "5"}, "one end must still be told"
    ended = await journal.schedule("3")
    assert ended is not None
    assert (ended.ended, ended.next_at, ended.reported) == (ScheduleEnd.STOP, None, False)
    await journal.end_schedule("3", ScheduleEnd.EDITED, reported=True)
    assert await journal.schedule("3") == ended, "the first reason counts"
    await journal.set_schedule_reported("3")
    assert [kept.post_id for kept in await journal.schedules()] == ["1", "4", "5"]
    told = await journal.schedule("2")
    assert told is not None
    assert (told.ended, told.reported) == (ScheduleEnd.CANCELLED, True)
    await journal.close()


@pytest.mark.parametrize("ended", [None, EndReason.STALE])
async def test_law_6_a_run_is_taken_once_with_its_claim(tmp_path: Path, ended: EndReason | None) -> None:
    journal = await open_journal(tmp_path, REX)
    kept = await journal.add_schedule(asked("1"), NOON)
    other = await journal.add_schedule(asked("2"), NOON)
    after = replace(kept, next_at=NOON + HOUR, runs_left=2)
    run = await journal.begin_run(kept, command("1.1"), ended, after)
    assert run is not None
    assert (run.new, run.ended) == (True, ended)
    assert await journal.schedule("1") == after
    assert await journal.schedule("2") == other
    assert await journal.begin_run(kept, command("1.2"), None, after) is None, "it is not the next one any more"
    assert not await journal.knows("1.2")
    assert await journal.move("1.1", says("moved")) == ("moved" if ended is None else CommandState.CANCELLED)
    await journal.close()


async def test_law_6_the_last_run_ends_its_schedule(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    kept = await journal.add_schedule(asked("1"), NOON)
    last = replace(kept, next_at=None, runs_left=0, ended=ScheduleEnd.DONE, reported=True)
    assert await journal.begin_run(kept, command("1.1"), None, last) is not None
    assert await journal.schedule("1") == last
    assert await journal.begin_run(last, command("1.2"), None, last) is None
    await journal.close()


async def test_law_14_no_run_begins_after_its_schedule_was_ended(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    kept = await journal.add_schedule(asked("1"), NOON)
    JournalStore(tmp_path, REX).change("UPDATE schedule SET ended = 'stop' WHERE post = '1'")  # and its next run stays
    assert await journal.begin_run(kept, command("1.1"), None, replace(kept, next_at=NOON + HOUR)) is None
    assert not await journal.knows("1.1")
    await journal.close()


async def test_a_schedule_that_ended_by_its_limit_is_renewed_once_unless_that_is_refused(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    for post in "1234":
        await journal.add_schedule(asked(post), NOON)
        await journal.end_schedule(post, ScheduleEnd.DONE if post == "4" else ScheduleEnd.LIMIT)
    assert [each.post_id for each in await journal.renewable_schedules()] == ["1", "2", "3"]
    renewed = KeptSchedule(asked("1"), NOON + HOUR, 30, None, False)
    assert await journal.renew_schedule(renewed) is True
    assert await journal.schedule("1") == renewed
    assert await journal.renew_schedule(replace(renewed, runs_left=60)) is False
    assert await journal.schedule("1") == renewed
    await journal.refuse_renewal("2", ScheduleEnd.STOP)
    refused = await journal.schedule("2")
    assert refused is not None
    assert (refused.ended, refused.reported) == (ScheduleEnd.STOP, True)
    assert [each.post_id for each in await journal.renewable_schedules()] == ["3"]
    await journal.set_schedule_reported("3")
    await journal.prune(30, 5000)
    assert [await journal.schedule(post) for post in "23"] == [None, None], "both ends were told"
    assert {each.post_id for each in await journal.schedules()} == {"1", "4"}
    await journal.close()


async def test_a_schedule_is_let_go_of_when_its_end_was_told(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    for post in "1234":
        await journal.add_schedule(asked(post), NOON)
    for post in "23":
        await journal.end_schedule(post, ScheduleEnd.CANCELLED, reported=True)
    await journal.end_schedule("4", ScheduleEnd.CANCELLED)
    await journal.claim(command("3"))
    await journal.prune(30, 5000)
    assert sorted(row[0] for row in JournalStore(tmp_path, REX).rows("SELECT post FROM schedule")) == ["1", "3", "4"]
    await journal.set_aside()
    assert await journal.schedules() == [], "the posts of a forum that was replaced ask for nothing"
    await journal.close()
