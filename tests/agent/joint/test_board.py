"""Robots that wait for each other on the real board: two agents, each with its own account and driver, over HTTP."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind
from tests.agent.agent_process import Poster, RunningBoard
from tests.agent.agent_scene import Driver, robot_settings, serving
from tests.board.running_board import running_board


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    with running_board(tmp_path_factory.mktemp("board")) as made:
        made.add("humanoid", kind=AccountKind.ROBOT_AGENT)
        yield made


@asynccontextmanager
async def agents(board: RunningBoard, drivers: dict[str, Driver], folder: Path) -> AsyncIterator[None]:
    async with AsyncExitStack() as stack:
        for name, driver in drivers.items():
            forum = BoardForum(ForumConfig(url=board.url), board.tokens[name])
            agent = RobotAgent(name, robot_settings(), forum, driver.client(), RulesMind(), folder)
            await stack.enter_async_context(serving(agent))
            async with asyncio.timeout(60):
                await agent.ready.wait()
        yield


async def summed_up(poster: Poster, topic: str) -> list[dict[str, Any]]:
    """Wait for the reply that sums up, and return the posts of the topic."""
    async with asyncio.timeout(60):
        while True:
            items = (await asyncio.to_thread(poster._http.get, f"/topics/{topic}/posts")).json()["items"]
            if any(" done:" in item["raw"] for item in items):
                return list(items)
            await asyncio.sleep(0.05)


async def test_parts_follow_one_another_on_the_board_and_one_of_two_robots_does_the_last(
    board: RunningBoard, drivers: dict[str, Driver], tmp_path: Path
) -> None:
    async with agents(board, drivers, tmp_path):
        with Poster(board, "op") as op:
            topic = await op.post(
                "@quadruped walk forward 0.3 m, then @humanoid wave. After that, one of you take a photo."
            )
            posts = await summed_up(op, topic)
    cards = [post["card"] for post in posts if post["card"]]
    assert [post["raw"].splitlines()[0] for post in posts if " done:" in post["raw"]] == ["3 of 3 done:"]
    assert {(c["part"], c["robot"]) for c in cards if c["state"] == "done" and c["part"] < 3} == {
        (1, "quadruped"), (2, "humanoid")
    }  # fmt: skip
    (taker,) = [card["robot"] for card in cards if card.get("takes")]
    last = {card["robot"]: card for card in cards if card["part"] == 3 and not card.get("takes")}
    assert last[taker]["state"] == "done"
    other = ({"quadruped", "humanoid"} - {taker}).pop()
    assert (last[other]["state"], last[other]["left_to"]) == ("cancelled", taker)
