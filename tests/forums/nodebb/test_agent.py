"""The agent on NodeBB, against a recording: a post comes in, the robot moves, a reply goes out.

The agent is the real one; the forum replays recorded responses. So the tests assert what the robot did and what the
agent sent. `test_agent_live.py` does the same with a real NodeBB.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.forums.nodebb.markers import MarkedText, unmark
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, Role
from tests.agent.agent_scene import FINAL, ROBOT, Driver, robot_settings, serving
from tests.forums.nodebb.nodebb_world import NodeBBWorld


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    # Slower than in other tests: on a busy machine, fast motion looks like jumps of the odometry.
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings(options={"time_scale": 2}))
    yield made
    made.end()


@asynccontextmanager
async def serving_robot(nodebb: NodeBBWorld, driver: Driver, folder: Path, **more: Any) -> AsyncIterator[None]:
    forum = await nodebb.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)
    agent = RobotAgent(ROBOT, robot_settings(**more), forum, driver.client(), RulesMind(), folder)
    async with serving(agent):
        yield


async def _status_post(nodebb: NodeBBWorld, *states: str) -> MarkedText:
    """Return the robot account's post that shows one of these states."""
    return await _sent_post(nodebb, lambda final_post: final_post.card is not None and final_post.card.state in states)


async def _sent_post(nodebb: NodeBBWorld, wanted: Callable[[MarkedText], bool]) -> MarkedText:
    """Return the robot account's first post that meets a condition."""
    async with asyncio.timeout(60):
        while True:
            for who, what, body in nodebb.server.sent:
                if (
                    who == ROBOT
                    and b"content" in body
                    and what.startswith(("PUT /api/v3/posts/", "POST /api/v3/topics/"))
                    and wanted(final_post := unmark(json.loads(body)["content"]))
                ):
                    return final_post
            await asyncio.sleep(0.05)


async def _final(nodebb: NodeBBWorld) -> MarkedText:
    return await _status_post(nodebb, *FINAL)


async def test_a_post_moves_the_robot_and_the_report_is_sent(
    nodebb: NodeBBWorld, driver: Driver, tmp_path: Path
) -> None:
    alice = await nodebb.sign_in("alice", role=Role.OPERATOR)
    async with serving_robot(nodebb, driver, tmp_path), driver.client() as body:
        before = (await body.state()).pose
        post = (await alice.create_topic("robots", "A walk", f"@{ROBOT} walk forward 1 m", key="walk")).post
        claim = await _status_post(nodebb, "seen")
        done = await _final(nodebb)
        after = (await body.state()).pose
    assert (done.card and done.card.state) == "done", done.text
    assert claim.key == f"claim:{post.id}"
    assert "| walk forward 1 m |" in done.text
    assert done.key == claim.key, "the status post is edited in place"
    assert done.pictures, "the path is shown"
    assert before is not None
    assert after is not None
    assert 0.8 < abs(after.x_m - before.x_m) + abs(after.y_m - before.y_m) < 1.3


async def test_law_2_on_nodebb_a_member_moves_nothing(nodebb: NodeBBWorld, driver: Driver, tmp_path: Path) -> None:
    bob = await nodebb.sign_in("bob")
    async with serving_robot(nodebb, driver, tmp_path), driver.client() as body:
        before = (await body.state()).pose
        await bob.create_topic("robots", "A walk", f"@{ROBOT} walk forward 1 m", key="walk")
        final_post = await _final(nodebb)
        assert (await body.state()).pose == before
    assert "rights.operator" in final_post.text


async def test_law_7_a_moderator_of_nodebb_approves_what_an_operator_asked(
    nodebb: NodeBBWorld, driver: Driver, tmp_path: Path
) -> None:
    alice = await nodebb.sign_in("alice", role=Role.OPERATOR)
    bob = await nodebb.sign_in("bob", role=Role.OPERATOR)
    carol = await nodebb.sign_in("carol", role=Role.MODERATOR)
    async with serving_robot(nodebb, driver, tmp_path, approval={"classes": ["gesture"]}):
        post = (await alice.create_topic("robots", "A wave", f"@{ROBOT} wave", key="wave")).post
        await _sent_post(nodebb, lambda sent: "**Preview: nothing moved.**" in sent.text)
        await bob.reply(post.topic_id, f"@{ROBOT} approve", key="no")
        await _sent_post(nodebb, lambda final_post: final_post.card is None and "approve" in final_post.text)
        await carol.reply(post.topic_id, f"@{ROBOT} approve", key="yes")
        done = await _status_post(nodebb, "done")
    assert "Approved by `carol`" in done.text
    assert "Preview and measured: " in done.text
