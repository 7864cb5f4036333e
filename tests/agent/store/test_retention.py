"""An agent's data about ended commands does not grow for ever, and nothing that is open is deleted."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.store import journal as journal_module
from agentrob.agent.store import retention
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.records import Records
from agentrob.config.robots import RetentionConfig
from agentrob.model import Account, AccountKind, Command, CommandState, Role
from tests.agent.agent_scene import ROBOT, Scene
from tests.agent.store.journal_store import JournalStore, open_journal

pytestmark = pytest.mark.usefixtures("database")

DAY_S = 86400.0
ALICE = Account("a1", "alice", AccountKind.HUMAN, Role.OPERATOR)


def says(text: str) -> Callable[[], Awaitable[str]]:
    async def answer() -> str:
        return text

    return answer


async def kept(folder: Path, *posts: str, reported: tuple[str, ...], aged: dict[str, float]) -> Journal:
    """Return a journal with claims, assessments and motions of these posts; some were `reported`, some are this many
    days old."""
    journal = await open_journal(folder, ROBOT)
    for post in posts:
        await journal.claim(Command(post, "1", "h", ALICE, ROBOT, "wave", "en", datetime.now(UTC), "trace"))
        await journal.assess(post, says("thought"))
        await journal.move(post, says("moved"))
        if post in reported:
            await journal.finish(post, CommandState.DONE)
    for post, days in aged.items():
        for table in ("claim", "motion"):
            at_s = time.time() - days * DAY_S
            JournalStore(folder, ROBOT).change(f"UPDATE {table} SET at = :at WHERE post = :post", at=at_s, post=post)
    return journal


def rows(folder: Path, query: str) -> list[str]:
    return [row[0] for row in JournalStore(folder, ROBOT).rows(query)]


async def test_law_6_claims_are_let_go_of_when_they_are_reported_and_old_and_open_ones_never(tmp_path: Path) -> None:
    posts = ("old", "open", "new")
    journal = await kept(tmp_path, *posts, reported=("old", "new"), aged={"old": 31, "open": 400, "new": 29})
    await journal.prune(30, 5000)
    assert rows(tmp_path, "SELECT post FROM claim ORDER BY number") == ["open", "new"]
    assert sorted(rows(tmp_path, "SELECT post FROM motion")) == ["new", "open"]
    assert await journal.move("open", says("again")) == "moved"  # and is not done again
    assert await journal.knows("new")
    await journal.close()


async def test_law_6_of_many_claims_the_newest_are_kept_and_all_of_the_last_day(tmp_path: Path) -> None:
    posts = tuple("abcdef")
    journal = await kept(tmp_path, *posts, reported=posts, aged=dict.fromkeys("abcd", 2.0))
    await journal.prune(30, 3)
    assert rows(tmp_path, "SELECT post FROM claim ORDER BY number") == ["d", "e", "f"]
    await journal.prune(30, 1)
    assert rows(tmp_path, "SELECT post FROM claim ORDER BY number") == ["e", "f"]
    await journal.close()


async def test_law_6_a_claim_of_the_last_day_is_kept_however_many_there_are(tmp_path: Path) -> None:
    posts = ("older", "younger", "new")
    journal = await kept(tmp_path, *posts, reported=posts, aged={"older": 1.1, "younger": 0.9})
    await journal.prune(30, 1)
    assert rows(tmp_path, "SELECT post FROM claim ORDER BY number") == ["younger", "new"]
    await journal.close()


async def test_law_6_what_was_cancelled_and_never_claimed_is_let_go_of_when_it_is_old(tmp_path: Path) -> None:
    journal = await kept(tmp_path, "claimed", reported=(), aged={})
    for post in ("old", "new"):
        await journal.cancel(post)
    at_s = time.time() - 31 * DAY_S
    for post in ("claimed", "old"):
        JournalStore(tmp_path, ROBOT).change("UPDATE motion SET at = :at WHERE post = :post", at=at_s, post=post)
    await journal.prune(30, 5000)
    assert sorted(rows(tmp_path, "SELECT post FROM motion")) == ["claimed", "new"]
    await journal.close()


async def test_an_approval_goes_with_its_claim(tmp_path: Path) -> None:
    journal = await open_journal(tmp_path, ROBOT)
    now = datetime.now(UTC)
    for post in ("old", "open"):
        await journal.claim(Command(post, "1", "h", ALICE, ROBOT, "wave", "en", now, "trace"))
        await journal.ask(post, now, now)
    await journal.finish("old", CommandState.REFUSED)
    for post in ("old", "open"):
        JournalStore(tmp_path, ROBOT).change("UPDATE claim SET at = 0 WHERE post = :post", post=post)
    await journal.prune(30, 5000)
    assert rows(tmp_path, "SELECT post FROM approval") == ["open"]
    await journal.close()


async def test_the_assessment_of_a_told_command_goes_and_of_an_open_one_stays(tmp_path: Path) -> None:
    journal = await kept(tmp_path, "reported", "open", reported=("reported",), aged={})
    assert rows(tmp_path, "SELECT post FROM assessment") == ["open"]
    await journal.prune(30, 5000)
    assert rows(tmp_path, "SELECT post FROM assessment") == ["open"]
    assert await journal.assess("open", says("another")) == "thought"
    assert await journal.move("reported", says("again")) == "moved"
    await journal.close()


async def test_another_version_assesses_again_and_moves_nothing_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    await (await kept(tmp_path, "open", reported=(), aged={})).close()
    monkeypatch.setattr(journal_module, "VERSION", "another")
    journal = await open_journal(tmp_path, ROBOT)
    assert await journal.assess("open", says("another")) == "another"
    assert await journal.move("open", says("again")) == "moved"
    await journal.close()


def test_records_and_pictures_go_by_age_size_and_number(tmp_path: Path) -> None:
    records = Records(tmp_path)
    for folder, name in (("records", "json"), ("pictures", "jpg")):
        (tmp_path / folder).mkdir()
        for n in range(6):
            path = tmp_path / folder / f"{n}.{name}"
            path.write_bytes(b"x" * 2**19)
            os.utime(path, times=(at_s := time.time() - n * DAY_S, at_s))

    def left(folder: str) -> list[str]:
        return sorted(path.stem for path in (tmp_path / folder).iterdir())

    records.prune(days=4.5, mb=100, commands=3)
    assert (left("records"), left("pictures")) == (["0", "1", "2"], ["0", "1", "2", "3", "4"])
    records.prune(days=4.5, mb=1, commands=3)
    assert (left("records"), left("pictures")) == (["0", "1"], ["0", "1"])


async def test_an_agent_lets_go_of_what_ended_while_it_serves(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retention, "FIRST_S", (0.0, 0.0))
    monkeypatch.setattr(retention, "EVERY_S", 0.05)
    scene.settings = scene.settings.model_copy(update={"retention": RetentionConfig(commands=1)})
    prune, rounds = retention.prune, asyncio.Semaphore(0)

    async def counted(*args: Any) -> None:
        await prune(*args)
        rounds.release()

    monkeypatch.setattr(retention, "prune", counted)
    async with scene.agent() as agent:

        def left() -> tuple[int, int, int]:
            assessments = rows(scene.folder, "SELECT post FROM assessment")
            claims = rows(scene.folder, "SELECT post FROM claim")
            return len(list((agent.folder / "records").iterdir())), len(assessments), len(claims)

        for _ in range(3):
            final = await scene.final(await scene.post("alice", "@quadruped turn left 10 degrees"))
            assert final.card.state == "done"
        async with asyncio.timeout(60):
            while left() != (1, 0, 3):  # all claims of today are kept
                await rounds.acquire()
            JournalStore(scene.folder, ROBOT).change("UPDATE claim SET at = at - :age_s", age_s=2 * DAY_S)
            while left() != (1, 0, 1):
                await rounds.acquire()


async def test_a_disk_that_fails_does_not_end_the_agent(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    tried = asyncio.Event()

    def fails(*_: object) -> None:
        tried.set()
        raise OSError("no such disk")

    monkeypatch.setattr(Records, "prune", fails)
    monkeypatch.setattr(retention, "FIRST_S", (0.0, 0.0))
    async with scene.agent():
        await asyncio.wait_for(tried.wait(), 60)
        assert (await scene.final(await scene.post("alice", "@quadruped turn left 10 degrees"))).card.state == "done"


async def test_an_agent_that_starts_answers_posts_before_it_prunes(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    pruned = []
    monkeypatch.setattr(retention, "FIRST_S", (1e3, 1e3))
    monkeypatch.setattr(Records, "prune", lambda *_: pruned.append(1))
    async with scene.agent():
        assert (await scene.final(await scene.post("alice", "@quadruped turn left 10 degrees"))).card.state == "done"
        assert not pruned
