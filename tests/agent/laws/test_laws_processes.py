"""A robot's agent on one server process of a forum and people on another: a stop arrives, and silence stops the
robot."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from tests.agent.agent_process import until_state
from tests.agent.agent_scene import ROBOT, Driver, robot_settings
from tests.agent.store.journal_store import open_journal
from tests.board.board_processes import Forum, forum_of, fresh_postgres
from tests.waiting import until

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("database")]


@pytest.fixture(scope="module")
def forum(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forum]:
    with fresh_postgres() as url, forum_of(url, tmp_path_factory.mktemp("forum")) as made:
        yield made


@pytest.fixture
def slow_driver(tmp_path: Path) -> Iterator[Driver]:
    made = Driver(tmp_path, robot_settings(options={"time_scale": 1}), name="slow")
    yield made
    made.end()


@asynccontextmanager
async def walking(forum: Forum, driver: Driver, folder: Path) -> AsyncIterator[str]:
    """Return the topic of a command that was posted on process a while the agent reads process b."""
    own = BoardForum(ForumConfig(url=forum.b.url), forum.tokens[ROBOT])
    opened = partial(open_journal, folder, ROBOT)
    agent = RobotAgent(ROBOT, driver.settings, own, driver.client(), RulesMind(), folder, open_journal=opened)
    running = asyncio.create_task(agent.run())
    try:
        await asyncio.wait_for(agent.ready.wait(), 60)
        content = {"board_id": "robots", "title": "Walk", "body": f"@{ROBOT} walk forward 4 m, then walk backward 4 m"}
        made = await asyncio.to_thread(forum.as_("op", forum.a).post, "/topics", json=content)
        await until_state(driver, lambda state: state.pose.x_m > 0.5)
        yield str(made.raise_for_status().json()["topic"]["id"])
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await agent.close()


async def states(forum: Forum, topic: str) -> list[str]:
    items = (await asyncio.to_thread(forum.as_("op", forum.a).get, f"/topics/{topic}/posts")).json()["items"]
    return [item["card"]["state"] for item in items if item["card"]]


async def stands(driver: Driver) -> None:
    await until_state(driver, lambda state: state.velocity_mps == (0.0, 0.0))


async def test_law_14_a_stop_pressed_on_one_process_stops_the_robot_whose_agent_is_on_another(
    forum: Forum, slow_driver: Driver, tmp_path: Path
) -> None:
    async with walking(forum, slow_driver, tmp_path) as topic:
        member = forum.as_("member", forum.a)
        pressed_s = time.monotonic()
        await asyncio.to_thread(member.post, f"/robots/{ROBOT}/stop")
        await stands(slow_driver)
        assert time.monotonic() - pressed_s < 3.0, "the stop and the braking, on a busy machine"
        await until(lambda: states(forum, topic), lambda found: found == ["stopped"])


async def test_law_16_a_robot_stops_by_itself_when_its_process_cannot_hear_the_others(
    forum: Forum, slow_driver: Driver, tmp_path: Path
) -> None:
    async with walking(forum, slow_driver, tmp_path):
        gone_s = time.monotonic()
        with forum.database_blocked():
            await stands(slow_driver)
            took = time.monotonic() - gone_s
        assert took < 6.0, "a second until there is no beat, two of silence, and the braking, on a busy machine"
