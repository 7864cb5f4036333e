"""Laws 4 to 6: a command is fresh, bound to its post and executed at most once, and everybody gets one reply."""

from __future__ import annotations

import asyncio
import json
import re
import resource
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.config.forum import ForumConfig
from agentrob.errors import JournalError
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, ActionResult, EventKind, Plan, Primitive, Role, StatusCard, Understanding
from agentrob.robots.driver.lease import TTL_S
from tests.agent.agent_process import Poster, end_agent, start_agent, until_state
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings, serving
from tests.agent.store.journal_store import open_journal
from tests.board.running_board import RunningBoard, running_board
from tests.tolerances import about_deg
from tests.waiting import until

pytestmark = pytest.mark.usefixtures("database")
AGENTS_DIE = True

#: How far a standing robot may still settle.
STILL_M = 0.02


async def position(driver: Driver) -> tuple[float, float]:
    async with driver.client() as client:
        pose = (await client.state()).pose
    assert pose is not None
    return pose.x_m, pose.y_m


@pytest.fixture
def slow_driver(tmp_path: Path) -> Iterator[Driver]:
    made = Driver(tmp_path, robot_settings(options={"time_scale": 1}), name="slow", lease_s=TTL_S)
    yield made
    made.end()


def agent_on(board: RunningBoard, driver: Driver, folder: Path) -> RobotAgent:
    """Return the next agent on the same data folder, in this process."""
    forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
    return RobotAgent(
        ROBOT,
        driver.settings,
        forum,
        driver.client(),
        RulesMind(),
        folder,
        open_journal=partial(open_journal, folder, ROBOT),
    )


async def test_law_6_a_killed_agent_s_motion_is_interrupted_and_never_repeated(
    tmp_path: Path, slow_driver: Driver
) -> None:
    with running_board(tmp_path / "board") as board, Poster(board, "op") as alice:
        agent = await asyncio.to_thread(start_agent, slow_driver, tmp_path, board)
        topic = await alice.post(f"@{ROBOT} walk forward 4 m, then walk backward 3 m")
        await until_state(slow_driver, lambda state: state.pose.x_m > 0.5)
        end_agent(agent)
        await until_state(slow_driver, lambda state: state.velocity_mps == (0.0, 0.0))
        stood = await position(slow_driver)
        assert stood[0] < 3.0, "its walk was not ended"
        async with serving(agent_on(board, slow_driver, tmp_path)):
            assert await alice.final(topic) == ["interrupted"]
            assert await position(slow_driver) == pytest.approx(stood, abs=0.01)


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)  # the journal is on this disk
async def test_law_6_a_disk_that_is_full_from_the_motion_on_costs_no_reply_and_no_second_motion(
    tmp_path: Path, slow_driver: Driver
) -> None:
    with running_board(tmp_path / "board") as board, Poster(board, "op") as alice:
        agent = await asyncio.to_thread(start_agent, slow_driver, tmp_path, board)
        before = await position(slow_driver)
        topic = await alice.post(f"@{ROBOT} walk forward 2 m, then turn left 20 degrees")
        await until_state(slow_driver, lambda state: state.pose.x_m > before[0] + 0.3)
        _, hard = resource.prlimit(agent.pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
        assert await alice.final(topic) == ["done"]
        status_text = await alice.status_text(topic)
        assert re.search(r"walk forward 2 m \| (1\.9\d|2\.0\d) m \| done", status_text), status_text
        turned = re.search(r"turn left 20° \| (\d+\.\d)° \| done", status_text)
        assert turned is not None, status_text
        assert float(turned[1]) == about_deg(20)
        assert "before anything moved" not in status_text
        assert "only this reply contains the result" in status_text
        late = await alice.post(f"@{ROBOT} walk backward 2 m")
        assert await alice.final(late) == ["failed"]
        resource.prlimit(agent.pid, resource.RLIMIT_FSIZE, (hard, hard))
        assert await alice.final(await alice.post(f"@{ROBOT} turn left 20 degrees")) == ["done"]
        stood = await position(slow_driver)
        end_agent(agent)
        async with serving(agent_on(board, slow_driver, tmp_path)):
            assert await alice.final(await alice.post(f"@{ROBOT} turn right 20 degrees")) == ["done"]
            assert await position(slow_driver) == pytest.approx(stood, abs=STILL_M)
            assert len(await alice.states(topic)) == 1


async def test_law_6_a_second_agent_is_refused(scene: Scene) -> None:
    async with scene.agent():
        second = scene.make()
        with pytest.raises(JournalError, match="already runs"):
            await second.run()
        await second.close()
        post = await scene.post("alice", "@quadruped turn left 90 degrees")
        assert (await scene.final(post)).card.state == "done"


@pytest.mark.parametrize("state", ["seen", "queued", "running"])
async def test_law_6_a_claim_that_the_journal_does_not_know_means_interrupted(scene: Scene, state: str) -> None:
    post = await scene.post("alice", "@quadruped walk forward 1 metre")
    robot = scene.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)
    card = StatusCard(ROBOT, state, trace_id="of a lost journal")
    await robot.reply(post.topic_id, "Seen.", key=f"claim:{post.id}", reply_to=post.id, card=card)
    before = await position(scene.driver)
    async with scene.agent():
        assert (await scene.final(post)).card.state == "interrupted"
    assert await position(scene.driver) == pytest.approx(before, abs=STILL_M)
    assert len(scene.replies(post)) == 1


