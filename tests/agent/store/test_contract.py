"""The contract of a journal, on SQLite and on PostgreSQL."""

from __future__ import annotations

import asyncio
import gc
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.store.journal import Journal, NotBegun
from agentrob.agent.store.journals import SqliteJournals
from agentrob.agent.store.rows import ApprovalDecision
from agentrob.errors import IllegalTransition, JournalError, JournalHeld
from agentrob.model import CommandState, Direction, EndReason, Op, Plan, Primitive
from tests.agent.store.journal_store import JournalStore, open_journal
from tests.agent.store.old_journal import write_old_journal
from tests.agent.store.test_journal import ALICE, command, says, state
from tests.agent.store.test_schedules import asked as scheduled
from tests.waiting import until

pytestmark = pytest.mark.usefixtures("database")
REX, MAX = "rex", "max"


async def test_a_claim_is_new_once(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    first = await journal.claim(command("1"))
    again = await journal.claim(command("1"))
    assert (first.new, again.new) == (True, False)
    assert again.command == first.command
    assert 0.0 <= again.waited_s < 60.0
    assert (await journal.claim(command("2"), EndReason.STALE)).ended is EndReason.STALE
    assert not await journal.cancel("2"), "its motion was cancelled with the claim"
    assert await journal.knows("2")
    assert not await journal.knows("3")
    await journal.close()


async def test_what_was_written_is_there_after_a_restart(tmp_path: Path) -> None:
    now = datetime.now(UTC)
    plan = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),))
    journal = await open_journal(tmp_path, REX)
    for post in "123":
        await journal.claim(command(post))
    await journal.set_status_post("1", "11")
    await journal.set_plan("1", plan)
    await journal.ask("2", now, now + timedelta(minutes=1))
    assert await journal.decide("2", ApprovalDecision(True, ALICE, "12", "h", now))
    assert await journal.move("1", says("moved")) == "moved"
    assert await journal.assess("3", says("thought")) == "thought"
    await journal.finish("1", CommandState.DONE)
    await journal.put_all(cursor="7", watermark=now.isoformat())
    await journal.close()
    journal = await open_journal(tmp_path, REX)
    assert [claim.command.post_id for claim in await journal.open_claims()] == ["2", "3"]
    newest = await journal.newest_claim()
    assert newest is not None
    assert (newest.command.post_id, newest.status_post, newest.final) == ("1", "11", "done")
    assert await journal.history("1") == [plan]
    assert await state(journal, "2") is CommandState.QUEUED
    assert await journal.has_decision("12")
    assert await journal.motion_result("1") == "moved"
    assert await journal.move("2", says("walked")) == "walked"
    assert await journal.assess("3", says("another")) == "thought"
    assert (await journal.get("cursor"), await journal.get_time("watermark"), await journal.get("no")) == (
        "7",
        now,
        None,
    )
    await journal.close()


