"""The journal stores the states of commands: it accepts only transitions of the table, and reads rows of earlier
versions."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from agentrob.agent.store.journal import Journal
from agentrob.agent.store.rows import ApprovalDecision
from agentrob.errors import IllegalTransition
from agentrob.model import Account, AccountKind, Command, CommandState, EndReason, Role
from tests.agent.agent_scene import FINAL, ROBOT, Scene
from tests.agent.store.journal_store import JournalStore, open_journal
from tests.waiting import until

pytestmark = pytest.mark.usefixtures("database")

ALICE = Account("a1", "alice", AccountKind.HUMAN, Role.OPERATOR)


def command(post: str) -> Command:
    return Command(post, "1", "h", ALICE, ROBOT, "wave", "en", datetime.now(UTC), "trace")


async def state(journal: Journal, post: str) -> CommandState:
    claim = await journal.claimed(post)
    assert claim is not None
    return claim.state


def says(text: str) -> Callable[[], Awaitable[str]]:
    async def answer() -> str:
        return text

    return answer


async def test_a_command_goes_through_its_states(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, ROBOT)
    now = datetime.now(UTC)
    await journal.claim(command("1"))
    states = [await state(journal, "1")]
    await journal.ask("1", now, now + timedelta(minutes=1))
    states.append(await state(journal, "1"))
    await journal.decide("1", ApprovalDecision(True, ALICE, "2", "h", now))
    states.append(await state(journal, "1"))

    async def moving() -> str:
        states.append(await state(journal, "1"))
        return "moved"

    await journal.move("1", moving)
    await journal.finish("1", CommandState.DONE)
    states.append(await state(journal, "1"))
    assert states == ["seen", "waiting", "queued", "running", "done"]
    await journal.close()


async def test_law_6_a_command_has_one_end(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, ROBOT)
    await journal.claim(command("1"))
    with pytest.raises(IllegalTransition, match="from 'seen' to 'done'"):
        await journal.finish("1", CommandState.DONE)
    await journal.finish("1", CommandState.REFUSED)
    await journal.finish("1", CommandState.REFUSED)
    with pytest.raises(IllegalTransition, match="from 'refused' to 'done'; valid: none, it is final"):
        await journal.finish("1", CommandState.DONE)
    with pytest.raises(IllegalTransition, match="from 'refused' to 'running'"):
        await journal.move("1", says("moved"))
    assert not await journal.moved("1")
    assert await state(journal, "1") is CommandState.REFUSED
    await journal.close()


async def test_law_7_what_waits_for_approval_does_not_move(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, ROBOT)
    now = datetime.now(UTC)
    await journal.claim(command("1"))
    await journal.ask("1", now, now + timedelta(minutes=1))
    with pytest.raises(IllegalTransition, match="from 'waiting' to 'running'"):
        await journal.move("1", says("moved"))
    assert not await journal.moved("1")
    await journal.close()


async def test_law_13_a_stop_is_written_down_in_every_state(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, ROBOT)
    now = datetime.now(UTC)
    posts = ("seen", "waiting", "queued", "running", "told")
    for post in posts:
        await journal.claim(command(post))
    for post in ("waiting", "queued"):
        await journal.ask(post, now, now + timedelta(minutes=1))
    await journal.decide("queued", ApprovalDecision(True, ALICE, "9", "h", now))
    await journal.finish("told", CommandState.ANSWERED)
    begun, stopped = asyncio.Event(), asyncio.Event()

    async def moving() -> str:
        begun.set()
        await stopped.wait()
        return "stopped"

    motion = asyncio.create_task(journal.move("running", moving))
    await begun.wait()
    await journal.end((*posts, "never claimed"), EndReason.STOP)
    stopped.set()
    assert await motion == "stopped"
    for post in posts:
        claim = await journal.claimed(post)
        assert claim is not None
        assert claim.ended is EndReason.STOP
    for post in ("seen", "waiting", "queued", "never claimed"):
        assert not await journal.cancel(post)  # its motion can no longer begin
    for post in ("seen", "waiting", "queued", "running"):
        await journal.finish(post, CommandState.STOPPED)
    await journal.close()


async def test_rows_of_earlier_versions_are_read(tmp_path: Path) -> None:
    words = (*sorted(FINAL), "nothing", "answered before", "replaced")
    journal = await open_journal(tmp_path, ROBOT)
    for word in words:
        await journal.claim(command(word))
    await journal.claim(command("open"))
    await journal.close()
    store = JournalStore(tmp_path, ROBOT)
    for word in words:
        store.change("UPDATE claim SET final = :word WHERE post = :word", word=word)
    store.change("UPDATE claim SET ended = 'a word of a newer version' WHERE post = 'open'")
    journal = await open_journal(tmp_path, ROBOT)
    read = {word: await state(journal, word) for word in words}
    named = {"answered before": "handled_elsewhere", "replaced": "cancelled"}
    assert read == {word: named.get(word, word) for word in words}
    assert [(c.command.post_id, c.ended) for c in await journal.open_claims()] == [("open", EndReason.BEFORE)]
    await journal.close()


async def test_the_journal_and_the_forum_tell_the_same_end(scene: Scene) -> None:
    posts = {}
    async with scene.agent() as agent:
        for name, text in (
            ("alice", "wave"),
            ("alice", "walk"),
            ("alice", "help"),
            ("bob", "turn left 90 degrees"),
            ("alice", "walk forward 900 m"),
        ):
            post = await scene.post(name, f"@{ROBOT} {text}")
            posts[post.id] = (await scene.final(post)).card
        far = await scene.post("alice", f"@{ROBOT} walk forward 5 m")
        await scene.state(far, "running")
        await scene.post("alice", f"@{ROBOT} stop")
        posts[far.id] = (await scene.final(far)).card
        await scene.until(lambda: not len(agent.queue))
        await until(agent.journal.open_claims, lambda claims: not claims)
        in_journal = {post: await state(agent.journal, post) for post in posts}
    assert in_journal == {post: card.state for post, card in posts.items() if card is not None}
    assert set(in_journal.values()) >= {"done", "asks_back", "answered", "refused", "stopped"}


async def test_a_new_claim_has_not_waited_and_one_from_before_a_restart_of_the_machine_has_waited_too_long(
    tmp_path: Path,
) -> None:
    journal = await open_journal(tmp_path, ROBOT)
    assert (await journal.claim(command("1"))).waited_s == 0.0
    JournalStore(tmp_path, ROBOT).change("UPDATE claim SET boot = 'another'")
    [claim] = await journal.open_claims()
    assert claim.waited_s == math.inf if journal.fence is None else 0.0 <= claim.waited_s < 60.0
    await journal.close()


async def test_law_6_a_motion_that_is_written_while_the_journal_closes_does_not_begin(tmp_path: Path) -> None:
    """The motion's task exists, but another process holds up its write until after `close`."""
    journal = await open_journal(tmp_path, ROBOT)
    await journal.claim(command("1"))
    begun: list[str] = []

    async def moving() -> str:
        begun.append("moved")
        return "moved"

    tasks = len(asyncio.all_tasks())
    async with asyncio.timeout(60):
        with JournalStore(tmp_path, ROBOT).writing():
            caller = asyncio.create_task(journal.move("1", moving))
            while len(asyncio.all_tasks()) < tasks + 2:  # noqa: ASYNC110 (the tasks of caller and motion)
                await asyncio.sleep(0)
            closing = asyncio.create_task(journal.close())
            await asyncio.sleep(0)
        await closing
    await asyncio.gather(caller, return_exceptions=True)
    assert not begun
    journal = await open_journal(tmp_path, ROBOT)
    assert await journal.move("1", says("moved")) == "moved", "it did not begin, so it is not interrupted"
    await journal.close()
