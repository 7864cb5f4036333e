"""Agents that die while a part waits: the wait goes on, and each post is summed up once (law 6)."""

from __future__ import annotations

import asyncio

import pytest

from agentrob.agent.joint.summaries import PartSummaries
from agentrob.agent.store.journal import Journal
from agentrob.model import Command
from tests.agent.joint.joint_scene import JointScene
from tests.agent.joint.test_waits import THEN, state

pytestmark = pytest.mark.usefixtures("database")


async def test_law_6_a_wait_goes_on_after_a_restart(scene: JointScene) -> None:
    async with scene.agents("quadruped"):
        pass  # its first start: what was posted before does not move it
    async with scene.agents("humanoid"):
        post = await scene.post(THEN)
        await scene.shows(post, 2, "queued")
    scene.world.clock_offset_s = 30.0
    async with scene.agents():
        assert state(await scene.ends(post, 2)) == "done"
        summary = await scene.summary(post)
    assert summary.raw.startswith("2 of 2 done:")
    assert len([p for p in scene.replies(post) if p.card and p.card.part == 2]) == 1


@pytest.mark.parametrize(("name", "when"), [("begin_wait", "after"), ("end_wait", "before"), ("end_wait", "after")])
async def test_law_6_killed_at_any_write_of_a_wait_the_part_moves_once(
    scene: JointScene, monkeypatch: pytest.MonkeyPatch, name: str, when: str
) -> None:
    """The agent runs in this process; where it dies, its write never returns."""
    original, dead = getattr(Journal, name), asyncio.Event()

    async def dies(self: Journal, *args: object) -> object:
        if when == "after":
            await original(self, *args)
        dead.set()
        return await asyncio.Event().wait()

    async with scene.agents("quadruped"):
        with monkeypatch.context() as patched:
            patched.setattr(Journal, name, dies)
            async with scene.agents("humanoid"):
                post = await scene.post(THEN)
                async with asyncio.timeout(60):
                    await dead.wait()
        async with scene.agents("humanoid"):
            assert state(await scene.ends(post, 2)) == "done"
            await scene.summary(post)
    running = [e for e in scene.world.events if e.post and e.post.card and e.post.card.part == 2 and e.post.card.doing]
    assert len({e.post.version for e in running if e.post}) <= 1


@pytest.mark.parametrize("when", ["before", "after"])
async def test_law_6_a_post_is_summed_up_once_also_where_the_agent_dies_beside_it(
    scene: JointScene, monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    dead = asyncio.Event()

    async def dies_after(self: Journal, key: str) -> None:
        dead.set()
        await asyncio.Event().wait()

    async def dies_before(self: PartSummaries, command: Command) -> bool:
        posts = await self.threads.read_or_known(command)
        if sum(p.card is not None and p.card.is_final for p in posts) == 2:
            dead.set()
            await asyncio.Event().wait()
        return False

    with monkeypatch.context() as patched:
        if when == "after":
            patched.setattr(Journal, "set_summary_reported", dies_after)
        else:
            patched.setattr(PartSummaries, "_sum_up", dies_before)
        async with scene.agents():
            post = await scene.post(THEN)
            async with asyncio.timeout(60):
                await dead.wait()
    async with scene.agents() as agents:
        await scene.summary(post)
        async with asyncio.timeout(60):
            while await agents[0].journal.summaries():
                await scene.world.wait(0.05)
    assert len(scene.summaries(post)) == 1
