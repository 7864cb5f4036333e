"""A command that needs an approval: it waits, durably; who may approve it, and what cancels it (laws 1 to 7 and 14)."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import AsyncIterator, Collection, Iterable
from contextlib import asynccontextmanager
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.agent.queue.queue import QueuedCommand
from agentrob.model import AccountKind, Post, Role
from tests.agent.agent_scene import FINAL, ROBOT, Driver, Scene, make_scene

WAVE, TURN = f"@{ROBOT} wave", f"@{ROBOT} turn left 20 degrees"
YES, NO = f"@{ROBOT} approve", f"@{ROBOT} deny"


def mostly_slow(fast: Collection[str], cases: Iterable[str]) -> list[Any]:
    """Mark all cases but the `fast` ones as slow."""
    return [pytest.param(case, marks=() if case in fast else pytest.mark.slow) for case in cases]


def make(driver: Driver, folder: Path, **approval: Any) -> Scene:
    """Return a scene where gestures need an approval; carol and dan are moderators."""
    scene = make_scene(driver, folder, approval={"classes": ["gesture"], **approval})
    scene.person("carol", Role.MODERATOR)
    scene.person("dan", Role.MODERATOR)
    return scene


@pytest.fixture
def asked(driver: Driver, tmp_path: Path) -> Scene:
    return make(driver, tmp_path)


@asynccontextmanager
async def waiting(scene: Scene, text: str = WAVE) -> AsyncIterator[Post]:
    """Post Alice's command and wait until it waits for an approval."""
    async with scene.agent():
        post = await scene.post("alice", text)
        await scene.state(post, "waiting")
        yield post


async def say(scene: Scene, name: str, text: str, post: Post) -> Post:
    return await scene.post(name, text, post.topic_id)


async def answered(scene: Scene, post: Post) -> str:
    """Return the robot's reply to a post that is not a command."""
    return (await scene.until(lambda: scene.replies(post)))[0].raw


def held_in_line(agent: RobotAgent) -> asyncio.Event:
    """Let no command start until the event is set."""
    let, turn = asyncio.Event(), agent.queue.turn

    async def held(job: QueuedCommand, expiry_s: float) -> bool:
        await let.wait()
        return await turn(job, expiry_s)

    agent.queue.turn = held  # type: ignore[method-assign]
    return let


async def heard(scene: Scene, agent: RobotAgent) -> None:
    """Wait until the agent has processed all events."""
    await scene.until(lambda: agent.event_stream.cursor == str(len(scene.world.events)) and agent.inbox.empty)


def record(scene: Scene, post: Post) -> Any:
    return json.loads((scene.folder / f"agents/{ROBOT}/records/{post.id}.json").read_text())


def ends(scene: Scene, post: Post) -> list[str]:
    """Return every end of this command that was written."""
    ours = {p.id for p in scene.replies(post)}
    states = (e.post.card.state for e in scene.world.events if e.post and e.post.id in ours and e.post.card)
    return [state for state in states if state in FINAL]


@pytest.mark.parametrize(
    ("text", "yes", "expected", "by"),
    [
        (
            f"@{ROBOT} wave, then turn left 20 degrees",
            YES,
            [
                "Waits for approval",
                "wave, turn left 20°",
                "gestures",
                "Moderators and admins",
                f"`@{ROBOT} approve`",
            ],
            "Approved by `carol`",
        ),
        (
            f"@{ROBOT} 挥手",
            f"@{ROBOT} 批准",
            ["等待批准", "挥手", "做手势", "版主", f"`@{ROBOT} 批准`"],
            "批准者：`carol`",
        ),
    ],
)
async def test_law_7_what_needs_an_approval_waits_for_it_and_is_done_with_it(
    asked: Scene, text: str, yes: str, expected: list[str], by: str
) -> None:
    async with waiting(asked, text) as post:
        asks = await asked.state(post, "waiting")
        assert [words for words in expected if words not in asks.raw] == []
        assert datetime.fromisoformat(asks.card.until) == post.created_at + timedelta(seconds=600)
        given = await say(asked, "carol", yes, post)
        final = await asked.final(post)
    assert (final.card.state, by in final.raw) == ("done", True)
    assert (ends(asked, post), len(asked.replies(post)), asked.replies(given)) == (["done"], 1, [])
    kept = record(asked, post)
    assert (kept["approval"]["by"], kept["approval"]["post"], kept["verdict"]["rule"]) == (
        "carol",
        given.id,
        "approval.given",
    )


