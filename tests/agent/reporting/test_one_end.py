"""Each command gets one truthful end: with two agents of one account, with an account that may not write for a while,
and across restarts."""

from __future__ import annotations

import asyncio
import contextlib
import re
import sqlite3
from collections.abc import AsyncIterator, Coroutine
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.agent.reporting import status_post as status
from agentrob.agent.reporting.status_post import Shown, StatusPost
from agentrob.board.admin import local_admin
from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumDenied, ForumUnreachable
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.forums.memory.forum import MemoryForum
from agentrob.forums.protocol import Written
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, Command, Plan, Post, Role, StatusCard, Understanding
from agentrob.robots.driver.lease import TTL_S
from tests.agent.agent_process import Poster, end_agent, start_agent, until_state
from tests.agent.agent_scene import FINAL, ROBOT, Driver, Scene, make_scene, robot_settings, serving
from tests.board.running_board import RunningBoard, running_board
from tests.waiting import until

AGENTS_DIE = True
WALK = f"@{ROBOT} walk forward 1 metre"
MEASURED = re.compile(r"walk forward 1 m \| (0\.9\d|1\.0\d) m \| done")
GUESS = "**Interrupted.** This post was taken up before"


@pytest.fixture
def slow_driver(tmp_path: Path) -> Driver:
    made = Driver(tmp_path, robot_settings(options={"time_scale": 1}), name="slow", lease_s=TTL_S)
    yield made  # type: ignore[misc]
    made.end()


async def place(driver: Driver) -> tuple[float, float]:
    async with driver.client() as client:
        pose = (await client.state()).pose
    assert pose is not None
    return pose.x_m, pose.y_m


def other(scene: Scene) -> MemoryForum:
    """Return the forum client of another agent of the same account."""
    return scene.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)


async def claimed(scene: Scene, post: Post, state: str) -> Post:
    """Let another agent claim this post and bring it to this state."""
    card = StatusCard(ROBOT, state, trace_id="theirs")
    written = await other(scene).reply(post.topic_id, "Theirs.", key=f"claim:{post.id}", reply_to=post.id, card=card)
    return written.post


# ------------------------------------------------------------------ two agents of one account
@pytest.mark.parametrize("state", ["queued", "running"])
async def test_law_6_who_does_not_hold_the_claim_writes_nothing_over_the_end_of_who_does(
    scene: Scene, state: str
) -> None:
    """Its own queue is busy, so the other's command would be shown as queued."""
    edits = list[str]()

    class EditCountingForum(MemoryForum):
        async def edit(self, post_id: str, body: str, **more: object) -> Post:
            edits.append(post_id)
            return await super().edit(post_id, body, **more)  # type: ignore[arg-type]

    async with scene.agent(forum=EditCountingForum(scene.world, ROBOT)) as agent:
        first = await scene.post("alice", f"@{ROBOT} walk forward 5 metres, then walk backward 5 metres")
        await scene.state(first, "running")
        post = await scene.post("alice", WALK)
        status_post = await claimed(scene, post, state)
        third = await scene.post("alice", f"@{ROBOT} turn left 20 degrees")
        await scene.until(lambda: scene.replies(third))
        card = StatusCard(ROBOT, "done", step=1, steps=1, trace_id="theirs")
        await other(scene).edit(status_post.id, "**Done.** walk forward 1 m | 0.98 m", card=card)
        await scene.final(first)
        await scene.final(third)
        async with asyncio.timeout(60):
            while not (claim := await agent.journal.claimed(post.id)) or claim.final is None:
                await scene.world.wait(0.1)
    (reply,) = scene.replies(post)
    assert reply.raw == "**Done.** walk forward 1 m | 0.98 m"
    assert claim.final == "handled_elsewhere"
    assert status_post.id not in edits


async def test_law_6_a_claim_whose_end_another_told_moves_nothing_any_more(scene: Scene) -> None:
    class GatedMind(RulesMind):
        asked, let = asyncio.Event(), asyncio.Event()

        async def understand(self, text: str, addressee: Addressee, history: tuple[Plan, ...] = ()) -> Understanding:  # type: ignore[override]
            self.asked.set()
            await self.let.wait()
            return await super().understand(text, addressee, history)

    stood, mind = await place(scene.driver), GatedMind()
    async with scene.agent(mind=mind) as agent:
        post = await scene.post("alice", WALK)
        seen = await scene.state(post, "seen")
        assert seen.card is not None
        guess = replace(seen.card, state="interrupted", trace_id="theirs")
        edited = await other(scene).edit(seen.id, f"{GUESS}.", card=guess)
        mind.let.set()
        await scene.until(lambda: not agent.queue)
    assert await place(scene.driver) == pytest.approx(stood, abs=0.02)
    assert [r.raw for r in scene.replies(post)] == [edited.raw]