async def test_law_6_what_a_lost_journal_had_answered_is_left_alone(scene: Scene) -> None:
    async with scene.agent():
        post = await scene.post("alice", "@quadruped turn left 90 degrees")
        reply = await scene.final(post)
    scene.journal.delete()
    async with scene.agent():
        later = await scene.post("alice", "@quadruped help")
        await scene.final(later)
    assert [r.raw for r in scene.replies(post)] == [reply.raw]


async def test_law_6_a_journal_of_yesterday_moves_nothing_again(scene: Scene) -> None:
    async with scene.agent():
        pass
    yesterday = scene.journal.copy()
    async with scene.agent():
        post = await scene.post("alice", "@quadruped walk forward 1 metre")
        await scene.final(post)
    scene.journal.restore(yesterday)
    stood = await position(scene.driver)
    async with scene.agent():
        await scene.final(await scene.post("alice", "@quadruped help"))
    assert await position(scene.driver) == pytest.approx(stood, abs=STILL_M)
    assert [r.card.state for r in scene.replies(post) if r.card] == ["done"]


async def test_law_6_the_same_event_twice_is_one_command(scene: Scene) -> None:
    async with scene.agent():
        post = await scene.post("alice", "@quadruped walk forward 1 metre")
        scene.world.emit(EventKind.POST_CREATED, post=post)
        await scene.final(post)
        stood = await position(scene.driver)
        scene.world.emit(EventKind.POST_CREATED, post=post)
        await scene.final(await scene.post("alice", "@quadruped help"))
    assert await position(scene.driver) == pytest.approx(stood, abs=STILL_M)
    assert len(scene.replies(post)) == 1


async def test_what_was_posted_while_the_agent_was_away_is_done_when_it_is_fresh(scene: Scene) -> None:
    async with scene.agent():
        pass
    post = await scene.post("alice", "@quadruped turn left 90 degrees")
    async with scene.agent():
        assert (await scene.final(post)).card.state == "done"


async def test_law_5_what_was_posted_before_the_first_start_is_answered_once(scene: Scene) -> None:
    post = await scene.post("alice", "@quadruped walk forward 1 metre")
    before = await position(scene.driver)
    for _ in range(2):
        async with scene.agent():
            reply = await scene.final(post)
            await scene.final(await scene.post("alice", "@quadruped help"))
    assert reply.card.state == "expired"
    assert len(scene.replies(post)) == 1
    assert await position(scene.driver) == pytest.approx(before, abs=STILL_M)