@pytest.mark.slow
async def test_what_needs_none_does_not_wait_and_goes_before_what_does(asked: Scene) -> None:
    async with waiting(asked) as post:
        walk = await asked.post("alice", TURN)
        assert (await asked.final(walk)).card.state == "done"
        await asked.state(post, "waiting")


@pytest.mark.parametrize(
    ("name", "role", "kind"),
    [
        pytest.param("guest", Role.GUEST, AccountKind.HUMAN, marks=pytest.mark.slow),
        pytest.param("member", Role.MEMBER, AccountKind.HUMAN, marks=pytest.mark.slow),
        ("operator", Role.OPERATOR, AccountKind.HUMAN),
        pytest.param("pilot", Role.ADMIN, AccountKind.COMMANDING_AGENT, marks=pytest.mark.slow),
        ("rover", Role.ADMIN, AccountKind.ROBOT_AGENT),
        pytest.param("watcher", Role.ADMIN, AccountKind.MONITORING_AGENT, marks=pytest.mark.slow),
        pytest.param("gone", Role.ADMIN, AccountKind.HUMAN, marks=pytest.mark.slow),
        ("alice", Role.MODERATOR, AccountKind.HUMAN),
    ],
)
async def test_laws_1_and_2_who_may_not_approve_moves_nothing(
    asked: Scene, name: str, role: Role, kind: AccountKind
) -> None:
    asked.person(name, role, kind)
    asked.world.set_role(name, role)
    async with waiting(asked) as post:
        given = await say(asked, name, YES, post)
        if name == "gone":
            asked.world.suspend(name)
            await say(asked, "bob", YES, post)
        elif kind in (AccountKind.HUMAN, AccountKind.COMMANDING_AGENT):
            assert "approve" in await answered(asked, given)
        else:  # without a reply; the reply to a later post shows that it was processed
            await answered(asked, await say(asked, "bob", YES, post))
        assert [r.card.state for r in asked.replies(post)] == ["waiting"]
        await say(asked, "carol", NO, post)
        assert (await asked.final(post)).card.state == "refused"
    assert ends(asked, post) == ["refused"]


@pytest.mark.slow
async def test_law_2_an_author_approves_alone_only_where_the_robot_s_settings_say_so(
    driver: Driver, tmp_path: Path
) -> None:
    scene = make(driver, tmp_path, own=True, who="operator")
    async with waiting(scene) as post:
        await say(scene, "alice", YES, post)
        assert (await scene.final(post)).card.state == "done"


CHANGES = {
    "the approval is edited": "cancelled",
    "the approval is removed": "cancelled",
    "the approval is another's now": "cancelled",
    "the approver is demoted": "refused",
    "the approver is suspended": "refused",
    "the author is demoted": "refused",
    "the author is suspended": "cancelled",
    "the command is edited": "cancelled",
    "the command is removed": "cancelled",
    "denied after all": "refused",
    "stopped": "cancelled",
    "taken back": "cancelled",
}


@pytest.mark.parametrize(
    "what", mostly_slow({"the approval is edited", "the approver is demoted", "denied after all"}, CHANGES)
)
async def test_law_4_what_changed_between_the_approval_and_the_motion_moves_nothing(asked: Scene, what: str) -> None:
    async with asked.agent() as agent:
        let = held_in_line(agent)
        post = await asked.post("alice", WAVE)
        await asked.state(post, "waiting")
        given = await say(asked, "carol", YES, post)
        await asked.until(lambda: (job := agent.queue.find(post.id)) and job.decided)
        match what:
            case "the approval is edited":
                await asked.world.sign_in("carol").edit(given.id, f"{YES} not yet")
            case "the approval is removed":
                asked.world.remove(given.id)
            case "the approval is another's now":
                asked.world.give(given.id, "dan")
            case "the approver is demoted":
                asked.world.set_role("carol", Role.OPERATOR)
            case "the approver is suspended":
                asked.world.suspend("carol")
            case "the author is demoted":
                asked.world.set_role("alice", Role.MEMBER)
            case "the author is suspended":
                asked.world.suspend("alice")
            case "the command is edited":
                await asked.world.sign_in("alice").edit(post.id, f"{WAVE} twice")
            case "the command is removed":
                asked.world.remove(post.id)
            case "denied after all":
                await say(asked, "dan", NO, post)
            case "stopped":
                await asked.post("bob", f"@{ROBOT} stop")
            case "taken back":
                await asked.final(await asked.post("alice", f"@{ROBOT} never mind"))
        await heard(asked, agent)
        let.set()
        final = await asked.final(post)
    assert final.card.state == CHANGES[what], final.raw
    assert [step["outcome"] for step in record(asked, post)["steps"] if step["outcome"] != "skipped"] == []
    assert len(ends(asked, post)) == 1


