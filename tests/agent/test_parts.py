"""Parts of an agent in isolation: status line, channel, plot, camera, presence, single run, footer."""

from __future__ import annotations

import asyncio
import io
import math
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from agentrob.agent.intake import event_stream
from agentrob.agent.intake.event_stream import EventStream
from agentrob.agent.media.camera import Camera
from agentrob.agent.media.plot import path_plot
from agentrob.agent.reporting.status_post import Shown, StatusPost
from agentrob.errors import ForumUnreachable, MindError
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.model import AccountKind, ActionResult, Command, Direction, Op, Outcome, Primitive, StatusCard
from agentrob.screening.text import described_hazards, harm, scene, side_remarks
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene
from tests.waiting import until as wait_until

DRAWS = True

PIXEL = b"\x89PNG a picture"


async def thread(max_edits: int | None = None) -> tuple[MemoryForum, Command]:
    world = MemoryForum.world(max_edits=max_edits)
    post = (await world.sign_in("alice").create_topic("robots", "T", "@quadruped wave", key="1")).post
    robot = world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)
    return robot, Command(post.id, post.topic_id, "h", post.author, ROBOT, "wave", "en", datetime.now(UTC), "trace")


def shown(text: str, state: str) -> Shown:
    return Shown(text, StatusCard(ROBOT, state))


async def until(world: MemoryWorld, condition: Callable[[], Any]) -> None:
    """Wait until a condition on the forum holds."""
    async with asyncio.timeout(60):
        while not condition():
            await world.wait(0.05)


async def written(robot: MemoryForum, command: Command) -> list[tuple[str, int, str, int]]:
    posts = (await robot.posts(command.topic_id)).items[1:]
    return [(p.raw, p.version, p.card.state if p.card else "", len(p.images)) for p in posts]


async def test_a_status_is_one_post_and_its_end_is_reported_once() -> None:
    robot, command = await thread()
    for _ in range(2):  # the second time as after a crash
        status = StatusPost(robot, command)
        await status.claim(shown("seen", "seen"))
        await status.close(shown("report", "done"), [PIXEL], "short")
    assert await written(robot, command) == [("report", 2, "done", 1)]


@pytest.mark.parametrize("max_edits", [0, 1, 2, 3, 9])
async def test_where_edits_are_limited_at_most_three_are_used_and_the_report_is_a_reply(max_edits: int) -> None:
    robot, command = await thread(max_edits)
    status = StatusPost(robot, command)
    await status.claim(shown("seen", "seen"))
    for number in range(5):
        status.show(shown(f"step {number}", "running"))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
    await status.close(shown("report", "done"), [PIXEL], "short")
    (first, version, _, _), report = await written(robot, command)
    assert version - 1 <= min(3, max_edits)
    assert first == ("short" if max_edits else "seen")
    assert report == ("report", 1, "done", 1)


async def test_progress_never_waits_and_the_end_is_reported_when_the_forum_is_back() -> None:
    robot, command = await thread()
    status = StatusPost(robot, command)
    await status.claim(shown("seen", "seen"))
    robot._world.reachable = False
    status.show(shown("step", "running"))
    closing = asyncio.create_task(status.close(shown("report", "done")))
    await until(robot._world, lambda: robot._world.unanswered)
    assert not closing.done()
    robot._world.reachable = True
    await asyncio.wait_for(closing, 60)
    assert await written(robot, command) == [("report", 2, "done", 0)]


async def test_a_status_post_that_was_deleted_is_replaced_by_a_reply() -> None:
    robot, command = await thread()
    status = StatusPost(robot, command)
    claimed = await status.claim(shown("seen", "seen"))
    del robot._world.posts[claimed.post.id]
    await status.close(shown("report", "done"))
    assert [w[0] for w in await written(robot, command)] == ["report"]