class SlowMind(RulesMind):
    """A mind that waits until it is released and then understands nothing."""

    def __init__(self) -> None:
        self.asked = asyncio.Event()
        self.let = asyncio.Event()

    async def understand(self, text: str, addressee: Addressee, history: tuple[Plan, ...] = ()) -> Understanding:
        self.asked.set()
        await self.let.wait()
        return await super().understand(text, addressee, history)


@pytest.mark.parametrize("what", ["edit", "remove", "give", "hand over", "move", "suspend", "demote", "stop", "expire"])
async def test_law_4_what_changed_since_it_was_posted_moves_nothing(driver: Driver, tmp_path: Path, what: str) -> None:
    expiry_s = 0.3 if what == "expire" else 600.0
    scene = make_scene(driver, tmp_path, queue_expiry_s=expiry_s)
    mind = SlowMind()
    before = await position(driver)
    async with scene.agent(mind=mind):
        post = await scene.post("alice", "@quadruped walk forward 1 metre")
        await mind.asked.wait()
        await scene.state(post, "seen")
        match what:
            case "edit":
                await scene.world.sign_in("alice").edit(post.id, "@quadruped walk forward 2 metres")
            case "remove":
                scene.world.remove(post.id)
            case "give":  # a moderator changes the post's owner, as with NodeBB's "Change Owner"; no event reports it
                scene.world.give(post.id, "bob")
            case "hand over":  # also to an account that may command but did not write it
                scene.person("carol")
                scene.world.give(post.id, "carol")
            case "move":  # a moderator moves the topic to a board that the robot does not read
                scene.world.move(post.topic_id, "talk")
            case "suspend":
                scene.world.suspend("alice")
            case "demote":
                scene.world.set_role("alice", Role.MEMBER)
            case "stop":
                await scene.post("bob", "@quadruped stop")
            case "expire":
                await asyncio.sleep(expiry_s)
        if what == "stop":
            await scene.until(lambda: any("standing still" in p.raw for p in scene.world.posts.values()))
        mind.let.set()
        reply = await scene.final(post)
    assert await position(driver) == pytest.approx(before, abs=STILL_M)
    wanted = {"demote": "refused", "expire": "expired"}
    assert reply.card.state == wanted.get(what, "cancelled")
    assert ("now belongs to another account" in reply.raw) == (what in ("give", "hand over"))
    assert ("moved to a board" in reply.raw) == (what == "move")


async def test_commands_are_done_one_by_one_in_the_order_of_their_acceptance(scene: Scene) -> None:
    async with scene.agent():
        posts = [await scene.post("alice", f"@quadruped turn left {90 + n} degrees") for n in range(4)]
        await scene.state(posts[3], "queued")
        finals = [await scene.final(post) for post in posts]
    times = [json.loads((scene.folder / f"agents/{ROBOT}/records/{p.id}.json").read_text()) for p in posts]
    done = [t["timings_ms"]["done"] + i for i, t in enumerate(times)]
    assert [f.card.state for f in finals] == ["done"] * 4
    assert done == sorted(done)


async def test_law_7_the_limits_of_today_count_when_it_moves(scene: Scene) -> None:
    """The robot's own limits were lowered after the command was screened."""
    scene_driver = scene.driver.client()
    real = scene_driver.capabilities
    asked = 0

    async def lowered():  # type: ignore[no-untyped-def]
        nonlocal asked
        asked += 1
        now = await real()
        return now if asked <= 1 else replace(now, limits=replace(now.limits, step_m=0.5))

    scene_driver.capabilities = lowered  # type: ignore[method-assign]
    before = await position(scene.driver)
    async with scene.agent(driver=scene_driver, forum=forum_without_page(scene)):
        post = await scene.post("alice", "@quadruped walk forward 1 metre")
        reply = await scene.final(post)
    assert reply.card.state == "refused"
    assert await position(scene.driver) == pytest.approx(before, abs=STILL_M)


def forum_without_page(scene: Scene):  # type: ignore[no-untyped-def]
    """The robot's forum without its page, because the card also asks for the limits."""
    forum = scene.world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)

    class ForumWithoutPage:
        max_edits, live, fastest_poll_s = forum.max_edits, forum.live, forum.fastest_poll_s

        def __getattr__(self, name: str):  # type: ignore[no-untyped-def]
            if name.startswith("publish"):
                raise AttributeError(name)
            return getattr(forum, name)

    return ForumWithoutPage()