async def test_law_14_the_first_reason_why_a_command_may_not_move_counts(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    for post in "12":
        await journal.claim(command(post))
    await journal.end(["1"], EndReason.STOP)
    await journal.end(["1"], EndReason.STALE)
    assert [(claim.command.post_id, claim.ended) for claim in await journal.open_claims()] == [
        ("1", EndReason.STOP),
        ("2", None),
    ]
    await journal.close()


async def test_what_is_kept_of_a_post_is_not_taken_for_another_s(tmp_path: Path) -> None:
    now = datetime.now(UTC)
    journal = await open_journal(tmp_path, REX)
    for post in "12":
        await journal.claim(command(post))
        assert await journal.assess(post, says(f"thought {post}")) == f"thought {post}"
        await journal.ask(post, now, now)
    assert await journal.decide("1", ApprovalDecision(True, ALICE, "9", "h", now))
    assert [await journal.has_decision(post) for post in ("9", "1", "2")] == [True, False, False]
    assert [await state(journal, post) for post in "12"] == ["queued", "waiting"]
    await journal.finish("1", CommandState.CANCELLED)
    assert await journal.assess("2", says("another")) == "thought 2"
    assert await journal.assess("1", says("another")) == "another", "it was told, so its assessment is gone"
    await journal.close()


async def test_claims_come_in_the_order_in_which_they_were_made(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    assert await journal.newest_claim() is None
    for post in "3142":
        await journal.claim(command(post))
    assert [claim.command.post_id for claim in await journal.open_claims()] == ["3", "1", "4", "2"]
    for post in "413":
        await journal.set_status_post(post, f"{post}0")
    newest = await journal.newest_claim()
    assert newest is not None
    assert (newest.command.post_id, newest.status_post) == ("4", "40"), "of those whose status is on the forum"
    await journal.close()


async def test_law_6_of_begin_and_cancel_the_first_wins(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    outcomes = set()
    for n in range(20):
        post = str(n)
        calls = [journal.move(post, says("moved")), journal.cancel(post)]
        result, cancelled = await asyncio.gather(*(calls if n % 2 else reversed(calls)))
        if isinstance(result, bool):
            result, cancelled = cancelled, result
        assert (result == "cancelled") == cancelled
        outcomes.add(str(result))
        assert await journal.moved(post) == (not cancelled)
        assert await journal.moved(post, ended=True) == (not cancelled)
    assert "cancelled" in outcomes
    await journal.close()


async def test_law_6_what_was_begun_and_not_ended_is_interrupted(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    begun = asyncio.Event()

    async def hang() -> str:
        begun.set()
        await asyncio.Event().wait()
        return "never"

    async def not_yet() -> str:
        raise NotBegun

    motion = asyncio.create_task(journal.move("1", hang))
    await begun.wait()
    with pytest.raises(asyncio.CancelledError):
        await journal.move("2", not_yet)
    await journal.close()
    await asyncio.gather(motion, return_exceptions=True)
    journal = await open_journal(tmp_path, REX)
    assert [await journal.moved("1"), await journal.moved("1", ended=True)] == [True, False]
    assert await journal.motion_result("1") is None
    assert await journal.move("1", says("again")) == CommandState.INTERRUPTED
    assert [await journal.moved("2"), await journal.moved("2", ended=True)] == [False, False]
    assert await journal.move("2", says("now")) == "now"
    await journal.close()


async def test_law_6_a_motion_that_is_ended_before_the_robot_moved_may_begin_after_a_restart(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    waits = asyncio.Event()

    async def wait_for_the_robot() -> str:
        waits.set()
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            raise NotBegun from None
        return "never"

    motion = asyncio.create_task(journal.move("1", wait_for_the_robot))
    await waits.wait()
    await journal.close()
    await asyncio.gather(motion, return_exceptions=True)
    journal = await open_journal(tmp_path, REX)
    assert await journal.move("1", says("moved")) == "moved"
    await journal.close()


async def test_a_motion_that_fails_or_is_ended_without_its_caller_is_no_error_of_the_event_loop(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    reported: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, about: reported.append(about))
    end = asyncio.Event()

    async def fails() -> str:
        await end.wait()
        raise OSError("the robot is gone")

    async def not_yet() -> str:
        await end.wait()
        raise NotBegun

    callers = [asyncio.create_task(journal.move(post, work)) for post, work in (("1", fails), ("2", not_yet))]
    await until(lambda: journal.moved("1"))
    await until(lambda: journal.moved("2"))
    for caller in callers:
        caller.cancel()
    await asyncio.gather(*callers, return_exceptions=True)
    end.set()
    await until(lambda: journal.moved("2"), lambda moved: not moved)
    await journal.close()
    del callers, caller
    gc.collect()  # an exception that nobody asked for is reported when its task is deleted
    assert not reported


async def test_a_motion_goes_on_when_its_caller_is_cancelled(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    begun, end = asyncio.Event(), asyncio.Event()

    async def moving() -> str:
        begun.set()
        await end.wait()
        return "moved"

    caller = asyncio.create_task(journal.move("1", moving))
    await begun.wait()
    caller.cancel()
    await asyncio.gather(caller, return_exceptions=True)
    assert await journal.motion_result("1") is None
    end.set()
    await until(lambda: journal.motion_result("1"), lambda text: text is not None)
    assert await journal.move("1", says("again")) == "moved"
    await journal.close()


async def test_writes_are_in_the_order_of_the_calls_also_when_callers_are_cancelled(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    calls = [asyncio.create_task(journal.put("key", str(n))) for n in range(40)]
    await asyncio.sleep(0)
    for call in calls[1::2]:
        call.cancel()
    last = asyncio.create_task(journal.get("key"))
    await asyncio.gather(*calls, return_exceptions=True)
    assert await last == "38"
    await journal.close()


async def test_law_7_the_first_decision_counts_but_a_denial_before_the_motion(tmp_path: Path) -> None:
    now = datetime.now(UTC)
    journal = await open_journal(tmp_path, REX)
    for post in "12":
        await journal.claim(command(post))
        asked = await journal.ask(post, now, now + timedelta(minutes=1))
        assert (await journal.ask(post, now, now + timedelta(minutes=9))).until_at == asked.until_at
    approval, denial = (ApprovalDecision(yes, ALICE, "9", "h", now) for yes in (True, False))
    assert await journal.decide("1", approval)
    assert not await journal.decide("1", approval)
    assert await journal.decide("1", denial)
    assert await journal.move("1", says("moved")) == CommandState.CANCELLED
    assert await journal.decide("2", approval)
    assert await journal.move("2", says("moved")) == "moved"
    assert not await journal.decide("2", denial), "it moved already"
    moved = await journal.claimed("2")
    assert moved is not None
    assert moved.ended is None
    assert moved.asked is not None
    assert moved.asked.decided == approval
    with pytest.raises(JournalError, match="never claimed"):
        await journal.ask("3", now, now)
    await journal.close()


async def test_law_7_no_approval_is_asked_for_what_has_ended(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    await journal.claim(command("1"))
    await journal.finish("1", CommandState.REFUSED)
    now = datetime.now(UTC)
    with pytest.raises(IllegalTransition, match="from 'refused' to 'waiting'"):
        await journal.ask("1", now, now)
    await journal.close()


async def test_law_11_with_a_lost_robot_nothing_begins_and_ends_are_written(tmp_path: Path) -> None:
    now = datetime.now(UTC)
    journal = await open_journal(tmp_path, REX)
    await journal.claim(command("1"))
    kept = await journal.add_schedule(scheduled("2"), now)
    journal._rows.lock.lost.set()  # as when the connection that holds it on PostgreSQL is lost
    for begins in (
        journal.claim(command("3")),
        journal.add_schedule(scheduled("4"), now),
        journal.begin_run(kept, command("2.1"), None, kept),
        journal.move("1", says("moved")),
    ):
        with pytest.raises(JournalHeld, match="has lost rex"):
            await begins
    assert [await journal.knows(post) for post in ("1", "3", "2.1")] == [True, False, False]
    assert await journal.schedule("4") is None
    await journal.end(["1"], EndReason.STOP)
    await journal.finish("1", CommandState.STOPPED)
    assert await state(journal, "1") is CommandState.STOPPED
    await journal.close()


async def test_the_newest_five_plans_of_a_topic_are_remembered_oldest_first(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    plans = [Plan((Primitive(Op.TURN, Direction.LEFT, degrees=float(n)),)) for n in range(1, 8)]
    for n, plan in enumerate(plans):
        await journal.claim(command(str(n)))
        await journal.set_plan(str(n), plan)
    await journal.finish("6", CommandState.REFUSED)
    await journal.claim(command("without a plan"))
    assert await journal.history("1") == plans[1:6], "and what was refused is not"
    assert await journal.history("1", 2) == plans[4:6]
    assert await journal.history("another") == []
    await journal.close()


async def test_a_replaced_forum_s_ids_mean_other_posts(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    for post in "12":
        await journal.claim(command(post))
    assert await journal.move("1", says("moved")) == "moved"
    await journal.finish("1", CommandState.DONE)
    now = datetime.now(UTC)
    await journal.ask("2", now, now)
    assert await journal.decide("2", ApprovalDecision(True, ALICE, "9", "h", now))
    assert await journal.assess("2", says("thought")) == "thought"
    await journal.set_aside()
    assert await journal.open_claims() == []
    assert not await journal.has_decision("9")
    assert await journal.assess("2", says("another")) == "another"
    assert (await journal.claim(command("2"))).new
    assert await state(journal, "2") is CommandState.SEEN, "what was approved before is not"
    assert (await journal.claim(command("1"))).new
    assert await journal.move("1", says("moved again")) == "moved again"
    await journal.set_aside()
    finals = [row[0] for row in JournalStore(tmp_path, REX).rows("SELECT final FROM claim ORDER BY number")]
    assert finals == ["done", "cancelled", "cancelled", "cancelled"]
    await journal.close()


async def test_robots_do_not_see_each_other_s_rows(tmp_path: Path) -> None:
    rex, other = await open_journal(tmp_path, REX), await open_journal(tmp_path, MAX)
    assert (await rex.claim(command("1"))).new
    assert (await other.claim(command("1"))).new
    assert await rex.cancel("1")
    now = datetime.now(UTC)
    await rex.claim(command("3"))
    await rex.ask("3", now, now)
    assert await rex.decide("3", ApprovalDecision(True, ALICE, "9", "h", now))
    await rex.assess("1", says("thought"))
    kept = await rex.add_schedule(scheduled("2"), now)
    assert not await other.has_decision("9")
    assert await other.schedules() == []
    assert await other.move("1", says("moved")) == "moved"
    await other.finish("1", CommandState.DONE)
    await other.set_aside()
    await other.put("cursor", "1")
    assert await rex.move("1", says("moved")) == CommandState.CANCELLED
    assert await rex.assess("1", says("another")) == "thought"
    assert await rex.has_decision("9")
    assert await rex.schedules() == [kept]
    assert [claim.command.post_id for claim in await rex.open_claims()] == ["1", "3"]
    assert (await rex.get("cursor"), await rex.history("1")) == (None, [])
    for journal in (rex, other):
        await journal.close()


async def test_law_6_of_how_many_claims_are_kept_each_robot_s_own_count(tmp_path: Path) -> None:
    rex, other = await open_journal(tmp_path, REX), await open_journal(tmp_path, MAX)
    for post in "123":
        await rex.claim(command(post))
    for post in "12":
        await other.claim(command(post))
        await other.finish(post, CommandState.REFUSED)
    JournalStore(tmp_path, MAX).change("UPDATE claim SET at = at - 200000 WHERE robot = :robot", robot=MAX)
    await other.prune(30, 2)
    assert [await other.knows(post) for post in "12"] == [True, True]
    await other.prune(30, 1)
    assert [await other.knows(post) for post in "12"] == [False, True]
    assert len(await rex.open_claims()) == 3
    for journal in (rex, other):
        await journal.close()


async def test_a_robot_has_one_agent(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    with pytest.raises(JournalHeld, match="already runs"):
        await open_journal(tmp_path, REX)
    await journal.claim(command("1"))
    await journal.close()
    await journal.close()
    with pytest.raises(JournalError, match="closed"):
        await journal.claim(command("2"))
    journal = await open_journal(tmp_path, REX)
    assert not await journal.knows("2")
    await journal.close()


async def test_illegal_transitions_change_nothing(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    await journal.claim(command("1"))
    with pytest.raises(IllegalTransition):
        await journal.finish("1", CommandState.DONE)
    assert await state(journal, "1") is CommandState.SEEN
    await journal.close()


async def test_law_6_a_journal_of_version_0_1_is_read_once_and_a_motion_that_had_begun_is_interrupted(
    tmp_path: Path, database: str
) -> None:
    path = write_old_journal(tmp_path, REX, *map(command, "123"), begun=("2",))
    for _ in range(2):
        journal = await open_journal(tmp_path, REX)
        assert [claim.command.post_id for claim in await journal.open_claims()] == ["1", "2", "3"]
        assert await journal.move("2", says("again")) == CommandState.INTERRUPTED
        assert await journal.get("cursor") == "27-660e8ab3806e2"
        await journal.close()
    imported = [file.name for file in path.parent.glob("journal.sqlite*")]
    assert imported == (["journal.sqlite"] if database == "sqlite" else ["journal.sqlite.imported"])
    journal = await open_journal(tmp_path, REX)
    await journal.claim(command("4"))
    assert [claim.command.post_id for claim in await journal.open_claims()] == ["1", "2", "3", "4"]
    await journal.close()


async def test_law_6_an_unreadable_journal_is_not_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "agents" / REX / "journal.sqlite"
    path.parent.mkdir(parents=True)
    path.write_bytes(b"not a database" * 1000)
    with pytest.raises(JournalError, match="cannot be opened"):
        await open_journal(tmp_path, REX)
    path.unlink()
    await (await open_journal(tmp_path, REX)).close()


async def test_a_journal_that_cannot_be_opened_releases_the_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def fails(_: Journal) -> None:
        raise JournalError("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(Journal, "begin", fails)
        with pytest.raises(JournalError, match="the disk is full"):
            await open_journal(tmp_path, REX)
    await (await open_journal(tmp_path, REX)).close()


async def test_a_write_that_fails_changes_nothing_and_the_next_one_succeeds(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, REX)
    with pytest.raises(UnicodeEncodeError):
        await journal.put_all(a="1", b="\ud800")  # no database stores half a character
    await journal.put("b", "2")
    assert (await journal.get("a"), await journal.get("b")) == (None, "2")
    await journal.close()


async def test_a_folder_that_cannot_be_made_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "agents").write_text("a file")
    journals = SqliteJournals(tmp_path)
    with pytest.raises(JournalError, match=r"journal\.sqlite cannot be opened"):
        await journals.open(REX)
    await journals.close()


async def test_law_6_motion_rows_name_the_holder_that_wrote_them(tmp_path: Path, database: str) -> None:
    numbers = []
    for n in range(3):
        journal: Journal = await open_journal(tmp_path, REX)
        await journal.move(str(n), says("moved"))
        numbers.append(journal.fence.number if journal.fence else None)
        await journal.close()
    assert [row[0] for row in JournalStore(tmp_path, REX).rows("SELECT fence FROM motion ORDER BY post")] == numbers
    if database == "postgresql":
        assert numbers == sorted(set(numbers)), "the fence grows"  # type: ignore[type-var]
    else:
        assert set(numbers) == {None}