@pytest.mark.parametrize("live", [True, False])
async def test_the_channel_brings_every_event_once_although_the_forum_comes_and_goes(live: bool) -> None:
    world = MemoryForum.world(live=live)
    alice, robot = world.sign_in("alice"), world.sign_in(ROBOT)
    channel = EventStream(robot, "0", poll_s=0.05)
    first = (await alice.create_topic("robots", "T", "0", key="0")).post
    seen: list[str] = []

    async def listen() -> None:
        async for event in channel.events():
            assert event.post is not None
            seen.append(event.post.raw)

    listening = asyncio.create_task(listen())
    for number in range(1, 6):
        world.reachable = True
        await alice.reply(first.topic_id, str(number), key=str(number))
        if number % 2:  # the others are read when the forum is back
            await until(world, lambda number=number: len(seen) > number)
        world.reachable, failed = False, world.unanswered
        await until(world, lambda failed=failed: world.unanswered > failed)
    world.reachable = True
    await until(world, lambda: len(seen) >= 6)
    assert await channel.prove()
    world.reachable = False
    listening.cancel()
    assert seen == ["0", "1", "2", "3", "4", "5"]


async def test_law_16_a_polled_channel_is_proven_before_motion_and_a_dead_one_is_not() -> None:
    world = MemoryForum.world(live=False)
    channel = EventStream(world.sign_in(ROBOT), "0", poll_s=1000)

    async def listen() -> None:
        async for _ in channel.events():
            pass

    listening = asyncio.create_task(listen())
    await asyncio.sleep(0.01)
    channel._heard_s -= 30
    assert await channel.prove()
    world.reachable = False
    channel._heard_s -= 30
    assert not await channel.prove()
    listening.cancel()


def walk(points: int = 60) -> ActionResult:
    path = tuple((i / 20, 3 + i / points * math.cos(1), i / points * math.sin(1), 1.0) for i in range(points + 1))
    return ActionResult(Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0), Outcome.DONE, path=path)


def test_a_path_is_drawn_and_no_path_is_not() -> None:
    png = path_plot([walk(), ActionResult(Primitive(Op.HELLO), Outcome.DONE)])
    assert png is not None
    image = Image.open(io.BytesIO(png))
    assert image.format == "PNG"
    assert image.size == (800, 600)
    assert len(image.convert("RGB").getcolors(100_000) or ()) > 20
    assert path_plot([ActionResult(Primitive(Op.HELLO), Outcome.DONE)]) is None
    assert path_plot([]) is None
    assert path_plot([walk(1)]) is not None


def test_a_path_is_seen_from_where_it_began() -> None:
    """The robot's position in the room does not change the picture."""
    moved = replace(walk(), path=tuple((t, x + 50, y - 20, yaw) for t, x, y, yaw in walk().path))
    assert path_plot([walk()]) == path_plot([moved])


class CameraServer:
    """A room camera over real HTTP."""

    async def __aenter__(self) -> CameraServer:
        self.asked = 0
        self.server = await asyncio.start_server(self._serve, "127.0.0.1", 0)
        self.url = f"http://127.0.0.1:{self.server.sockets[0].getsockname()[1]}/overview.jpg"
        return self

    async def __aexit__(self, *_: object) -> None:
        self.server.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        self.asked += 1
        picture = b"jpeg %d" % self.asked
        writer.write(b"HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Length: %d\r\n\r\n" % len(picture) + picture)
        await writer.drain()
        writer.close()


async def test_the_camera_looks_only_while_somebody_watches_or_it_moves() -> None:
    world = MemoryForum.world()
    async with CameraServer() as lens:
        camera = Camera(world.sign_in(ROBOT), ROBOT, lens.url, moving=lambda: False)
        looking = asyncio.create_task(camera.run())
        await asyncio.sleep(0.15)
        assert lens.asked == 0
        world.watch(ROBOT, 1)
        camera.wake()
        await wait_until(lambda: lens.asked >= 15)
        assert world.frames[ROBOT].startswith(b"jpeg")
        world.watch(ROBOT, 0)
        await asyncio.sleep(0.4)
        asked = lens.asked
        await asyncio.sleep(0.3)
        assert lens.asked == asked
        looking.cancel()


async def test_the_robot_page_is_kept_and_a_reset_puts_the_room_back(driver: Driver, tmp_path: Path) -> None:
    async with CameraServer() as room:
        owners = {"allow_flip": True, "approval": {"classes": ["risky"]}}
        scene = make_scene(driver, tmp_path, room_reset=room.url, **owners)
        async with scene.agent():
            card = await scene.until(lambda: scene.world.robots.get(ROBOT))
            assert (card["consents"], card["approval"]) == (["flip"], ["risky"])
            assert (card["model"], card["queue"], card["simulated"], card["can_reset"]) == ("fake", 0, True, True)
            assert "move" in card["ops"]
            assert card["camera"] is False, "no camera of the room is configured"
            await scene.world.sign_in("alice").press_reset(ROBOT)
            await scene.until(lambda: room.asked == 1)


