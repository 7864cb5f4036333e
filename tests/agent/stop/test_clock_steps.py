"""Stops while the forum's clock is set forward and back: none is weakened, and none blocks later posts."""

from __future__ import annotations

from pathlib import Path

import pytest

from agentrob.model import Role
from tests.agent.agent_scene import ROBOT, Driver, make_scene

AHEAD_S = 400 * 86_400.0


@pytest.mark.parametrize("restarted", [False, True])
async def test_law_14_a_stop_of_a_clock_that_leapt_ahead_blocks_nothing_later(
    driver: Driver, tmp_path: Path, restarted: bool
) -> None:
    scene = make_scene(driver, tmp_path)
    scene.world.clock_offset_s = AHEAD_S
    async with scene.agent() as agent:
        stop = await scene.post("bob", "@quadruped stop")
        await scene.until(lambda: scene.replies(stop))
        scene.world.clock_offset_s = 0.0
        if not restarted:
            await scene.final(await scene.post("alice", "@quadruped wave"))  # with this event the agent notices it
            await agent.clock.compare()
            assert (await scene.final(await scene.post("alice", "@quadruped wave"))).card.state == "done"
    if restarted:
        async with scene.agent():
            assert (await scene.final(await scene.post("alice", "@quadruped wave"))).card.state == "done"


async def test_law_14_a_stop_ends_what_moves_though_the_clock_was_set_back(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)
    async with scene.agent():
        walk = await scene.post("alice", "@quadruped walk forward 5 m slowly")
        await scene.state(walk, "running")
        scene.world.clock_offset_s = -3600.0
        await scene.post("bob", "stop", topic=walk.topic_id)
        assert (await scene.final(walk)).card.state == "stopped"


async def test_law_14_a_clock_that_leaps_while_the_agent_listens_blocks_nothing_and_is_reported(
    driver: Driver, tmp_path: Path
) -> None:
    scene = make_scene(driver, tmp_path)
    async with scene.agent():
        assert (await scene.final(await scene.post("alice", "@quadruped wave"))).card.state == "done"
        scene.world.clock_offset_s = AHEAD_S
        stop = await scene.post("bob", "@quadruped stop")
        (reply,) = await scene.until(lambda: scene.replies(stop))
        assert "The forum's clock was just set ahead by 400 days." in reply.raw
        assert "400 d" not in reply.raw.replace("by 400 days.", "")
        scene.world.clock_offset_s = 0.0
        stop = await scene.post("bob", "@quadruped 停", topic=None)
        await scene.until(lambda: scene.replies(stop))
        assert (await scene.final(await scene.post("alice", "@quadruped wave"))).card.state == "done"


async def test_law_14_what_a_stop_ended_while_the_clock_was_set_is_reported_so(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)
    scene.world.clock_offset_s = -600.0
    async with scene.agent():
        await scene.final(await scene.post("alice", "@quadruped wave"))
    scene.world.clock_offset_s = 0.0
    await scene.post("bob", "@quadruped stop")
    scene.world.clock_offset_s = -60.0  # both arrive at once, and by the clock the command came first
    wave = await scene.post("alice", "@quadruped wave")
    greeting = await scene.post("alice", "@quadruped 挥手")
    async with scene.agent():
        said = await scene.final(wave)
        assert said.card.state == "cancelled"
        assert "the forum's clock has been set since, so I cannot tell which came first" in said.raw
        assert "论坛的时钟此后被调整过" in (await scene.final(greeting)).raw
        assert (await scene.final(await scene.post("alice", "@quadruped wave"))).card.state == "done"


async def test_law_14_the_owner_s_release_clears_a_stop_of_the_future_and_says_so(
    driver: Driver, tmp_path: Path
) -> None:
    scene = make_scene(driver, tmp_path, owner="olga")
    olga = scene.person("olga", Role.MEMBER)
    async with scene.agent():
        scene.world.clock_offset_s = AHEAD_S
        stop = await scene.post("bob", "@quadruped stop")
        await scene.until(lambda: scene.replies(stop))
        scene.world.clock_offset_s = 0.0
        await olga.press_release(ROBOT)
        card = await scene.until(lambda: (scene.world.robots.get(ROBOT) or {}).get("last_action"))
        assert card["done"]
        assert "It was not locked. Its last stop bore a time in the future (2" in card["message"]
        assert " UTC); it no longer holds back commands." in card["message"]
        assert (await scene.final(await scene.post("alice", "@quadruped wave"))).card.state == "done"
