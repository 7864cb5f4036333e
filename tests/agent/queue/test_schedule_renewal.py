"""A schedule that ended by the limit of runs or days is renewed by a reply of its author, once."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.agent.queue.schedules import continued
from agentrob.agent.store.rows import KeptSchedule
from agentrob.model import Post, Role
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene
from tests.agent.queue.test_schedules import HOUR, ended, finals, next_at_of, posted, run_of, state, steps

pytestmark = pytest.mark.usefixtures("database")
DAY = timedelta(days=1)


@pytest.fixture
def scene(driver: Driver, tmp_path: Path) -> Scene:
    return make_scene(driver, tmp_path, time_zone="Europe/Berlin")


@asynccontextmanager
async def limited(scene: Scene, text: str = "every hour wave") -> AsyncIterator[tuple[RobotAgent, Post]]:
    """An agent, and a schedule of Alice's that has run as often as any may: the time of its runs passes while the robot
    is away."""
    async with scene.agent():
        post = await posted(scene, text)
    scene.world.clock_offset_s += 40 * 3600.0
    async with scene.agent() as agent:
        told = await scene.until(lambda: ended(scene, post))
        assert "keep on" in told[-1] or "继续" in told[-1]
        await scene.until(lambda: not len(agent.queue))
        await agent.schedules.load()
        yield agent, post


async def answer(scene: Scene, post: Post) -> str:
    """Wait for the reply to a post that renews; return its text."""
    found: list[Post] = await scene.until(lambda: [p for p in scene.replies(post) if p.author.name == ROBOT])
    assert len(found) == 1
    return found[0].raw


async def kept_of(agent: RobotAgent, post: Post) -> KeptSchedule:
    kept = await agent.journal.schedule(post.id)
    assert kept is not None
    return kept


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        ("every hour wave", "keep on", "Renewed: wave."),
        ("every hour wave", f"@{ROBOT} please keep it going", "Renewed: wave."),
        ("每小时挥手", "继续", "已续期：挥手。"),
        ("每小时挥手", "继续吧。", "已续期：挥手。"),
    ],
)
async def test_its_author_renews_a_schedule_for_as_many_runs_again(
    scene: Scene, text: str, words: str, said: str
) -> None:
    async with limited(scene, text) as (agent, post):
        before = len(finals(scene, post))
        asks = await scene.post("alice", words, topic=post.topic_id)
        assert said in await answer(scene, asks)
        kept = await kept_of(agent, post)
        assert (kept.ended, kept.runs_left, kept.asked.renewed_by) == (None, 30, asks.id)
        assert kept.next_at is not None
        assert asks.created_at < kept.next_at <= asks.created_at + HOUR + timedelta(seconds=1)
        assert kept.asked.schedule.until_at - asks.created_at >= timedelta(days=59)
        await steps(agent, kept.next_at)
        done = await run_of(scene, post, before)
        assert state(done) == "done"
        assert "1 of at most 30" in done.raw or "第1次运行（最多30次）" in done.raw


async def test_a_renewed_schedule_that_ends_again_says_so_again(scene: Scene) -> None:
    async with limited(scene) as (agent, post):
        asks = await scene.post("alice", "keep on", topic=post.topic_id)
        await answer(scene, asks)
        await steps(agent, await next_at_of(agent, post) + 40 * HOUR)
        found = await scene.until(lambda: [p for p in scene.replies(post) if p.key == f"schedule:{post.id}:{asks.id}"])
        assert "keep on" in found[0].raw


async def test_law_1_nobody_else_renews_it_and_is_told_who_can(scene: Scene) -> None:
    scene.person("carol", Role.OPERATOR)
    async with limited(scene) as (agent, post):
        for who in ("bob", "carol"):
            asks = await scene.post(who, "keep on", topic=post.topic_id)
            assert "Only `alice` can renew" in await answer(scene, asks)
        assert (await kept_of(agent, post)).ended == "limit"


async def test_law_2_an_author_who_lost_the_right_renews_nothing(scene: Scene) -> None:
    async with limited(scene) as (agent, post):
        scene.world.set_role("alice", Role.MEMBER)
        asks = await scene.post("alice", "keep on", topic=post.topic_id)
        assert "may not command me" in await answer(scene, asks)
        assert (await kept_of(agent, post)).ended == "limit"


async def test_law_4_an_edit_after_the_last_run_leaves_nothing_to_renew(scene: Scene) -> None:
    async with limited(scene) as (agent, post):
        await scene.world.sign_in("alice").edit(post.id, f"@{ROBOT} every hour walk 5 m")
        async with asyncio.timeout(60):
            while (await kept_of(agent, post)).ended == "limit":
                await scene.world.wait(0.05)
        await agent.schedules.load()
        assert agent.schedules.renewable_topics == frozenset()
        assert len(ended(scene, post)) == 1, "its end is told once"


async def test_law_5_a_renewal_that_is_read_late_is_answered_and_renews_nothing(scene: Scene) -> None:
    async with limited(scene) as (_, post):
        pass
    asks = await scene.post("alice", "keep on", topic=post.topic_id)
    scene.world.clock_offset_s += 600.0
    async with scene.agent() as agent:
        assert "too late" in await answer(scene, asks)
        assert (await kept_of(agent, post)).ended == "limit"


async def test_law_14_a_stop_after_a_renewal_ends_the_schedule(scene: Scene) -> None:
    async with limited(scene) as (_, post):
        asks = await scene.post("alice", "keep on", topic=post.topic_id)
        await answer(scene, asks)
        await scene.post("bob", f"@{ROBOT} stop")
        await scene.until(lambda: [said for said in ended_all(scene, post) if "stopped" in said])


def ended_all(scene: Scene, post: Post) -> list[str]:
    return [p.raw for p in scene.replies(post) if (p.key or "").startswith(f"schedule:{post.id}")]


async def test_keep_on_while_nothing_has_ended_is_no_renewal(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        await agent.schedules.load()
        before = await kept_of(agent, post)
        asks = await scene.post("alice", f"@{ROBOT} keep on", topic=post.topic_id)
        assert state(await scene.final(asks)) != "done"
        assert await kept_of(agent, post) == before


async def test_a_reply_to_one_of_two_schedules_renews_or_cancels_that_one(scene: Scene) -> None:
    async with limited(scene) as (agent, one):
        other = await scene.post("alice", f"@{ROBOT} every hour sit", topic=one.topic_id)
        first = await scene.final(other)
        await scene.until(lambda: not len(agent.queue))
        await agent.schedules.load()
        await scene.post("alice", "keep on", topic=one.topic_id)
        await scene.until(lambda: agent.schedules.card and len(agent.schedules.card["schedules"]) == 2)
        await scene.until(lambda: not len(agent.queue))  # while a post is processed, "cancel" is a stop
        await scene.post("bob", "cancel", topic=one.topic_id, reply_to=first.id)
        await scene.until(lambda: ended(scene, other))
        assert (await kept_of(agent, other)).ended == "cancelled"
        assert (await kept_of(agent, one)).ended is None


async def test_an_end_that_the_author_named_stays_when_a_schedule_is_renewed(scene: Scene) -> None:
    async with scene.agent() as agent:
        counted = await kept_of(agent, await posted(scene, "every day at 9:00, 20 times, wave"))
        day = counted.asked.command.posted_at + 10 * DAY
        dated = await kept_of(agent, await posted(scene, f"every day at 9:00 until {day:%Y-%m-%d} wave"))
        asks = await scene.post("alice", "hello")
    again = continued(replace(counted, runs_left=12, next_at=None), asks, asks.created_at)
    assert again is not None
    assert again.runs_left == 12
    until_at = dated.asked.schedule.until_at
    again = continued(replace(dated, runs_left=0), asks, asks.created_at)
    assert again is not None
    assert (again.runs_left, again.asked.schedule.until_at) == (30, until_at)
    assert continued(replace(dated, runs_left=0), asks, until_at) is None