async def test_once_handles_what_is_new_and_returns(scene: Scene) -> None:
    async def once() -> None:
        agent = scene.make()
        await asyncio.wait_for(agent.once(), 60)
        await agent.close()

    await once()
    posts = [await scene.post("alice", f"@quadruped turn {way} 90 degrees") for way in ("left", "right")]
    await once()
    assert [(await scene.final(p)).card.state for p in posts] == ["done", "done"]
    versions = [p.version for p in scene.world.posts.values()]
    await once()
    assert [p.version for p in scene.world.posts.values()] == versions


async def test_a_mind_that_fails_is_replaced_by_the_rules(scene: Scene) -> None:
    class UnavailableMind:
        name = "broken"

        async def understand(self, *_: Any) -> Any:
            raise MindError("no model answers")

    async with scene.agent(mind=UnavailableMind()):
        post = await scene.post("alice", "@quadruped turn left 90 degrees")
        assert (await scene.final(post)).card.state == "done"


async def test_an_agent_s_error_is_reported_and_the_next_command_is_done(scene: Scene) -> None:
    class FailingMind:
        name = "buggy"
        asked = 0

        async def understand(self, *arguments: Any) -> Any:
            self.asked += 1
            if self.asked == 1:
                raise ZeroDivisionError
            return await scene.mind.understand(*arguments)

    async with scene.agent(mind=FailingMind()):
        first = await scene.final(await scene.post("alice", "@quadruped wave"))
        second = await scene.final(await scene.post("alice", "@quadruped turn left 90 degrees"))
    assert [p.card.state for p in (first, second)] == ["failed", "done"]
    assert "My agent had an internal error" in first.raw


async def test_a_post_that_wants_nothing_gets_no_answer(scene: Scene) -> None:
    async with scene.agent():
        post = await scene.post("alice", "I like how @quadruped looks.")
        await scene.final(await scene.post("alice", "@quadruped help"))
    assert scene.replies(post) == []


async def test_an_unreachable_forum_is_waited_for_at_the_start(scene: Scene) -> None:
    scene.world.reachable = False
    agent = scene.make()
    running = asyncio.create_task(agent.run())
    await scene.until(lambda: scene.world.unanswered > 1)
    assert not agent.ready.is_set()
    with pytest.raises(ForumUnreachable):
        await agent.forum.me()
    scene.world.reachable = True
    await asyncio.wait_for(agent.ready.wait(), 60)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    await agent.close()


async def test_law_5_a_leap_of_the_machines_clock_makes_nothing_fresh_and_nothing_stale(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world = MemoryForum.world()
    ear = EventStream(world.sign_in(ROBOT), "0", poll_s=1)
    await ear.set_clock()

    class SetBackDatetime(datetime):
        @classmethod
        def now(cls, tz: Any = None) -> datetime:  # type: ignore[override]
            return datetime.now(tz) - timedelta(hours=1)

    monkeypatch.setattr(event_stream, "datetime", SetBackDatetime)
    assert abs((ear.now() - datetime.now(UTC)).total_seconds()) < 5
    slept_s = event_stream.elapsed_s() + 3600
    monkeypatch.setattr(event_stream, "elapsed_s", lambda: slept_s)
    assert (ear.now() - datetime.now(UTC)).total_seconds() == pytest.approx(3600, abs=5)


async def test_all_words_of_harm_are_compiled_before_an_agent_serves(driver: Driver, tmp_path: Path) -> None:
    """Compiling takes half a second, which would delay a stop."""
    agent = make_scene(driver, tmp_path).make()
    try:
        for rule in harm.RULES:
            for prefix in harm.PREFIXES:
                assert all(phrases.prepared for _, phrases, _ in harm.phrases_of(rule, prefix))
        assert all(phrases.prepared for said in described_hazards._patterns().values() for phrases in said._phrases)
        assert all(phrases.prepared for phrases in side_remarks._phrases().every)
        assert scene._patterns.cache_info().currsize == 1
    finally:
        await agent.close()
