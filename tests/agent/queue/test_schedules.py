"""Schedules on the memory forum, with a fake robot: what is said, what runs when, and what ends them.

The time is that of the forum's clock, which each test passes to the scheduler: nothing waits for it.
"""

from __future__ import annotations

import asyncio
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.agent.queue.schedules import Schedules
from agentrob.model import CommandState, Post, Role, ScheduleEnd
from tests.agent.agent_scene import FINAL, ROBOT, Driver, Scene, make_scene

pytestmark = pytest.mark.usefixtures("database")
HOUR, MINUTE = timedelta(hours=1), timedelta(minutes=1)


@pytest.fixture
def scene(driver: Driver, tmp_path: Path) -> Scene:
    return make_scene(driver, tmp_path, time_zone="Europe/Berlin")


async def posted(scene: Scene, text: str, state: str = "answered") -> Post:
    """Post a schedule of Alice's and wait for the first reply."""
    post = await scene.post("alice", f"@{ROBOT} {text}")
    reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == state, reply.raw
    return post


async def steps(agent: RobotAgent, moment: datetime) -> Schedules:
    """Let a running agent look at its schedules at another time by the forum's clock."""
    then = replace(agent.schedules, now=lambda: moment)
    await then.step()
    return then


async def next_at(agent: RobotAgent) -> datetime:
    (kept,) = [kept for kept in await agent.journal.schedules() if kept.ended is None]
    assert kept.next_at is not None
    return kept.next_at


def finals(scene: Scene, post: Post) -> list[Post]:
    found = [p for p in scene.replies(post) if p.card is not None and p.card.state in FINAL]
    return sorted(found, key=lambda p: int(p.id))


async def run_of(scene: Scene, post: Post, number: int) -> Post:
    """Wait for the final reply of the run with this number, from 1 on."""
    found: list[Post] = await scene.until(lambda: len(done := finals(scene, post)) > number and done)
    assert len(found) == number + 1
    return found[number]


def state(reply: Post) -> str:
    assert reply.card is not None
    return reply.card.state


def ended(scene: Scene, post: Post) -> list[str]:
    """Return the replies that tell of a schedule's end."""
    return [p.raw for p in scene.replies(post) if p.key == f"schedule:{post.id}"]


def runs_done(scene: Scene, post: Post) -> int:
    return sum(state(reply) == CommandState.DONE for reply in finals(scene, post))


# -------------------------------------------------------------------- runs
@pytest.mark.parametrize(
    ("text", "said", "run"),
    [
        (
            "in 10 minutes wave",
            ["Scheduled: wave.", "(Europe/Berlin)", "reply `cancel`"],
            "Run of this schedule",
        ),
        ("十分钟后挥手", ["已安排：挥手。", "（Europe/Berlin）", "回复“取消”"], "的运行，时间是"),
    ],
)
async def test_law_6_a_command_for_later_is_echoed_and_runs_once_at_its_time(
    scene: Scene, text: str, said: list[str], run: str
) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, text)
        assert [words for words in said if words not in finals(scene, post)[0].raw] == []
        due = await next_at(agent)
        assert timedelta() < due - (post.created_at + 10 * MINUTE) <= timedelta(seconds=1)
        await steps(agent, due - timedelta(seconds=1))
        assert len(finals(scene, post)) == 1, "not before its time"
        await asyncio.gather(steps(agent, due), steps(agent, due))
        done = await run_of(scene, post, 1)
        assert (state(done), run in done.raw, ended(scene, post)) == ("done", True, [])
        await steps(agent, due + MINUTE)
        assert await agent.journal.schedules() == []
        assert len(finals(scene, post)) == 2