@pytest.mark.parametrize("what", mostly_slow({"stop"}, ["edit", "remove", "stop", "cancel"]))
async def test_laws_4_and_14_what_waits_for_an_approval_is_ended_as_what_is_queued_is(asked: Scene, what: str) -> None:
    async with waiting(asked) as post:
        match what:
            case "edit":
                await asked.world.sign_in("alice").edit(post.id, f"{WAVE} twice")
            case "remove":
                asked.world.remove(post.id)
            case "stop":
                await say(asked, "bob", "stop", post)
            case _:
                await asked.post("alice", f"@{ROBOT} never mind")
        assert (await asked.final(post)).card.state == "cancelled"
        late = await say(asked, "carol", YES, post)
        assert "No command in this thread waits" in await answered(asked, late)
    assert ends(asked, post) == ["cancelled"]


@pytest.mark.slow
async def test_a_denial_is_reported_with_who_denied(asked: Scene) -> None:
    async with waiting(asked) as post:
        await say(asked, "carol", NO, post)
        final = await asked.final(post)
    assert "`carol` denied it" in final.raw
    assert "`approval.denied`" in final.raw
    assert record(asked, post)["approval"]["approved"] is False


async def test_laws_3_and_4_what_only_looks_like_an_approval_is_none(asked: Scene) -> None:
    asked.person("humanoid", Role.MEMBER, AccountKind.ROBOT_AGENT)
    async with waiting(asked) as post:
        for text in (f"> {YES}", f"`{YES}`", "approve", "@humanoid approve", "Well."):
            given = await say(asked, "carol", text, post)
        await asked.world.sign_in("carol").edit(given.id, YES)
        await asked.final(await asked.post("alice", TURN))
        await asked.state(post, "waiting")


@pytest.mark.slow
async def test_law_5_an_old_approval_approves_nothing_and_a_new_one_does(asked: Scene) -> None:
    async with waiting(asked):
        pass
    post = next(p for p in asked.world.posts.values() if p.raw == WAVE)
    old = await say(asked, "carol", YES, post)
    asked.world.clock_offset_s += 130.0
    async with asked.agent():
        assert "Please approve it again" in await answered(asked, old)
        await asked.state(post, "waiting")
        await say(asked, "carol", YES, post)
        assert (await asked.final(post)).card.state == "done"


@pytest.mark.parametrize(
    ("text", "said", "lapsed"),
    [
        (TURN, "Moderators and admins may approve within 10 minutes of being asked; then it lapses.", "10 minutes"),
        (f"@{ROBOT} 左转20度", "版主和管理员可在发帖后 10 分钟内批准，过时作废。", "10 分钟"),
    ],
)
async def test_how_long_it_may_be_approved_is_reported_without_a_time_zone_and_the_card_says_until_when(
    driver: Driver, tmp_path: Path, text: str, said: str, lapsed: str
) -> None:
    scene = make(driver, tmp_path, classes=["move"])
    async with scene.agent():
        post = await scene.post("alice", text)
        asks = await scene.state(post, "waiting")
        assert said in asks.raw
        assert not re.search(r"UTC|\d:\d\d|20\d\d-", asks.raw)
        assert datetime.fromisoformat(asks.card.until) == post.created_at + timedelta(minutes=10)
    scene.world.clock_offset_s += 601.0
    async with scene.agent():
        final = await scene.final(post)
    assert (final.card.state, final.card.until) == ("expired", "")
    assert lapsed in final.raw


@pytest.mark.parametrize("away", [False, pytest.param(True, marks=pytest.mark.slow)])
async def test_law_5_what_nobody_approves_in_time_lapses_with_one_answer(
    driver: Driver, tmp_path: Path, away: bool
) -> None:
    scene = make(driver, tmp_path, wait_s=3600.0 if away else 0.4)
    async with waiting(scene) as post:
        if not away:
            await scene.final(post)
    if away:
        scene.world.clock_offset_s += 601.0  # never longer than a command may be queued
    async with scene.agent():
        final = await scene.final(post)
        late = await say(scene, "carol", YES, post)
        assert "No command in this thread waits" in await answered(scene, late)
    assert (final.card.state, "Nobody approved it" in final.raw) == ("expired", True)
    assert ends(scene, post) == ["expired"]


