"""An agent that was off for longer than the forum keeps events: no post is lost silently, and none is carried out
twice."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.board.admin import retention
from agentrob.config.board import BoardRetentionConfig
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from tests.agent.agent_process import Poster, RunningBoard, until_state
from tests.agent.agent_scene import ROBOT, Driver, robot_settings, serving
from tests.agent.store.journal_store import JournalStore, open_journal
from tests.board.running_board import running_board


@pytest.fixture
def board(tmp_path: Path) -> Iterator[RunningBoard]:
    with running_board(tmp_path / "board") as made:
        yield made


@asynccontextmanager
async def agent_of(board: RunningBoard, driver: Driver, folder: Path) -> AsyncIterator[RobotAgent]:
    forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
    opened = partial(open_journal, folder, ROBOT)
    agent = RobotAgent(ROBOT, robot_settings(), forum, driver.client(), RulesMind(), folder, open_journal=opened)
    async with serving(agent):
        yield agent


def forget(board: RunningBoard, all_but: int) -> None:
    """Delete all events of the board but the newest, as after a month."""
    keep = BoardRetentionConfig(events=all_but)
    job = partial(retention.prune_events, keep=keep, now=datetime.now(UTC) + timedelta(days=31))
    while board.run(board.services.store.do(job)):
        pass


async def test_law_6_events_that_are_not_kept_any_more_cost_no_command_its_answer(
    board: RunningBoard, driver: Driver, tmp_path: Path
) -> None:
    with Poster(board, "op") as op:
        async with agent_of(board, driver, tmp_path) as agent:
            first = await op.post(f"@{ROBOT} wave")
            assert await op.final(first) == ["done"]
            cut_off = await op.post(f"@{ROBOT} walk forward 5 metres slowly")
            await until_state(driver, lambda state: state.mode == "walking")
            agent.queue.close()
        lost = await op.post(f"@{ROBOT} walk forward 1 metre")
        for _ in range(6):
            await op.post("nothing for a robot")
        fresh = await op.post(f"@{ROBOT} wave")
        forget(board, all_but=4)
        async with agent_of(board, driver, tmp_path) as agent:
            assert await op.final(fresh) == ["done"]
            assert await op.final(lost) == ["expired"]
            assert await op.final(cut_off) == ["interrupted"]
            assert await op.final(await op.post(f"@{ROBOT} wave")) == ["done"]
            assert await op.states(first) == ["done"]
            set_aside = "SELECT post FROM claim WHERE post LIKE 'before-%'"
            assert JournalStore(tmp_path, ROBOT).rows(set_aside) == []  # it is still the same forum