async def test_a_weekday_schedule_names_the_next_three_runs_and_its_end(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every weekday at 9 take a photo")
        reply = finals(scene, post)[0].raw
        assert reply.count("09:00") == 3
        assert "after 30 runs" in reply
        due = await next_at(agent)
        await steps(agent, due)
        assert state(await run_of(scene, post, 1)) == "done"
        assert await next_at(agent) > due
        asks = await scene.post("alice", f"@{ROBOT} schedules", topic=post.topic_id)
        listed = (await scene.final(asks)).raw
        assert "1 schedule:" in listed
        assert "take a photo" in listed
        assert "29 runs left" in listed
        assert "`alice`" in listed
        assert "To cancel one, reply `cancel` in its thread." in listed


async def test_law_5_a_missed_run_is_told_once_and_not_made_up(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        first = await next_at(agent)
        late = first + 2 * HOUR + 10 * MINUTE
        await asyncio.gather(steps(agent, late), steps(agent, late))
        told = await run_of(scene, post, 1)
        assert state(told) == "expired"
        assert "and the 2 times after it" in told.raw
        assert "not make up" in told.raw
        assert await next_at(agent) == first + 3 * HOUR
        await steps(agent, late)
        assert (len(finals(scene, post)), runs_done(scene, post)) == (2, 0)


@pytest.mark.parametrize(("late_s", "ends"), [(100, "done"), (121, "expired")])
async def test_law_5_the_freshness_of_a_run_counts_from_its_time(scene: Scene, late_s: int, ends: str) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "in 2 hours wave")
        await steps(agent, await next_at(agent) + timedelta(seconds=late_s))
        assert state(await run_of(scene, post, 1)) == ends


async def test_law_5_no_run_begins_more_than_five_minutes_late(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, max_post_age_s=3600.0)
    async with scene.agent() as agent:
        post = await posted(scene, "in 2 hours wave")
        await steps(agent, await next_at(agent) + timedelta(seconds=301))
        told = await run_of(scene, post, 1)
        assert (state(told), "within 5 minutes" in told.raw) == ("expired", True)


async def test_no_second_run_beside_the_first(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every hour walk 5 m")
        first = await next_at(agent)
        await steps(agent, first)
        await scene.until(lambda: agent.queue.moving is not None)
        await steps(agent, first + HOUR)
        skipped = await scene.until(lambda: [p for p in finals(scene, post) if state(p) == "cancelled"])
        assert "the run before it had not ended" in skipped[0].raw
        await scene.until(lambda: runs_done(scene, post) == 1)
        assert len(finals(scene, post)) == 3


# -------------------------------------------------------------------- rights, approval, limits
async def test_a_schedule_ends_where_its_robot_may_not_be_commanded(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, boards=["robots"])
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        scene.world.posts[post.id] = replace(scene.world.posts[post.id], board_id="lounge")
        await steps(agent, await next_at(agent))
        assert "may not command me here any more" in (await scene.until(lambda: ended(scene, post)))[0]
        assert await agent.journal.schedules() == []


async def test_law_2_who_may_not_command_schedules_nothing(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = await scene.post("bob", f"@{ROBOT} every hour wave")
        assert state(await scene.final(post)) == "refused"
        assert await agent.journal.schedules() == []


async def test_laws_2_and_4_an_author_who_loses_the_right_ends_the_schedule(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        due = await next_at(agent)
        scene.world.set_role("alice", Role.MEMBER)
        await steps(agent, due)
        (told,) = await scene.until(lambda: ended(scene, post))
        assert "may not command me here any more" in told
        assert len(finals(scene, post)) == 1
        scene.world.set_role("alice", Role.OPERATOR)
        await steps(agent, due + HOUR)
        assert len(finals(scene, post)) == 1


async def test_law_7_each_run_needs_its_own_approval(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, approval={"classes": ["gesture"]})
    scene.person("carol", Role.MODERATOR)
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        assert "Each run needs an approval" in finals(scene, post)[0].raw
        await steps(agent, await next_at(agent))
        asks = await scene.state(post, "waiting")
        assert runs_done(scene, post) == 0
        await scene.post("carol", f"@{ROBOT} approve", topic=post.topic_id, reply_to=asks.id)
        assert state(await run_of(scene, post, 1)) == "done"


async def test_a_command_beyond_a_limit_is_not_scheduled(scene: Scene) -> None:
    async with scene.agent() as agent:
        await posted(scene, "every hour walk 500 m", state="asks_back")
        assert await agent.journal.schedules() == []


async def test_an_account_has_five_schedules_at_most(scene: Scene) -> None:
    async with scene.agent() as agent:
        for minutes in range(10, 15):
            await posted(scene, f"in {minutes} minutes wave")
        refused = await posted(scene, "in 20 minutes wave", state="refused")
        assert "5 schedules" in finals(scene, refused)[0].raw
        assert len(await agent.journal.schedules()) == 5


@pytest.mark.parametrize(
    "text",
    ["tomorrow wave", "twice a day wave", "walk 1 m, then in 10 minutes wave", "明天挥手", "in a few minutes wave"],
)
async def test_law_18_an_unclear_time_is_asked_back_and_nothing_is_scheduled(scene: Scene, text: str) -> None:
    async with scene.agent() as agent:
        await posted(scene, text, state="asks_back")
        assert await agent.journal.schedules() == []


# -------------------------------------------------------------------- ends
@pytest.mark.parametrize("word", ["cancel", "取消", f"@{ROBOT} cancel the schedule"])
async def test_cancel_in_the_thread_ends_the_schedule_and_no_other(scene: Scene, word: str) -> None:
    async with scene.agent() as agent:
        other, post = await posted(scene, "in 20 minutes wave"), await posted(scene, "every hour wave")
        due = await next_at_of(agent, post)
        await scene.until(lambda: not len(agent.queue))
        await agent.schedules.load()
        await scene.post("bob", word, topic=post.topic_id)
        (told,) = await scene.until(lambda: ended(scene, post))
        assert "cancelled" in told
        await steps(agent, due)
        assert len(finals(scene, post)) == 1
        assert ended(scene, other) == []


async def next_at_of(agent: RobotAgent, post: Post) -> datetime:
    kept = await agent.journal.schedule(post.id)
    assert kept is not None
    assert kept.next_at is not None
    return kept.next_at


@pytest.mark.parametrize(("word", "in_thread"), [(f"@{ROBOT} stop", False), ("stop", True), ("停", True)])
async def test_law_14_a_stop_ends_what_was_scheduled_before_it(scene: Scene, word: str, in_thread: bool) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        due = await next_at(agent)
        await agent.schedules.load()
        await scene.post("bob", word, topic=post.topic_id if in_thread else None)
        (told,) = await scene.until(lambda: ended(scene, post))
        assert "stopped" in told
        await steps(agent, due)
        assert len(finals(scene, post)) == 1


async def test_law_4_an_edit_or_a_removal_ends_the_schedule(scene: Scene) -> None:
    async with scene.agent() as agent:
        edited, removed = await posted(scene, "every hour wave"), await posted(scene, "in 2 hours wave")
        due = await next_at_of(agent, edited)
        await scene.world.sign_in("alice").edit(edited.id, f"@{ROBOT} every hour walk 5 m")
        scene.world.remove(removed.id)
        assert "edited" in (await scene.until(lambda: ended(scene, edited)))[0]
        async with asyncio.timeout(60):
            while await agent.journal.schedules():
                await scene.world.wait(0.05)
        await steps(agent, due + HOUR)
        assert (len(finals(scene, edited)), len(finals(scene, removed))) == (1, 1)


async def test_law_4_an_edit_that_was_not_heard_counts_when_the_run_is_due(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        due = await next_at(agent)
        scene.world.posts[post.id] = replace(scene.world.posts[post.id], raw=f"@{ROBOT} walk 5 m", version=2)
        await steps(agent, due)
        assert "edited" in (await scene.until(lambda: ended(scene, post)))[0]
        assert len(finals(scene, post)) == 1


@pytest.mark.parametrize("heard", [True, False])
async def test_a_schedule_moves_with_its_post_to_another_thread(scene: Scene, heard: bool) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        other = await scene.post("alice", "Hello.")
        moved = replace(scene.world.posts[post.id], topic_id=other.topic_id)
        scene.world.posts[post.id] = moved
        if heard:
            await agent.schedules.amended(moved)
        await steps(agent, await next_at(agent))
        reply = await run_of(scene, moved, 1)
        assert (state(reply), reply.topic_id) == (CommandState.DONE, other.topic_id)
    async with scene.agent() as agent:  # a restart remembers the thread
        assert agent.schedules.topics == {other.topic_id}
        await scene.post("alice", "cancel", other.topic_id)
        assert await scene.until(lambda: ended(scene, moved))  # without a mention


async def test_a_schedule_ends_after_its_runs_and_says_so_only_if_it_met_a_limit(scene: Scene) -> None:
    async with scene.agent() as agent:
        three, many = await posted(scene, "every hour, twice, wave"), await posted(scene, "every hour wave")
        for number in (1, 2):
            await steps(agent, await next_at_of(agent, three))
            await run_of(scene, three, number)
        kept = await agent.journal.schedule(three.id)
        assert kept is not None
        assert (kept.ended, kept.reported) == (ScheduleEnd.DONE, True)
        await steps(agent, await next_at_of(agent, many) + 40 * HOUR)
        await run_of(scene, many, runs_done(scene, many) + 1)
        assert "as many runs or days" in (await scene.until(lambda: ended(scene, many)))[0]
        assert ended(scene, three) == []