async def test_law_18_what_was_measured_takes_the_place_of_another_agents_guess(
    tmp_path: Path, slow_driver: Driver
) -> None:
    scene = make_scene(slow_driver, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", WALK)
        running = await scene.state(post, "running")
        assert running.card is not None
        guess = replace(running.card, state="interrupted", step=0, steps=0, trace_id="theirs")
        await other(scene).edit(running.id, f"{GUESS}.", card=guess)
        await scene.until(lambda: "0." in scene.replies(post)[0].raw)
    (reply,) = scene.replies(post)
    assert MEASURED.search(reply.raw), reply.raw
    assert reply.card is not None
    assert reply.card.state == "done"


async def test_law_6_a_claim_that_shows_its_end_is_not_shown_as_queued_again(scene: Scene) -> None:
    """As after a crash between the reply and the journal's final row, while other commands wait."""
    robot, post = other(scene), await scene.post("alice", WALK)
    card = StatusCard(ROBOT, "done", step=1, steps=1, trace_id="ours")
    account = await scene.person("alice").me()
    command = Command(post.id, post.topic_id, post.content_hash, account, ROBOT, WALK, "en", post.created_at, "ours")
    first = StatusPost(robot, command)
    await first.claim(Shown("Seen.", replace(card, state="seen")))
    assert await first.close(Shown("**Done.**", card))
    again = StatusPost(robot, command)
    written: Written = await again.claim(Shown("Seen.", replace(card, state="seen")))
    again.adopt(written.post)
    again.show(Shown("Queued, place 2.", replace(card, state="queued")))
    assert await again.close(Shown("**Done.** Told anew.", card))
    assert [(r.raw, r.version) for r in scene.replies(post)] == [("**Done.**", 2)]


class SlowForum(MemoryForum):
    """A forum that gives no answer to the first edit that ends a command in time, and makes it later."""

    late: Coroutine[object, object, Post] | None = None

    def __init__(self, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        self.asked = asyncio.Event()

    async def edit_once(self, post_id: str, body: str, **more: object) -> Post:
        edit = super().edit_once(post_id, body, **more)  # type: ignore[arg-type]
        if self.late is not None:
            return await edit
        self.late = edit
        self.asked.set()
        raise ForumUnreachable("no answer")


async def test_law_6_an_end_that_is_sent_again_while_the_first_try_is_under_way_is_written_once(scene: Scene) -> None:
    forum = SlowForum(scene.world, ROBOT)
    async with scene.agent(forum=forum):
        final = await scene.final(await scene.post("alice", WALK))
        assert MEASURED.search(final.raw)
        assert forum.late is not None
        await forum.late
    assert await forum.post(final.id) == final
    ends = [event for event in scene.world.events if event.post is not None and event.post.raw == final.raw]
    assert len(ends) == 1, "the end is in the history twice"


async def test_law_6_an_end_that_lands_after_its_agent_died_is_not_written_again(scene: Scene) -> None:
    """The agent that restarts looks before the forum has made the edit, and tells other times."""
    forum, post = SlowForum(scene.world, ROBOT), await scene.post("alice", WALK)
    card = StatusCard(ROBOT, "interrupted", step=1, steps=1, trace_id="ours")
    account = await scene.person("alice").me()
    command = Command(post.id, post.topic_id, post.content_hash, account, ROBOT, WALK, "en", post.created_at, "ours")
    first = StatusPost(forum, command)
    await first.claim(Shown("Seen.", replace(card, state="seen")))
    dying = asyncio.create_task(first.close(Shown("**Interrupted.** Seen after 0.06 s.", card)))
    await forum.asked.wait()
    dying.cancel()
    await asyncio.wait({dying})
    again = StatusPost(forum, command)
    again.adopt((await again.claim(Shown("Seen.", replace(card, state="seen")))).post)

    async def lands() -> None:
        assert forum.late is not None
        await forum.late

    assert await again.close(Shown("**Interrupted.** Seen after 1.92 s.", card), before=lands)
    assert [(r.raw, r.version) for r in scene.replies(post)] == [("**Interrupted.** Seen after 0.06 s.", 2)]


async def test_law_6_an_end_that_an_older_status_replaced_is_written_again(scene: Scene) -> None:
    robot, post = other(scene), await scene.post("alice", WALK)
    card = StatusCard(ROBOT, "interrupted", step=1, steps=1, trace_id="ours")
    account = await scene.person("alice").me()
    command = Command(post.id, post.topic_id, post.content_hash, account, ROBOT, WALK, "en", post.created_at, "ours")
    status = StatusPost(robot, command)
    claimed = await status.claim(Shown("Seen.", replace(card, state="seen")))
    assert await status.close(Shown("**Interrupted.**", card))
    await robot.edit(claimed.post.id, "Step 1 of 1.", card=replace(card, state="running"))
    again = StatusPost(robot, command)
    again.adopt((await again.claim(Shown("Seen.", replace(card, state="seen")))).post)
    assert await again.close(Shown("**Interrupted.** Told anew.", card))
    assert [(r.raw, r.card and r.card.state) for r in scene.replies(post)] == [
        ("**Interrupted.** Told anew.", "interrupted")
    ]


@pytest.mark.slow
async def test_law_6_two_agents_of_one_account_do_each_command_once_and_tell_it_once(
    tmp_path: Path, slow_driver: Driver
) -> None:
    with running_board(tmp_path / "board") as board, Poster(board, "op") as alice:
        folders = [tmp_path / "one", tmp_path / "two"]
        agents = [await asyncio.to_thread(start_agent, slow_driver, folder, board) for folder in folders]
        topics = [await alice.post(f"@{ROBOT} walk forward 0.5 m, then turn left 20 degrees") for _ in range(3)]
        for topic in topics:
            await alice.final(topic)
        last = await alice.post(f"@{ROBOT} turn right 20 degrees")
        await alice.final(last)
        ends = [await alice.status_text(topic) for topic in topics]
        states = [await alice.states(topic) for topic in topics]
        for agent in agents:
            end_agent(agent)
    assert all(len(one) == 1 and one[0] in ("done", "failed") for one in states), states
    for (state,), end in zip(states, ends, strict=True):  # each has its own queue, and one of them holds the robot
        status_text = (
            r"walk forward 0\.5 m \| 0\.[45]\d m \| done"
            if state == "done"
            else "before anything moved.*holds the robot"
        )
        assert re.search(status_text, end, re.DOTALL), end
    assert ["done"] in states


@pytest.mark.slow
async def test_law_6_two_agents_that_are_killed_in_a_walk_tell_one_end_between_them(
    tmp_path: Path, slow_driver: Driver
) -> None:
    """Both agents restart: one knows of the motion, the other only that the claim is not its own."""
    with running_board(tmp_path / "board") as board, Poster(board, "op") as alice:
        folders = [tmp_path / "one", tmp_path / "two"]
        for walked_m in (0.3, 0.9):
            agents = [await asyncio.to_thread(start_agent, slow_driver, folder, board) for folder in folders]
            topic = await alice.post(f"@{ROBOT} walk forward 2 m, then turn left 20 degrees")
            begun = (await place(slow_driver))[0]
            await until_state(slow_driver, lambda state, m=begun + walked_m: state.pose.x_m > m)  # type: ignore[misc]
            for agent in agents:
                end_agent(agent)
            agents = [await asyncio.to_thread(start_agent, slow_driver, folder, board) for folder in folders]
            assert await alice.final(topic) == ["interrupted"]
            status_text = await alice.status_text(topic)
            last = await alice.post(f"@{ROBOT} turn right 20 degrees")
            await alice.final(last)
            await until(lambda: ends(folders, "final IS NULL"), lambda left: not left)
            for agent in agents:
                end_agent(agent)
            assert (await alice.states(topic), await alice.status_text(topic)) == (["interrupted"], status_text)
            assert status_text.count("**Interrupted.**") == 1


async def ends(folders: list[Path], where: str) -> list[str]:
    """Return the rows of some agents' journals that meet a condition."""

    def read() -> list[str]:
        found: list[str] = []
        for folder in folders:
            path = folder / "agents" / ROBOT / "journal.sqlite"
            with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True, timeout=10)) as db:
                found += [row[0] for row in db.execute(f"SELECT post FROM claim WHERE {where}")]
        return found

    return await asyncio.to_thread(read)


