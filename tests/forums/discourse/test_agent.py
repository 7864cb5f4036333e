"""A robot's agent on a Discourse, end to end: it reads, screens, moves, reports and stops."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.forums.discourse.forum import DiscourseForum
from agentrob.forums.discourse.markers import unmark
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, Post, Role
from tests.agent.agent_scene import FINAL, ROBOT, Driver, robot_settings, serving
from tests.doubles.discourse.site import DEFAULTS
from tests.forums.discourse.discourse_world import DiscourseWorld, Double, double_world


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings())
    yield made
    made.end()


@asynccontextmanager
async def served(world: DiscourseWorld, driver: Driver, folder: Path, **more: Any) -> AsyncIterator[DiscourseForum]:
    """Run a robot's agent on that Discourse until the block ends; the forum is the robot's."""
    forum = await world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)
    settings = robot_settings(**more)
    agent = RobotAgent(
        name=ROBOT, settings=settings, forum=forum, driver=driver.client(), mind=RulesMind(), data=folder
    )
    async with serving(agent):
        yield forum


async def answer(reader: DiscourseForum, post: Post, states: set[str], limit_s: float = 60.0) -> Post:
    """Wait until the robot's reply to a post shows one of these states."""
    after, _ = await reader.now()
    async with asyncio.timeout(limit_s):
        async for _ in reader.stream(after, 0.25):
            for found in (await reader.posts(post.topic_id)).items:
                if found.reply_to == post.id and found.card and found.card.state in states:
                    return found
    raise AssertionError("the stream ended")


async def test_a_command_is_executed_and_reported_and_another_one_stopped(driver: Driver, tmp_path: Path) -> None:
    async with double_world() as (world, double):
        alice, bob = await world.sign_in("alice", role=Role.OPERATOR), await world.sign_in("bob")
        async with served(world, driver, tmp_path):
            walk = (await alice.create_topic("robots", "A walk", "@quadruped walk forward 1 m", key="1")).post
            done = await answer(alice, walk, FINAL)
            assert done.card is not None
            assert (done.card.state, done.author.name) == ("done", ROBOT)
            refused = (await bob.create_topic("robots", "Bob walks", "@quadruped walk forward 1 m", key="2")).post
            assert (await answer(bob, refused, FINAL)).card.state == "refused"  # type: ignore[union-attr]
            far = (
                await alice.create_topic("robots", "Farther", "@quadruped walk forward 5 m, then back", key="3")
            ).post
            await answer(alice, far, {"running"})
            await bob.reply(far.topic_id, "@quadruped stop", key="4")
            assert (await answer(alice, far, FINAL)).card.state == "stopped"  # type: ignore[union-attr]
        _told_once(double)


async def test_law_7_a_command_with_a_preview_is_carried_out_and_ends_after_its_approval(
    driver: Driver, tmp_path: Path
) -> None:
    async with double_world() as (world, double):
        alice, carol = (
            await world.sign_in("alice", role=Role.OPERATOR),
            await world.sign_in("carol", role=Role.ADMIN),
        )
        async with served(world, driver, tmp_path, approval={"classes": ["move"]}):
            walk = (await alice.create_topic("robots", "A walk", "@quadruped walk forward 0.3 m", key="1")).post
            while True:
                shown = await answer(alice, walk, {"waiting"})
                if "**Preview: nothing moved.**" in shown.raw:
                    break
            assert len(shown.images) == 1
            await carol.reply(walk.topic_id, "@quadruped approve", key="2")
            done = await answer(alice, walk, FINAL)
            assert done.card is not None
            assert done.card.state == "done", done.raw
            assert "Preview and measured: " in done.raw
        _told_once(double)


@pytest.mark.slow  # it waits as long as an unmodified Discourse requires
async def test_law_6_with_default_limits_each_command_is_answered_once(driver: Driver, tmp_path: Path) -> None:
    """The robot works with Discourse's default limits (posts, edits, 60 requests a minute) and with polling; only the
    people's limits are lifted."""
    async with double_world(requests_per_minute=60) as (world, double):
        alice = world.at(world.url, f"system:{double.site.add_key()}", requests_per_minute=100_000)
        own = double.site.add_key()
        await world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)
        limits = {k: v for k, v in DEFAULTS.items() if "title" not in k}
        world.key, before = own, dict(double.site.settings)
        async with served(world, driver, tmp_path) as forum:
            assert not forum.live
            double.site.settings.update(limits)
            double.site.settings["max_admin_api_reqs_per_minute"] = 0
            posts = [
                (
                    await alice.create_topic("robots", f"A walk {n}", "@quadruped walk forward 1 m, please", key=str(n))
                ).post
                for n in range(2)
            ]
            double.site.settings["max_admin_api_reqs_per_minute"] = 60
            async with asyncio.timeout(150):
                while len(_finals(double)) < len(posts):
                    await _written(double)
        assert {p.reply_to for p in _finals(double)} == {1}
        double.site.settings.update(before)
        _told_once(double)


def _finals(double: Double) -> list[object]:
    found = ((p, unmark(p.raw).card) for p in double.site.posts.values())
    return [p for p, card in found if card is not None and card.state in FINAL]


async def _written(double: Double) -> None:
    """Wait until a message is published on the message bus."""
    waiting = asyncio.Event()
    double.site.bus._waiting.add(waiting)
    try:
        await waiting.wait()
    finally:
        double.site.bus._waiting.discard(waiting)


def _told_once(double: Double) -> None:
    """Assert that no two posts of the robot have the same key."""
    robot = double.site.named(ROBOT)
    assert robot is not None
    keys = [unmark(p.raw).key for p in double.site.posts.values() if p.user == robot.id]
    assert keys
    assert len(keys) == len(set(keys))
