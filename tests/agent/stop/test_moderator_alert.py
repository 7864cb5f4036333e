"""Moderators are told of a robot that is stopped repeatedly, and commands do not pass through many agents."""

from __future__ import annotations

import itertools
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.agent.stop.moderator_alert import STOPS, WITHIN, ModeratorAlert
from agentrob.forums.memory.forum import MemoryForum
from agentrob.model import AccountKind, Post, Role
from tests.agent.agent_scene import ROBOT, Scene

START = datetime(2026, 1, 1, tzinfo=UTC)


def alerts(scene: Scene) -> list[Post]:
    return [p for p in scene.world.posts.values() if p.author.name == ROBOT and "times within" in p.raw]


async def test_law_15_moderators_hear_of_the_third_stop_once_where_it_came(scene: Scene) -> None:
    settings = scene.settings.model_copy(update={"moderators": ("@Mona",), "owner": "olaf"})
    async with scene.agent(settings=settings):
        first = await scene.post("alice", f"@{ROBOT} wave")
        await scene.final(first)
        for _ in range(2):
            await scene.post("bob", f"@{ROBOT} stop", first.topic_id)
        await scene.until(lambda: any("Stops since then: 1" in p.raw for p in scene.world.posts.values()))
        assert alerts(scene) == []
        third = await scene.post("bob", f"@{ROBOT} stop")
        notice = (await scene.until(lambda: alerts(scene)))[0]
        assert notice.topic_id == third.topic_id
        assert notice.raw.startswith("I was stopped 3 times within 5 minutes.")
        assert notice.raw.endswith("@mona @olaf")
        for _ in range(20):
            await scene.post("bob", f"@{ROBOT} stop", first.topic_id)
        assert (await scene.final(await scene.post("alice", f"@{ROBOT} wave"))).card.state == "done"
    assert alerts(scene) == [notice]


async def test_law_15_presses_of_the_button_count_too(scene: Scene) -> None:
    async with scene.agent():
        for _ in range(2):
            await scene.world.sign_in("bob").press_stop(ROBOT)
        stop = await scene.post("bob", f"@{ROBOT} stop")
        assert (await scene.until(lambda: alerts(scene)))[0].topic_id == stop.topic_id


@given(st.lists(st.integers(0, 400), min_size=1, max_size=60))
def test_law_15_no_third_stop_goes_untold_and_no_five_minutes_hear_of_two(gaps: list[int]) -> None:
    alarm = ModeratorAlert(MemoryForum.world().sign_in(ROBOT), ROBOT, ())
    ats = [START + timedelta(seconds=sum(gaps[: n + 1])) for n in range(len(gaps))]
    rang = [at for at in ats if alarm.count_stop(at)]
    assert all(later - earlier > WITHIN for earlier, later in itertools.pairwise(rang))
    for n in range(STOPS - 1, len(ats)):
        if ats[n] - ats[n - STOPS + 1] <= WITHIN:
            assert any(at <= ats[n] <= at + WITHIN for at in rang)


# ------------------------------------------------------------------ law 1: chains of agents
async def chain(scene: Scene, authors: str) -> Post:
    """Return a command by the last of `authors` (agents a, b, …, the robot r, the human h), each of whom replies to the
    one before."""
    for name in set(authors) - {"r", "h"}:
        scene.person(name, Role.OPERATOR, AccountKind.COMMANDING_AGENT)
    scene.person("h")
    post: Post | None = None
    for n, name in enumerate(authors):
        forum = scene.world.sign_in(ROBOT if name == "r" else name)
        text = f"@{ROBOT} turn left 20 degrees" if n == len(authors) - 1 else "Somebody could turn the robot."
        if post is None:
            post = (await forum.create_topic("robots", "T", text, key=f"c{n}")).post
        else:
            post = (await forum.reply(post.topic_id, text, key=f"c{n}", reply_to=post.id)).post
    assert post is not None
    return post


@pytest.mark.parametrize(
    ("authors", "state"),
    [
        ("a", "done"),
        ("habc", "done"),
        ("abc", "done"),
        ("abcd", "refused"),
        ("abab", "refused"),
        ("habcd", "refused"),
        ("abchd", "done"),
        ("ararara", "done"),
        ("aaaaaa", "done"),
        ("arbrcrd", "refused"),
        ("abcdh", "done"),
    ],
)
async def test_law_1_a_command_passes_through_three_agents_at_most(scene: Scene, authors: str, state: str) -> None:
    async with scene.agent():
        reply = await scene.final(await chain(scene, authors))
    assert reply.card.state == state, reply.raw
    assert ("`rights.hops`" in reply.raw) == (state == "refused")