@pytest.mark.parametrize("when", mostly_slow({"before"}, ["before", "while away", "after"]))
async def test_law_6_it_waits_on_after_a_restart_and_is_done_once(asked: Scene, when: str) -> None:
    async with asked.agent() as agent:
        held_in_line(agent)
        post = await asked.post("alice", WAVE)
        await asked.state(post, "waiting")
        if when == "before":
            await say(asked, "carol", YES, post)
            await asked.until(lambda: (job := agent.queue.find(post.id)) and job.decided)
    if when == "while away":
        await say(asked, "carol", YES, post)
    async with asked.agent():
        if when == "after":
            await say(asked, "carol", YES, post)
        assert (await asked.final(post)).card.state == "done"
    async with asked.agent():
        await asked.final(await asked.post("alice", f"@{ROBOT} help"))
    assert (ends(asked, post), len(asked.replies(post))) == (["done"], 1)


async def test_law_6_two_who_approve_the_same_command_move_it_once(asked: Scene) -> None:
    async with waiting(asked) as post:
        first, second = await say(asked, "carol", YES, post), await say(asked, "dan", YES, post)
        assert "No command in this thread waits" in await answered(asked, second)
        assert "Approved by `carol`" in (await asked.final(post)).raw
    assert (ends(asked, post), asked.replies(first)) == (["done"], [])


async def test_law_7_an_approval_is_of_one_command(asked: Scene) -> None:
    """Two commands wait in a thread, or one waits where another was approved a moment ago."""
    async with waiting(asked) as one:
        other = await say(asked, "alice", f"{WAVE} twice", one)
        await asked.state(other, "waiting")
        assert "which command you mean" in await answered(asked, await say(asked, "carol", YES, one))
        await asked.post("carol", YES, one.topic_id, reply_to=asked.replies(one)[0].id)
        assert (await asked.final(one)).card.state == "done"
        assert "which command you mean" in await answered(asked, await say(asked, "dan", YES, one))
        await asked.state(other, "waiting")
        await asked.post("dan", YES, one.topic_id, reply_to=other.id)
        assert (await asked.final(other)).card.state == "done"


@pytest.mark.slow
async def test_law_7_one_that_came_to_need_an_approval_while_it_was_queued_is_refused(
    driver: Driver, tmp_path: Path
) -> None:
    free, strict = make_scene(driver, tmp_path), make(driver, tmp_path)
    strict.world = free.world
    async with free.agent() as agent:
        held_in_line(agent)
        post = await free.post("alice", WAVE)
        await free.until(lambda: (job := agent.queue.find(post.id)) and job.admitted)
    async with strict.agent():
        final = await strict.final(post)
    assert (final.card.state, "This needs an approval" in final.raw) == ("refused", True)


@pytest.mark.slow
async def test_two_robots_are_approved_by_one_word_to_both_or_apart(asked: Scene) -> None:
    asked.person("humanoid", Role.MEMBER, AccountKind.ROBOT_AGENT)
    async with waiting(asked, f"@{ROBOT} @humanoid wave") as post:
        await say(asked, "carol", "@humanoid deny", post)
        await asked.final(await asked.post("alice", TURN))
        await asked.state(post, "waiting")
        await say(asked, "carol", f"@humanoid @{ROBOT} approve", post)
        assert (await asked.final(post)).card.state == "done"


@pytest.mark.slow
async def test_where_edits_are_limited_it_asks_in_a_reply_of_its_own(driver: Driver, tmp_path: Path) -> None:
    scene = make(driver, tmp_path)
    scene.world.max_edits = 1
    async with scene.agent():
        post = await scene.post("alice", WAVE)
        asks = await scene.state(post, "waiting")
        await scene.post("carol", YES, post.topic_id, reply_to=asks.id)
        await scene.until(lambda: any("Approved by" in p.raw for p in scene.replies(post)))


@pytest.mark.slow
async def test_an_agent_that_looks_once_leaves_it_waiting(asked: Scene) -> None:
    agent: RobotAgent = asked.make()
    await agent.once()
    await agent.close()
    post = await asked.post("alice", WAVE)
    for said, state in (("", "waiting"), (YES, "done")):
        if said:
            await say(asked, "carol", said, post)
        agent = asked.make()
        await agent.once()
        await agent.close()
        assert [r.card.state for r in asked.replies(post)] == [state]
