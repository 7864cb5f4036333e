"""An agent that comes back (laws 4, 5, 6 and 14): what was ended stays so, and missed stops count first."""

from __future__ import annotations

import asyncio
import sqlite3
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from agent_scene import ROBOT, Driver, Scene, make_scene

from agentrob.agent import turn
from agentrob.agent.journal import Journal
from agentrob.minds.mind import Listener
from agentrob.minds.rules import RulesMind
from agentrob.model import Account, AccountKind, Command, Plan, Role, Understanding

STILL_M = 0.02


class StuckMind(RulesMind):
    """Understands nothing, so that its agent is ended with the command still open."""

    def __init__(self) -> None:
        self.asked = asyncio.Event()

    async def understand(self, text: str, listener: Listener, history: tuple[Plan, ...] = ()) -> Understanding:
        self.asked.set()
        await asyncio.Event().wait()
        raise AssertionError


async def place(driver: Driver) -> tuple[float, float]:
    async with driver.client() as client:
        pose = (await client.state()).pose
    assert pose is not None
    return pose.x_m, pose.y_m


async def started(scene: Scene) -> None:
    """The agent's first start, which sets the watermark."""
    async with scene.agent():
        pass


@pytest.mark.parametrize(
    ("what", "state"),
    [("stale", "expired"), ("edited", "cancelled"), ("stopped", "cancelled"), ("removed", "cancelled")],
)
async def test_laws_4_5_and_14_what_was_ended_stays_ended_after_a_restart(scene: Scene, what: str, state: str) -> None:
    await started(scene)
    post = await scene.post("alice", "@quadruped walk forward 1 metre")
    match what:
        case "stale":
            scene.world.posts[post.id] = replace(post, created_at=datetime(2020, 1, 1, tzinfo=UTC))
        case "edited":
            await scene.world.sign_in("alice").edit(post.id, "@quadruped walk forward 2 metres")
    mind = StuckMind()
    async with scene.agent(mind=mind) as agent:
        await asyncio.wait_for(mind.asked.wait(), 10)
        match what:
            case "stopped":
                said = await scene.post("bob", "stop", topic=post.topic_id)
                await scene.until(lambda: scene.replies(said))
            case "removed":
                scene.world.remove(post.id)
                await scene.until(lambda: next(iter(agent.line)).ended)
    if what == "removed":
        scene.world.posts[post.id] = replace(scene.world.posts[post.id], removed=False)
    stood = await place(scene.driver)
    async with scene.agent():
        assert (await scene.final(post)).card.state == state
        await scene.final(await scene.post("alice", "@quadruped help"))
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)


async def test_law_14_a_bare_stop_that_was_missed_comes_before_the_command_left_open(scene: Scene) -> None:
    mind = StuckMind()
    async with scene.agent(mind=mind):
        post = await scene.post("alice", "@quadruped walk forward 1 metre")
        await asyncio.wait_for(mind.asked.wait(), 10)
    await scene.post("bob", "stop", topic=post.topic_id)
    stood = await place(scene.driver)
    async with scene.agent():
        assert (await scene.final(post)).card.state == "cancelled"
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)


async def test_law_5_a_command_left_open_moves_after_a_restart_only_while_it_is_fresh(
    driver: Driver, tmp_path: Path
) -> None:
    scene = make_scene(driver, tmp_path)
    mind = StuckMind()
    async with scene.agent(mind=mind):
        posts = [await scene.post("alice", f"@quadruped turn {way} 90 degrees") for way in ("left", "right")]
        await asyncio.wait_for(mind.asked.wait(), 10)
        await scene.state(posts[1], "seen")
    async with scene.agent() as agent:
        assert (await scene.final(posts[0])).card.state == "done"
        await scene.final(posts[1])
        late = replace(await agent.journal.claimed(posts[0].id), ended=None)
        assert agent._why_not(late) is None
        scene.world.clock_offset_s = scene.settings.max_post_age_s + 5
        await agent.channel.set_clock()
        assert agent._why_not(late) == "stale"


async def test_law_14_a_bare_stop_counts_while_its_command_is_still_in_the_inbox(scene: Scene) -> None:
    async with scene.agent():
        stood = await place(scene.driver)
        post = await scene.post("alice", "@quadruped walk forward 1 metre")
        stop = await scene.post("bob", "stop", topic=post.topic_id)
        assert (await scene.final(post)).card.state == "cancelled"
        (answer,) = await scene.until(lambda: scene.replies(stop))
    assert "ended or cancelled: 1" in answer.raw
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)


async def test_law_14_a_bare_stop_counts_in_a_single_run(scene: Scene) -> None:
    await started(scene)
    stood = await place(scene.driver)
    post = await scene.post("alice", "@quadruped walk forward 1 metre")
    stop = await scene.post("bob", "stop", topic=post.topic_id)
    agent = scene.make()
    await asyncio.wait_for(agent.once(), 20)
    await agent.close()
    assert (await scene.final(post)).card.state == "cancelled"
    assert scene.replies(stop)
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)


async def test_law_15_a_post_that_no_parser_can_read_does_not_make_the_agent_deaf(scene: Scene) -> None:
    async with scene.agent():
        await scene.post("bob", "hello\n\n<div>\n<![x[ y ]]>\n</div>\n\n@quadruped walk")
        post = await scene.post("alice", "@quadruped turn left 90 degrees")
        assert (await scene.final(post)).card.state == "done"


async def test_a_post_that_breaks_the_ear_itself_is_passed_over(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    real = turn.perceive

    def fragile(post, *more):  # type: ignore[no-untyped-def]
        if "poison" in post.raw:
            raise ZeroDivisionError
        return real(post, *more)

    monkeypatch.setattr(turn, "perceive", fragile)
    async with scene.agent():
        await scene.post("bob", "poison")
        assert (await scene.final(await scene.post("alice", "@quadruped turn left 90 degrees"))).card.state == "done"


async def test_a_journal_of_an_earlier_version_is_read_and_can_keep_an_end(tmp_path: Path) -> None:
    alice = Account("a1", "alice", AccountKind.HUMAN, Role.OPERATOR)
    command = Command("7", "1", "h", alice, ROBOT, "wave", "en", datetime.now(UTC), "trace")
    journal = await Journal.open(tmp_path, ROBOT)
    await journal.claim(command)
    await journal.close()
    with sqlite3.connect(tmp_path / "journal.sqlite") as db:
        db.execute("ALTER TABLE claim DROP COLUMN ended")
    db.close()
    journal = await Journal.open(tmp_path, ROBOT)
    assert [c.ended for c in await journal.open_claims()] == [None]
    await journal.end(["7"], "stop")
    await journal.end(["7"], "edited")
    await journal.close()
    journal = await Journal.open(tmp_path, ROBOT)
    assert [c.ended for c in await journal.open_claims()] == ["stop"]
    assert not await journal.cancel("7")  # the motion was cancelled with it
    assert not await journal.moved("7")
    await journal.close()
