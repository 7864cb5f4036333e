"""Stops while the forum's clock is set forward and back: none is weakened, and none blocks what is posted later."""

from __future__ import annotations

from pathlib import Path

import pytest
from agent_scene import Driver, make_scene

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
            await scene.final(await scene.post("alice", "@quadruped wave"))  # by this one the agent notices
            await agent._compare_clocks()
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
