"""One of several robots does a part: exactly one, whoever answers, and the others say who."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from agentrob.agent.joint import evidence
from agentrob.agent.joint.waits import PartWaits
from agentrob.agent.queue.queue import QueuedCommand
from agentrob.model import AccountKind, Post, StatusCard
from tests.agent.joint.joint_scene import JointScene

ONE = "@quadruped @humanoid one of you wave"


def done(scene: JointScene, post: Post) -> list[str]:
    return [p.author.name for p in scene.replies(post) if p.card and p.card.state == "done"]


def takes(scene: JointScene, post: Post) -> list[str]:
    return [p.author.name for p in scene.replies(post) if p.card and p.card.takes]


async def test_one_of_you_does_it_and_the_other_says_who_took_it_and_why(scene: JointScene) -> None:
    async with scene.agents():
        post = await scene.post("@quadruped walk forward 4 m. Meanwhile @humanoid wave. Then one of you wave")
        summary = await scene.summary(post)
    assert summary.raw.startswith("3 of 3 done:")
    assert len(done(scene, post)) == 3
    assert len(takes(scene, post)) == 1
    taker = takes(scene, post)[0]
    other = next(p for p in scene.replies(post) if p.card and p.card.left_to)
    assert other.author.name != taker
    assert other.card is not None
    assert (other.card.state, other.card.left_to) == ("cancelled", taker)
    assert f"Left to `{taker}`, who took it first (" in other.raw
    assert f"3. `{taker}` is done: `wave`" in summary.raw


async def test_the_robot_that_would_be_done_first_does_it(scene: JointScene) -> None:
    async with scene.agents():
        busy = await scene.post("@humanoid walk forward 5 m")
        await scene.until(lambda: [p for p in scene.replies(busy) if p.card and p.card.state == "running"])
        post = await scene.post(ONE)
        await scene.summary(post)
    assert done(scene, post) == ["quadruped"]


async def test_a_robot_whose_agent_is_down_is_not_waited_for(scene: JointScene) -> None:
    async with scene.agents("quadruped"):
        post = await scene.post("@humanoid 或 @quadruped 挥手")
        await scene.until(lambda: done(scene, post) == ["quadruped"])
    assert not scene.summaries(post)  # the humanoid, which is named first, sums up
    async with scene.agents("humanoid"):
        summary = await scene.summary(post)
    assert summary.author.name == "humanoid"
    assert summary.raw.startswith("1 个部分完成了 1 个")


async def test_the_first_post_that_takes_the_part_decides_also_where_nobody_sees_bids(
    scene: JointScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each robot believes that it is the best, and sees the other's post only after its own: the order of the thread
    decides, and only one moves."""
    taker_of, looked = evidence.taker_of, set[object]()

    def late(*given: Any) -> str:
        task = asyncio.current_task()
        found = taker_of(*given) if task in looked else ""
        looked.add(task)
        return found

    monkeypatch.setattr(evidence, "taker_of", late)
    monkeypatch.setattr(evidence, "look_at_bids", lambda *_: evidence.Turn())
    async with scene.agents():
        post = await scene.post(ONE)
        await scene.summary(post)
    assert sorted(takes(scene, post)) == ["humanoid", "quadruped"]
    assert done(scene, post) == takes(scene, post)[:1]


async def test_a_robot_whose_turn_comes_after_another_took_the_part_does_not_say_that_it_does_it(
    scene: JointScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its bid was the best, but it was busy until then."""
    monkeypatch.setattr(evidence, "look_at_bids", lambda *_: evidence.Turn())
    async with scene.agents():
        busy = await scene.post("@humanoid walk forward 3 m")
        await scene.until(lambda: [p for p in scene.replies(busy) if p.card and p.card.state == "running"])
        post = await scene.post(ONE)
        left = await scene.until(lambda: next((p for p in scene.replies(post) if p.card and p.card.left_to), None))
    assert left.author.name == "humanoid"
    assert takes(scene, post) == done(scene, post) == ["quadruped"]


async def test_the_next_one_does_it_if_the_best_does_not_begin(
    scene: JointScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evidence, "BEGIN_S", 0.5)
    best = scene.world.sign_in("humanoid", kind=AccountKind.ROBOT_AGENT)
    async with scene.agents("quadruped"):
        post = await scene.post(ONE)
        facts = {"part": 1, "parts": 1, "post": post.id, "content_hash": post.content_hash, "bid_s": 1, "battery": 90}
        card = StatusCard("humanoid", "queued", **facts)  # type: ignore[arg-type]
        await best.reply(post.topic_id, "I am the best", key="bid", reply_to=post.id, card=card)
        await scene.until(lambda: done(scene, post) == ["quadruped"])
        # and when the best wakes up, it is too late: its post is not the first
        taking = StatusCard("humanoid", "answered", takes=1, **facts)  # type: ignore[arg-type]
        await best.reply(post.topic_id, "I do it", key="take", reply_to=post.id, card=taking)
    assert takes(scene, post) == ["quadruped", "humanoid"]
    assert done(scene, post) == ["quadruped"]


async def test_a_robot_that_took_a_part_and_was_restarted_does_it(
    scene: JointScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    take, taken = PartWaits.take, asyncio.Event()

    async def dies(self: PartWaits, job: QueuedCommand) -> bool:
        await take(self, job)
        taken.set()
        await asyncio.Event().wait()  # a dead process does nothing more
        return False

    with monkeypatch.context() as patched:
        patched.setattr(PartWaits, "take", dies)
        async with scene.agents("quadruped"):
            post = await scene.post(ONE)
            async with asyncio.timeout(60):
                await taken.wait()
    async with scene.agents():
        await scene.summary(post)
    assert takes(scene, post) == ["quadruped"]
    assert done(scene, post) == ["quadruped"]
