"""A schedule on the real board: its first reply, two runs with replies of their own, and "cancel" in the thread."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.agent.queue.schedules import lost_right
from agentrob.board.admin import local_admin
from agentrob.config.forum import ForumConfig
from agentrob.config.robots import RobotConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from agentrob.model import Decision, Role, Verdict
from agentrob.robots.driver.client import DriverClient
from tests.agent.agent_process import Poster, RunningBoard
from tests.agent.agent_scene import ROBOT, Driver, robot_settings
from tests.board.running_board import running_board
from tests.waiting import until


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    with running_board(tmp_path_factory.mktemp("board")) as made:
        made.add("guest", role=Role.MEMBER)
        guest = local_admin.find_account(made.settings, "guest")
        local_admin.change_account(made.settings, guest, commands_simulated=True)
        yield made


def listed(board: RunningBoard) -> list[tuple[str, int, str]]:
    """Return post, number of runs and author of each schedule that the board lists."""
    items = board.client("op").get(f"/robots/{ROBOT}/schedules").json()["items"]
    return [(one["post_id"], len(one["runs"]), one["author"]) for one in items]


async def posts(poster: Poster, topic: str, count: int) -> list[dict[str, Any]]:
    """Wait until a topic has this many posts of the robot whose command has ended, or that are no command's."""
    async with asyncio.timeout(60):
        while True:
            items = (await asyncio.to_thread(poster._http.get, f"/topics/{topic}/posts")).json()["items"]
            ours = [item for item in items if item["author"]["name"] == ROBOT]
            ended = [i for i in ours if i["card"] is None or i["card"]["state"] in ("answered", "done", "failed")]
            if len(ended) >= count:
                return ended
            await asyncio.sleep(0.05)


async def none_kept(agent: RobotAgent) -> None:
    """Wait until the journal keeps no schedule: one that has ended is kept until its end is told."""
    await until(agent.journal.schedules, lambda kept: not kept)


async def page_of_run(board: RunningBoard, report: dict[str, Any], schedule: str) -> None:
    """Check that a run has a page, a record and a replay of its own, which its report links."""
    address = f"{board.url}/c/{report['id']}"
    assert f"]({address})" in report["raw"]
    client = board.client("op")
    (item,) = client.get(f"/commands/{report['id']}").json()["items"]
    assert (item["record"]["status"], item["record"]["run"]["number"]) == ("done", 2)
    assert item["record"]["trace_id"] == report["card"]["trace_id"]
    replay = f"/commands/{report['id']}/replay?robot={ROBOT}"
    await until(lambda: asyncio.to_thread(client.get, replay), lambda answer: answer.status_code == 200)
    page = board.browser("op").get(f"/c/{report['id']}").text
    assert "A run of the schedule that" in page
    assert f'href="/p/{schedule}"' in page
    assert "data-replay" in page or "Replay" in page


@pytest.mark.parametrize("author", ["op", "guest"])
async def test_a_schedule_runs_twice_on_the_board_and_is_cancelled_in_its_thread(
    board: RunningBoard, driver: Driver, tmp_path: Path, author: str
) -> None:
    """Also one of an account that may command only simulated robots."""
    forum, client = (
        BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT]),
        DriverClient(driver.name, driver.socket),
    )
    agent = RobotAgent(ROBOT, robot_settings(time_zone="Asia/Shanghai"), forum, client, RulesMind(), tmp_path)
    running = asyncio.create_task(agent.run())
    try:
        await asyncio.wait_for(agent.ready.wait(), 60)
        with Poster(board, author) as op:
            topic = await op.post(f"@{ROBOT} every hour walk 3 m")
            (first,) = await posts(op, topic, 1)
            assert "(Asia/Shanghai)" in first["raw"]
            for count in (2, 3):
                (kept,) = await agent.journal.schedules()
                at = kept.next_at
                assert at is not None
                await replace(agent.schedules, now=lambda at=at: at).step()
                ended = await posts(op, topic, count)
                assert [item["card"]["state"] for item in ended] == ["answered", *["done"] * (count - 1)]
            last = ended[-1]
            first_post = str(first["reply_to"])
            asked = board.client("op").get(f"/posts/{first_post}").json()
            assert f"Run 2 of at most 30 of [this schedule]({asked['url']}), due on " in last["raw"]
            await page_of_run(board, last, first_post)
            agent.schedules.changed()
            await until(lambda: asyncio.to_thread(listed, board), lambda found: found == [(first_post, 28, author)])
            await until(lambda: not len(agent.queue))
            await agent.schedules.load()
            said = await asyncio.to_thread(op._http.post, f"/topics/{topic}/posts", json={"body": "cancel"})
            said.raise_for_status()
            told = (await posts(op, topic, 4))[-1]
            assert (told["card"], "cancelled" in told["raw"]) == (None, True)
            await none_kept(agent)
            await until(lambda: asyncio.to_thread(listed, board), lambda found: found == [])
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await agent.close()


@pytest.mark.parametrize(
    ("rule", "decision", "lost"),
    [
        ("rights.operator", Decision.REFUSE, True),
        ("rights.move", Decision.REFUSE, True),
        ("rights.closed", Decision.REFUSE, False),
        ("rights.approval", Decision.NEEDS_APPROVAL, False),
        ("limit.speed", Decision.REFUSE, False),
    ],
)
def test_a_lost_right_ends_a_schedule_and_maintenance_does_not(rule: str, decision: Decision, lost: bool) -> None:
    assert lost_right(Verdict(decision, rule)) is lost
    assert not lost_right(None)


def test_an_unknown_zone_is_refused_with_valid_ones() -> None:
    with pytest.raises(ValueError, match="valid: UTC, or an IANA name such as Europe/Berlin"):
        RobotConfig(time_zone="Mars/Olympus")