# ------------------------------------------------------------------ an account that may not write for a while
@asynccontextmanager
async def suspended(scene: Scene) -> AsyncIterator[None]:
    scene.world.suspend(ROBOT)
    try:
        yield
    finally:
        scene.world.suspend(ROBOT, False)


class DenialCountingForum(MemoryForum):
    """Counts how often a write was denied."""

    denied = 0

    def _writing(self):  # type: ignore[no-untyped-def]
        try:
            return super()._writing()
        except ForumDenied:
            self.denied += 1
            raise


async def test_law_18_an_answer_that_was_denied_is_reported_as_soon_as_the_account_may_write(scene: Scene) -> None:
    forum = DenialCountingForum(scene.world, ROBOT)
    async with scene.agent(forum=forum) as agent:
        post = await scene.post("alice", f"{WALK}, then turn left 90 degrees")
        await scene.state(post, "running")
        async with suspended(scene):
            await scene.until(lambda: not agent.queue.moving)
            seen = forum.denied
            meanwhile = await scene.post("alice", f"@{ROBOT} turn right 30 degrees")
            await scene.until(lambda: forum.denied > seen + 3)
            assert all(r.card and r.card.state not in FINAL for r in scene.replies(post))
        reply, second = await scene.final(post), await scene.final(meanwhile)
    assert MEASURED.search(reply.raw), reply.raw
    assert reply.card is not None
    assert second.card is not None
    assert (reply.card.state, second.card.state) == ("done", "done")
    assert [len(scene.replies(p)) for p in (post, meanwhile)] == [1, 1]


