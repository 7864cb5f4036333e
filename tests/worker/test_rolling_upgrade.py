"""A new worker replaces an old one while a command moves the robot and another one waits."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Sequence

import pytest

from agentrob.agent.store.journals import make_journals
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.model import Command
from agentrob.wiring import app
from tests.agent.agent_process import Poster
from tests.agent.agent_scene import ROBOT
from tests.agent.store.journal_store import database_of
from tests.agent.store.old_journal import write_old_journal
from tests.board.running_board import RunningBoard
from tests.worker.worker_processes import LIMIT_S, Workers, until_state

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("database")]
WALK, WAVE = f"@{ROBOT} walk 2 m", f"@{ROBOT} wave"


def steps(workers: Workers) -> list[str]:
    """How each step ended that reached the robot; no command's more than once."""
    ledger = workers.ledger()
    begun = Counter(line["holder"] for line in ledger if line["what"] == "begun")
    assert set(begun.values()) == {1}, "each command has one step"
    return [line["outcome"] for line in ledger if line["what"] == "ended"]


@pytest.mark.parametrize(("how", "ends"), [("drain", "done"), ("terminate", "interrupted")])
async def test_law_6_the_command_that_moves_ends_once_and_the_one_that_waits_is_continued(
    workers: Workers, board: RunningBoard, how: str, ends: str
) -> None:
    with (
        Poster(board, "op") as op,
        workers.running("--all", "--name", "old") as old,
        workers.running("--all", "--standby", "--name", "new") as new,
    ):
        moving = await op.post(WALK)
        await until_state(op, moving, "running")
        waiting = await op.post(WAVE)
        await until_state(op, waiting, "queued")
        if how == "drain":
            assert "ended" in (await asyncio.to_thread(list, app.drain_workers(["old"])))[-1]
        else:
            old.terminate()
        assert await asyncio.to_thread(old.wait, LIMIT_S) == 0
        assert await op.final(moving) == [ends]
        assert new.stdout is not None
        assert ROBOT in await asyncio.to_thread(new.stdout.readline)
        assert await op.final(waiting) == ["done"]
        assert await op.states(moving) == [ends], "the new worker tells no other end"
    assert steps(workers) == ["done" if ends == "done" else "stopped", "done"]


async def commands_of(board: RunningBoard, topics: Sequence[str]) -> list[Command]:
    """The first posts of these topics as an agent claims them."""
    forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
    posts = [(await forum.posts(topic)).items[0] for topic in topics]
    await forum.close()
    return [
        Command(
            p.id, p.topic_id, p.content_hash, p.author, ROBOT, p.raw.partition(" ")[2], "en", p.created_at, f"t{p.id}"
        )
        for p in posts
    ]


async def test_law_6_a_journal_of_version_0_1_with_a_motion_pending_is_continued(
    workers: Workers, board: RunningBoard
) -> None:
    """Version 0.1 has claimed two commands and was killed during the first motion."""
    forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
    cursor, now_at = await forum.now()
    await forum.close()
    with Poster(board, "op") as op:
        moving, waiting = await op.post(WALK), await op.post(WAVE)
        walk, wave = await commands_of(board, [moving, waiting])
        values = {"cursor": cursor, "cursor_at": now_at.isoformat(), "watermark": now_at.isoformat()}
        write_old_journal(workers.folder, ROBOT, walk, wave, begun=(walk.post_id,), **values)
        with workers.running("--all", "--name", "new"):
            assert await op.final(moving) == ["interrupted"]
            assert await op.final(waiting) == ["done"], await op.status_text(waiting)
            # it writes down that it has answered a moment after the answer
            assert "ended" in (await asyncio.to_thread(list, app.drain_workers(["new"])))[-1]
    assert steps(workers) == ["done"]
    journals = make_journals(database_of(workers.folder), workers.folder)
    journal = await journals.open(ROBOT)
    assert not await journal.open_claims()
    await journal.close()
    await journals.close()