async def test_a_forum_that_goes_away_for_a_while_loses_nothing(scene: Scene) -> None:
    async with scene.agent():
        first = await scene.post("alice", "@quadruped turn left 90 degrees")
        scene.world.reachable = False
        await scene.until(lambda: scene.world.unanswered > 1)
        scene.world.reachable = True
        await scene.final(first)
        second = await scene.post("alice", "@quadruped turn right 90 degrees")
        assert (await scene.final(second)).card.state == "done"


async def test_law_16_a_silent_forum_stops_a_moving_robot(tmp_path: Path, slow_driver: Driver) -> None:
    scene = make_scene(slow_driver, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", "@quadruped walk forward 5 metres")
        await scene.state(post, "running")
        scene.world.reachable = False
        async with asyncio.timeout(60), slow_driver.client() as client:
            await until(client.state, lambda state: state.velocity_mps[0] > 0.1)
            await until(client.state, lambda state: state.velocity_mps == (0.0, 0.0))
        scene.world.reachable = True
        reply = await scene.final(post)
    assert reply.card.state == "interrupted", reply.raw
    assert (await position(slow_driver))[0] < 3.0


async def test_law_16_a_forum_that_cannot_be_heard_each_second_bounds_every_step(
    tmp_path: Path, driver: Driver
) -> None:
    scene = make_scene(driver, tmp_path, poll_s=0.1)
    scene.world.live, scene.world.fastest_poll_s = False, 1.1
    async with scene.agent():
        far = await scene.post("alice", "@quadruped walk forward 4 metres")
        near = await scene.post("alice", "@quadruped walk forward 1 metre")
        refused, done = await scene.final(far), await scene.final(near)
    assert refused.card.state == "refused"
    assert "`limit.step_time`" in refused.raw
    assert "limit of 5 s" in refused.raw
    assert done.card.state == "done", done.raw


async def test_law_16_where_polls_are_slow_a_step_that_does_not_end_is_ended_after_five_seconds(
    tmp_path: Path, slow_driver: Driver
) -> None:
    """The robot is slower than its capabilities say, so the screen allowed the step."""
    scene = make_scene(slow_driver, tmp_path, poll_s=0.1)
    scene.world.live, scene.world.fastest_poll_s = False, 1.1
    async with scene.agent() as agent:
        step = agent.driver.step
        deadlines: list[float] = []

        async def listen(lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
            deadlines.append(deadline_s)
            return await step(lease, primitive, deadline_s)

        agent.driver.step = listen  # type: ignore[method-assign]
        reply = await scene.final(await scene.post("alice", "@quadruped turn left 10 degrees"))
    assert reply.card.state == "done", reply.raw
    assert deadlines == [5.0]


async def test_the_journal_keeps_its_thoughts_and_forgets_what_was_unfinished(tmp_path: Path) -> None:
    async def answer(text: str) -> str:
        return text

    journal = await open_journal(tmp_path, ROBOT)
    assert await journal.assess("1", lambda: answer("one")) == "one"
    assert await journal.move("1", lambda: answer("moved")) == "moved"
    assert await journal.cancel("2")
    begun = asyncio.Event()

    async def hang() -> str:
        begun.set()
        await asyncio.Event().wait()
        return "never"

    stuck = asyncio.create_task(journal.move("3", hang))
    await asyncio.wait_for(begun.wait(), 60)
    await journal.close()
    await asyncio.gather(stuck, return_exceptions=True)
    journal = await open_journal(tmp_path, ROBOT)
    assert await journal.assess("1", lambda: answer("two")) == "one"
    assert await journal.move("1", lambda: answer("again")) == "moved"
    assert await journal.move("2", lambda: answer("moved")) == "cancelled"
    assert await journal.move("3", lambda: answer("moved")) == "interrupted"
    assert not await journal.cancel("3")
    await journal.close()