async def test_law_18_an_answer_that_was_denied_is_reported_after_a_restart_too(scene: Scene) -> None:
    forum = DenialCountingForum(scene.world, ROBOT)
    async with suspended(scene):
        scene.world.suspend(ROBOT, False)
        async with scene.agent(forum=forum) as agent:
            post = await scene.post("alice", WALK)
            await scene.state(post, "running")
            scene.world.suspend(ROBOT)
            await scene.until(lambda: not agent.queue)
            await scene.until(lambda: forum.denied > 3)
        async with scene.agent(forum=(again := DenialCountingForum(scene.world, ROBOT))):
            await scene.until(lambda: again.denied)
            scene.world.suspend(ROBOT, False)
            reply = await scene.final(post)
    assert MEASURED.search(reply.raw), reply.raw
    assert len(scene.replies(post)) == 1


async def test_a_single_run_leaves_what_it_may_not_tell_to_the_next_one(scene: Scene) -> None:
    async with scene.agent():
        pass
    post = await scene.post("alice", WALK)
    async with suspended(scene):
        agent = scene.make()
        await asyncio.wait_for(agent.once(), 60)
        await agent.close()
        assert not scene.replies(post)
    agent = scene.make()
    await asyncio.wait_for(agent.once(), 60)
    await agent.close()
    assert (await scene.final(post)).card.state == "done"  # type: ignore[union-attr]


async def test_a_post_that_may_not_be_edited_any_more_is_answered_by_a_reply(scene: Scene) -> None:
    class ReadOnlyForum(MemoryForum):
        async def edit(self, post_id: str, body: str, **more: object) -> Post:
            raise ForumDenied("posts may be edited for a minute here")

    async with scene.agent(forum=ReadOnlyForum(scene.world, ROBOT)):
        reply = await scene.final(await scene.post("alice", WALK))
    assert MEASURED.search(reply.raw)


async def test_a_reply_to_a_stop_that_was_denied_is_written_when_the_account_may_write(scene: Scene) -> None:
    forum = DenialCountingForum(scene.world, ROBOT)
    async with scene.agent(forum=forum):
        async with suspended(scene):
            stop = await scene.post("bob", f"@{ROBOT} stop")
            await scene.until(lambda: forum.denied)
        (reply,) = await scene.until(lambda: scene.replies(stop))
    assert "standing still" in reply.raw


def suspend(board: RunningBoard, suspended: bool) -> None:
    local_admin.change_account(board.settings, local_admin.find_account(board.settings, ROBOT), suspended=suspended)


async def test_law_18_on_the_board_a_robot_suspended_in_a_walk_tells_its_end_when_it_is_let_in_again(
    tmp_path: Path, slow_driver: Driver
) -> None:
    with running_board(tmp_path / "board") as board, Poster(board, "op") as alice:
        forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
        agent = RobotAgent(ROBOT, slow_driver.settings, forum, slow_driver.client(), RulesMind(), tmp_path)
        async with serving(agent):
            topic = await alice.post(f"@{ROBOT} walk forward 1 m, then walk backward 1 m")
            await until_state(slow_driver, lambda state: state.pose.x_m > 0.3)
            await asyncio.to_thread(suspend, board, True)
            await until(lambda: not agent.queue.moving and agent.writes.tasks)
            await asyncio.to_thread(suspend, board, False)
            assert (await alice.final(topic))[0] in ("interrupted", "cancelled")
            status_text = await alice.status_text(topic)
            again = await alice.post(f"@{ROBOT} turn left 20 degrees")
            assert await alice.final(again) == ["done"]
    assert re.search(r"walk forward 1 m \| [01]\.\d\d m", status_text), status_text


async def test_what_is_denied_for_too_long_comes_through(monkeypatch: pytest.MonkeyPatch) -> None:
    async def denied() -> None:
        raise ForumDenied("suspended")

    monkeypatch.setattr(status, "_DENIED_S", (0.001, 0.001))
    waited = list[float]()

    async def wait(seconds: float) -> None:
        waited.append(seconds)
        await asyncio.sleep(seconds)

    with pytest.raises(ForumDenied):
        await status.retry_while_denied(denied, 0.02, wait)
    assert waited
