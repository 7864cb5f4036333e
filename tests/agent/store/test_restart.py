"""An agent that restarts (laws 4, 5, 6 and 14): what was ended stays ended, and missed stops count first."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import httpx2
import pytest

from agentrob.agent import agent as turn
from agentrob.agent.store import rows
from agentrob.errors import ForumError, RobotUnreachable
from agentrob.forums.memory.forum import MemoryForum
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import Account, AccountKind, Command, EndReason, Plan, Role, StatusCard, StopResult, Understanding
from agentrob.robots.driver.client import DriverClient
from tests.agent.agent_scene import ROBOT, Driver, Scene, held_by, make_scene, robot_settings
from tests.agent.store.journal_store import open_journal
from tests.agent.store.old_journal import OLDEST_CLAIM, write_old_journal
from tests.waiting import until, walks

pytestmark = pytest.mark.usefixtures("database")
AGENTS_DIE = True

STILL_M = 0.02


class StuckMind(RulesMind):
    """A mind that understands nothing, so that its agent ends with the command still open."""

    def __init__(self) -> None:
        self.asked = asyncio.Event()

    async def understand(self, text: str, addressee: Addressee, history: tuple[Plan, ...] = ()) -> Understanding:
        self.asked.set()
        await asyncio.Event().wait()
        raise AssertionError


async def place(driver: Driver) -> tuple[float, float]:
    async with driver.client() as client:
        pose = (await client.state()).pose
    assert pose is not None
    return pose.x_m, pose.y_m


async def started(scene: Scene) -> None:
    """Start the agent for the first time, which sets the watermark."""
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
        if what in ("stale", "edited"):  # it is ended before it is read, so no mind is asked
            await scene.final(post)
        else:
            await asyncio.wait_for(mind.asked.wait(), 60)
        assert mind.asked.is_set() == (what in ("stopped", "removed"))
        match what:
            case "stopped":
                said = await scene.post("bob", "stop", topic=post.topic_id)
                await scene.until(lambda: scene.replies(said))
            case "removed":
                scene.world.remove(post.id)
        async with asyncio.timeout(60):  # until the journal has it, which the next start reads
            while (claim := await agent.journal.claimed(post.id)) is None or not (claim.ended or claim.final):
                await scene.world.wait(0.05)
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
        await asyncio.wait_for(mind.asked.wait(), 60)
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
        await asyncio.wait_for(mind.asked.wait(), 60)
        await scene.state(posts[1], "seen")
    async with scene.agent() as agent:
        assert (await scene.final(posts[0])).card.state == "done"
        await scene.final(posts[1])
        claim = await agent.journal.claimed(posts[0].id)
        assert (
            claim.why_not(agent.event_stream.now(), agent.clock.watermark_at, agent.stop_handler.stopped_at, 120)
            is None
        )
        scene.world.clock_offset_s = 125
        await agent.event_stream.set_clock()
        assert (
            claim.why_not(agent.event_stream.now(), agent.clock.watermark_at, agent.stop_handler.stopped_at, 120)
            == "stale"
        )


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
    await asyncio.wait_for(agent.once(), 60)
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
    real = turn.triage

    def fragile(post, *more):  # type: ignore[no-untyped-def]
        if "poison" in post.raw:
            raise ZeroDivisionError
        return real(post, *more)

    monkeypatch.setattr(turn, "triage", fragile)
    async with scene.agent():
        await scene.post("bob", "poison")
        assert (await scene.final(await scene.post("alice", "@quadruped turn left 90 degrees"))).card.state == "done"


async def test_a_journal_of_an_earlier_version_is_read_and_can_keep_an_end(tmp_path: Path) -> None:
    alice = Account("a1", "alice", AccountKind.HUMAN, Role.OPERATOR)
    command = Command("7", "1", "h", alice, ROBOT, "wave", "en", datetime.now(UTC), "trace")
    write_old_journal(tmp_path, ROBOT, command, columns=OLDEST_CLAIM)
    journal = await open_journal(tmp_path, ROBOT)
    assert [c.ended for c in await journal.open_claims()] == [None]
    await journal.end(["7"], EndReason.STOP)
    await journal.end(["7"], EndReason.EDITED)
    await journal.close()
    journal = await open_journal(tmp_path, ROBOT)
    assert [c.ended for c in await journal.open_claims()] == ["stop"]
    assert not await journal.cancel("7")  # the motion was cancelled with it
    assert not await journal.moved("7")
    await journal.close()


async def test_an_agent_whose_forum_was_replaced_begins_anew_and_moves_nothing_older(scene: Scene) -> None:
    async with scene.agent() as agent:
        for _ in range(3):
            await scene.final(await scene.post("alice", "@quadruped turn left 90 degrees"))
        await agent.journal.put("cursor", agent.event_stream.cursor)
    scene.world = other = MemoryForum.world()
    for name in ("alice", "bob"):
        scene.person(name)
    scene.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)
    old = await scene.post("alice", "@quadruped walk forward 1 metre")
    stood = await place(scene.driver)
    async with scene.agent():
        post = await scene.post("alice", "@quadruped turn right 90 degrees")
        assert (await scene.final(post)).card.state == "done"
        assert [r.card.state for r in scene.replies(old)] == ["expired"]
    assert other.posts[post.id].raw.startswith("@quadruped turn right")
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)


async def test_a_forum_replaced_while_the_agent_runs_ends_what_it_did_and_is_served(scene: Scene) -> None:
    async with scene.agent() as agent:
        for _ in range(3):
            await scene.final(await scene.post("alice", "@quadruped turn left 90 degrees"))
        scene.world = MemoryForum.world()
        for name in ("alice", "bob"):
            scene.person(name)
        scene.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)
        agent.forum._world = scene.world
        await scene.until(lambda: agent.event_stream.cursor == "0")
        post = await scene.post("alice", "@quadruped turn right 90 degrees")
        assert (await scene.final(post)).card.state == "done"


async def test_a_single_run_goes_on_after_what_it_accepted(scene: Scene) -> None:
    await started(scene)
    await scene.post("alice", "@quadruped turn left 90 degrees")
    agent = scene.make()
    await asyncio.wait_for(agent.once(), 60)
    await agent.close()
    heard: list[str] = []
    again = scene.make()
    hear = again._handle_event

    def listen(event):  # type: ignore[no-untyped-def]
        heard.append(event.post.raw if event.post else "")
        hear(event)

    again._handle_event = listen  # type: ignore[method-assign]
    await asyncio.wait_for(again.once(), 60)
    await again.close()
    assert "@quadruped turn left 90 degrees" not in heard


async def test_law_14_a_stop_that_the_forum_knows_nothing_of_ends_what_was_accepted_before_it(scene: Scene) -> None:
    class GatedMind(RulesMind):
        asked, let = asyncio.Event(), asyncio.Event()

        async def understand(self, *more):  # type: ignore[no-untyped-def]
            self.asked.set()
            await self.let.wait()
            return await super().understand(*more)

    mind = GatedMind()
    stood = await place(scene.driver)
    async with scene.agent(mind=mind):
        post = await scene.post("alice", "@quadruped walk forward 1 metre")
        await asyncio.wait_for(mind.asked.wait(), 60)
        async with scene.driver.client() as client:
            await client.stop("somebody at the robot")
        mind.let.set()
        assert (await scene.final(post)).card.state == "stopped"
        later = await scene.post("alice", "@quadruped turn left 90 degrees")
        assert (await scene.final(later)).card.state == "done"
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)


@pytest.mark.parametrize(
    ("then", "state"), [("soon", "done"), ("late", "expired"), ("stopped", "stopped"), ("stopped before", "stopped")]
)
async def test_laws_5_6_and_14_ending_the_agent_while_a_command_moves_leaves_the_next_one_to_its_next_start(
    scene: Scene, then: str, state: str
) -> None:
    async with scene.agent():
        first = await scene.post("alice", "@quadruped walk forward 5 metres, then walk backward 5 metres")
        second = await scene.post("alice", "@quadruped turn left 90 degrees")
        await scene.state(second, "queued")
        await scene.state(first, "running")
        if then == "stopped before":  # the event loop is blocked, so the agent ends before it gets the event
            with httpx2.Client(
                transport=httpx2.HTTPTransport(uds=str(scene.driver.socket), verify=False), timeout=60
            ) as somebody:
                somebody.post("http://driver/stop", json={"by": "somebody at the robot"}).raise_for_status()
    if then != "stopped before":
        shown = [reply.card.state for reply in (*scene.replies(first), *scene.replies(second))]
        assert shown == ["interrupted", "queued"]
    match then:
        case "late":
            scene.world.clock_offset_s = 125
        case "stopped":
            async with scene.driver.client() as client:
                await client.stop("somebody at the robot")
    async with scene.agent():
        assert (await scene.final(second)).card.state == state
    assert len(scene.replies(first)) == 1


async def test_law_6_a_motion_that_the_agent_s_end_overtook_has_not_begun(scene: Scene) -> None:
    """The command had its turn and was on disk when the agent ended."""
    stood = await place(scene.driver)
    async with scene.agent() as agent:
        agent._ending = True
        post = await scene.post("alice", "@quadruped walk forward 0.2 metres")
        await scene.until(lambda: scene.replies(post) and not agent.queue)
    assert [reply.card.state for reply in scene.replies(post)] == ["seen"]
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)
    async with scene.agent():
        assert (await scene.final(post)).card.state == "done"


@pytest.mark.parametrize("max_edits", [None, 0])
async def test_law_6_a_picture_that_the_forum_refuses_does_not_cost_the_final_reply(
    driver: Driver, tmp_path: Path, max_edits: int | None
) -> None:
    scene = make_scene(driver, tmp_path, MemoryForum.world(max_edits=max_edits))

    def refuse(post_id, images):  # type: ignore[no-untyped-def]
        if images:
            raise ForumError("415 this is no picture")
        return ()

    scene.world.keep = refuse  # type: ignore[method-assign]
    async with scene.agent():
        post = await scene.post("alice", "@quadruped take a photo")
        reply = await scene.final(post)
    assert (reply.card.state, reply.images) == ("done", ())


async def test_a_press_of_the_reset_button_that_is_old_resets_nothing(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    resets: list[str] = []

    async def reset_room(driver: object, settings: object, by: str) -> None:
        resets.append(by)

    monkeypatch.setattr(turn, "reset_room", reset_room)
    scene.settings = robot_settings(room_reset="http://127.0.0.1:9/reset")
    async with scene.agent() as agent:
        alice = await scene.world.sign_in("alice").me()
        await agent._reset(alice, agent.event_stream.now() - timedelta(seconds=scene.settings.max_post_age_s + 5))
        assert resets == []
        await agent._reset(alice, agent.event_stream.now())
        assert resets == ["alice"]


async def test_law_17_a_halt_that_only_stopped_is_not_called_a_halt(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)

    class DisconnectedClient(DriverClient):
        """The first channel is gone; the second still stops."""

        async def halt(self, by: str) -> StopResult:
            raise RobotUnreachable("no driver")

    async with scene.agent(driver=DisconnectedClient(driver.name, driver.socket)):
        post = await scene.post("bob", "@quadruped emergency stop!")
        (reply,) = await scene.until(lambda: scene.replies(post))
    assert "It is **not halted**" in reply.raw
    assert "refuses all motion" not in reply.raw


async def test_a_running_command_that_is_removed_does_not_take_the_next_one_with_it(scene: Scene) -> None:
    async with scene.agent():
        first = await scene.post("alice", "@quadruped walk forward 5 metres, then walk backward 5 metres")
        second = await scene.post("alice", "@quadruped turn left 90 degrees")
        await scene.state(second, "queued")
        await scene.state(first, "running")
        scene.world.remove(first.id)
        assert (await scene.final(first)).card.state in ("interrupted", "failed", "stopped", "cancelled")
        assert (await scene.final(second)).card.state == "done"


@pytest.mark.parametrize("reported", [True, False])
async def test_law_6_a_journal_copied_before_the_motion_moves_it_no_second_time(scene: Scene, reported: bool) -> None:
    """The copy knows the claim but no motion; the forum knows that the motion ended, or that it runs."""
    await started(scene)
    mind = StuckMind()
    async with scene.agent(mind=mind):
        post = await scene.post("alice", "@quadruped walk forward 1 metre")
        await mind.asked.wait()
        await scene.state(post, "seen")
    copy = scene.journal.copy()
    async with scene.agent() as agent:
        running = await scene.state(post, "running")
        if reported:
            assert (await scene.final(post)).card.state == "done"  # type: ignore[union-attr]
            await scene.until(lambda: not agent.queue)
    if not reported:  # as after a crash: nobody wrote the end
        scene.world.posts[running.id] = running
    scene.journal.restore(copy)
    before = await place(scene.driver)
    async with scene.agent():
        last = await scene.post("alice", "@quadruped turn left 10 degrees")
        assert (await scene.final(last)).card.state == "done"  # type: ignore[union-attr]
        reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == ("done" if reported else "interrupted")
    assert max(abs(a - b) for a, b in zip(before, await place(scene.driver), strict=True)) < STILL_M


@pytest.mark.parametrize("reported", [pytest.param(True, marks=pytest.mark.slow), False])
@pytest.mark.parametrize("why", ["edited", pytest.param("stopped", marks=pytest.mark.slow), "late"])
async def test_law_6_of_a_motion_that_began_nothing_but_its_end_is_reported_once(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, why: str, reported: bool
) -> None:
    """The journal knows that it began, as after a crash; the forum knows that it ended, or that it runs."""
    async with scene.agent() as agent:
        post = await scene.post("alice", "@quadruped walk forward 5 metres")
        running = await scene.state(post, "running")
        copy = scene.journal.copy()
        assert (await scene.final(post)).card.state == "done"
        await scene.until(lambda: not agent.queue)
    scene.journal.restore(copy)
    if not reported:
        scene.world.posts[running.id] = running
    match why:
        case "edited":
            await scene.world.sign_in("alice").edit(post.id, "@quadruped walk forward 2 metres")
        case "stopped":
            await scene.post("bob", "@quadruped stop")
        case "late":
            later = rows.boot_s() + 700.0
            monkeypatch.setattr(rows, "boot_s", lambda: later)
    before = await place(scene.driver)
    async with scene.agent():
        await scene.final(await scene.post("alice", "@quadruped help"))
        if not reported:
            assert (await scene.final(post)).card.state == "interrupted"
    (reply,) = scene.replies(post)
    assert reply.card.state == ("done" if reported else "interrupted")
    assert max(abs(a - b) for a, b in zip(before, await place(scene.driver), strict=True)) < STILL_M


async def test_law_6_a_driver_that_dies_under_a_motion_interrupts_it_and_it_is_not_repeated(tmp_path: Path) -> None:
    mortal = Driver(tmp_path, robot_settings(options={"time_scale": 1}), name="mortal")
    scene = make_scene(mortal, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", f"@{ROBOT} walk forward 4 metres, then wave")
        await scene.state(post, "running")
        mortal.process.kill()
        reply = await scene.final(post)
        assert reply.card.state == "interrupted", reply.raw
        assert "cannot tell whether the robot stands" in reply.raw
        assert "not begun" in reply.raw
    mortal.end()


@pytest.mark.parametrize("gone", ["removed", "suspended"])
async def test_law_6_a_status_that_a_lost_journal_left_open_is_ended_although_its_command_is_gone(
    scene: Scene, gone: str
) -> None:
    post = await scene.post("alice", f"@{ROBOT} walk forward 1 metre")
    robot = scene.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)
    scene.person("carol")
    for state in ("running", "done"):
        card = StatusCard(ROBOT, state, trace_id="of a lost journal")
        await robot.reply(post.topic_id, state, key=f"claim:{state}", reply_to=post.id, card=card)
    if gone == "removed":
        scene.world.remove(post.id)
    else:
        scene.world.suspend("alice")
    async with scene.agent():
        await scene.final(await scene.post("carol", f"@{ROBOT} help"))
        # It waits whether another agent ends it.
        await scene.until(lambda: "running" not in [r.card.state for r in scene.replies(post) if r.card])
        ends = [(r.card.state, r.version) for r in scene.replies(post) if r.card]
    assert ends == [("interrupted", 2), ("done", 1)]


async def test_law_11_a_dead_agent_s_lease_is_waited_for_and_a_living_holder_s_is_reported(scene: Scene) -> None:
    async with scene.agent(), scene.driver.client() as other:
        await other._call("POST", "/lease", {"holder": "an agent that was killed", "since_s": None})  # never renewed
        post = await scene.post("alice", f"@{ROBOT} turn left 30 degrees")
        assert (await scene.final(post)).card.state == "done"
        async with held_by("somebody at the console", scene.driver):
            post = await scene.post("alice", f"@{ROBOT} turn left 30 degrees")
            reply = await scene.final(post)
        assert reply.card.state == "failed"
        assert "somebody at the console holds the robot" in reply.raw


async def test_law_14_a_stop_ends_a_command_that_waits_for_a_busy_robot(scene: Scene) -> None:
    async with scene.agent() as agent, held_by("somebody at the console", scene.driver):
        post = await scene.post("alice", f"@{ROBOT} turn left 30 degrees")
        await scene.until(lambda: agent.queue.moving)
        await scene.post("bob", f"@{ROBOT} stop")
        assert (await scene.final(post)).card.state == "stopped"


async def test_law_17_a_stop_past_the_forum_is_reported_with_whose_it_was(tmp_path: Path) -> None:
    local = Driver(tmp_path, robot_settings(options={"time_scale": 1}), name="local")
    scene = make_scene(local, tmp_path)
    try:
        async with scene.agent(), local.client() as other:
            post = await scene.post("alice", f"@{ROBOT} walk forward 5 metres")
            await scene.state(post, "running")
            await until(other.state, walks)
            await other.stop("@alice `beside` the robot")
            reply = await scene.final(post)
    finally:
        local.end()
    assert reply.card.state == "stopped"
    assert reply.raw.startswith("**Stopped** by `(at)alice 'beside' the robot`.")
