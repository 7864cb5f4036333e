"""Run every story in this folder on the memory forum, with a fake robot behind a real driver process.

A story is a Markdown file: front matter, then one step per heading. Text above the first heading and between the steps
is for readers. The front matter names the accounts; it may set `max_edits` and `live` of the forum, settings of the
robot's agent (`[robot]`, as in agentrob.toml), further robots with agents of their own (`agents`), options of a fake
robot of its own (`[fake]`), which begins at home, and `real = true` for a robot that does not report itself as
simulated.
The steps:

    ## NAME posts KEY                       post the text below as a new topic
    ## NAME posts KEY, 10 minutes ago       the same, with an earlier time
    ## NAME replies to KEY: KEY             post the text below in that thread
    ## NAME edits KEY                       replace the post's text by the one below
    ## NAME presses stop                    on the robot's page
    ## NAME removes KEY
    ## NAME is suspended                    from now on
    ## NAME presses emergency stop          on the robot's page; also: release
    ## the owner releases the robot         from a halt, at its machine
    ## the robot is released                wait for it; also: stays locked, once all presses are processed
    ## ROBOT answers KEY, part N: STATE     the final reply for one part of a post to several robots
    ## ROBOT sums up KEY                    the reply that sums up such a post; its lines as above
    ## KEY shows STATE                      wait for this state of the command; its post contains the list below
    ## ROBOT answers KEY: STATE             the final reply; it contains each line of the list below, except lines
                                            with "without: …", which it must not contain
    ## KEY is due                           the time of the schedule's next run comes
    ## ROBOT runs KEY: STATE                the final reply of that run; its lines as above
    ## ROBOT replies to KEY                 a reply that is not a command's status, for example to a stop
    ## ROBOT replied to KEY N times
    ## ROBOT says nothing to KEY
    ## the robot walks                      wait until it moves
    ## the robot walked 1.0 m               since the story began, measured by its driver, within 10 % or 5 cm
    ## the robot stands where it stood
    ## NAME walks in the room               another robot, which its driver reports now and then, takes the shared room
    ## NAME is silent in the room           the same, but its driver is not heard any more
    ## NAME rests                           that robot is at rest
"""

from __future__ import annotations

import asyncio
import math
import os
import re
import time
import tomllib
from collections import Counter
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import AsyncExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.forums.memory.forum import MemoryForum
from agentrob.model import AccountKind, Capabilities, Post, Role
from agentrob.robots.control.step_runner import TOLERANCE_M, TOLERANCE_SHARE
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.safety.crash_marker import boot_id
from agentrob.robots.zones.keeper import LocalKeeper
from agentrob.robots.zones.ledger import Message, Place
from tests.agent.agent_scene import FINAL, ROBOT, Driver, Scene, make_scene, robot_settings, serving
from tests.agent.store.journal_store import open_journal
from tests.waiting import until

FOLDER = Path(__file__).parent
STORIES = sorted(FOLDER.glob("*.md"))


@dataclass(frozen=True)
class Story:
    """A parsed story: its front matter, and (heading, text below) in order."""

    title: str
    accounts: dict[str, str]
    forum: dict[str, Any]
    robot: dict[str, Any]
    real: bool
    fake: dict[str, Any] | None
    agents: tuple[str, ...]
    steps: tuple[tuple[str, str], ...]


def read(path: Path) -> Story:
    _, front, body = path.read_text(encoding="utf-8").split("+++\n", 2)
    facts = tomllib.loads(front)
    parts = re.split(r"^## (.+)\n", body, flags=re.MULTILINE)
    steps = tuple((h.strip(), t.strip("\n")) for h, t in zip(parts[1::2], parts[2::2], strict=True))
    forum: dict[str, Any] = {key: facts[key] for key in ("max_edits", "live") if key in facts}
    return Story(
        facts["title"], facts["accounts"], forum, facts.get("robot", {}), facts.get("real", False), facts.get("fake"),
        tuple(facts.get("agents", ())), steps,
    )  # fmt: skip


class RealClient(DriverClient):
    """A client of a fake robot's driver that reports a real robot."""

    async def capabilities(self) -> Capabilities:
        return replace(await super().capabilities(), simulated=False)


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings())
    yield made
    made.end()


@contextmanager
def driver_of(story: Story, shared: Driver, folder: Path) -> Iterator[Driver]:
    """The driver that stories share, or one of the story's own."""
    if story.fake is None:
        yield shared
        return
    folder.mkdir()
    another = int(os.environ["AGENTROB_TEST_DOMAIN"]) ^ 1  # the shared driver holds this process's; locks are its own
    room = story.robot.get("room", "")
    own = Driver(folder, robot_settings(options=story.fake, domain=another, room=room))
    try:
        yield own
    finally:
        own.end()


class OtherRobot:
    """Another robot of the room, as its driver tells of it in the file that the drivers share."""

    def __init__(self, name: str, rooms: Path, *, silent_s: float = 0.0) -> None:
        self.name = name
        self.keeper = LocalKeeper(rooms / "lab.sqlite", boot_id, lambda: time.monotonic() - silent_s)
        self.session, self.number, self.lease = self.keeper.hello(name), 0, 0
        self.report(at_rest=True)
        self.lease = self.keeper.take(self._next(), Place(), None, "move").number
        assert self.lease
        self.task = None if silent_s else asyncio.create_task(self._walk())

    def _next(self) -> Message:
        self.number += 1
        return Message(self.name, self.session, self.number)

    def report(self, *, at_rest: bool) -> None:
        self.keeper.report(self._next(), self.lease, Place(), at_rest=at_rest)

    async def _walk(self) -> None:
        while True:
            await asyncio.sleep(0.5)
            self.report(at_rest=False)

    def rest(self) -> None:
        if self.task is not None:
            self.task.cancel()
        self.report(at_rest=True)
        self.keeper.close()


@pytest.fixture(scope="module")
def partners(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str], Driver]]:
    """The drivers of further robots, each begun for the first story that needs it."""
    made: dict[str, Driver] = {}

    def driver_named(name: str) -> Driver:
        if name not in made:
            another = int(os.environ["AGENTROB_TEST_DOMAIN"]) ^ (2 + len(made))
            made[name] = Driver(tmp_path_factory.mktemp(name), robot_settings(domain=another), name)
        return made[name]

    yield driver_named
    for driver in made.values():
        driver.end()


@dataclass
class StoryRun:
    """A story in progress."""

    scene: Scene
    agent: RobotAgent
    posts: dict[str, Post] = field(default_factory=dict)
    start: tuple[float, float] = (0.0, 0.0)
    runs: Counter[str] = field(default_factory=Counter)
    others: dict[str, OtherRobot] = field(default_factory=dict)

    async def posts_(self, name: str, key: str, minutes: str | None, text: str) -> None:
        self.scene.world.clock_offset_s = -60.0 * float(minutes or 0)
        self.posts[key] = await self.scene.post(name, text)
        self.scene.world.clock_offset_s = 0.0

    async def replies(self, name: str, to: str, key: str, text: str) -> None:
        self.posts[key] = await self.scene.post(name, text, topic=self.posts[to].topic_id)

    async def edits(self, name: str, key: str, text: str) -> None:
        await self.scene.world.sign_in(name).edit(self.posts[key].id, text)

    async def presses(self, name: str, _: str) -> None:
        await self.scene.world.sign_in(name).press_stop(ROBOT)

    async def presses_emergency_stop(self, name: str, _: str) -> None:
        await self.scene.world.sign_in(name).press_estop(ROBOT)

    async def presses_release(self, name: str, _: str) -> None:
        await self.scene.world.sign_in(name).press_release(ROBOT)

    async def free(self, _: str) -> None:
        await until(self.agent.driver.state, lambda state: not state.halted)

    async def stays_locked(self, _: str) -> None:
        """Events are processed in order: once a later post is answered, the button presses before it are processed."""
        self.scene.person("barrier", Role.MEMBER)
        await self.scene.final(await self.scene.post("barrier", f"@{ROBOT} help"))
        await self.agent.stops.wait_for_stops()
        assert (await self.agent.driver.state()).halted

    async def removes(self, name: str, key: str, _: str) -> None:
        assert self.posts[key].author.name == name
        self.scene.world.remove(self.posts[key].id)

    async def suspended(self, name: str, _: str) -> None:
        self.scene.world.suspend(name)

    async def released(self, _: str = "") -> None:
        await self.agent.driver.release("the owner")

    async def shows(self, key: str, state: str, text: str) -> None:
        _contains(await self.scene.state(self.posts[key], state), text)

    async def answers_part(self, robot: str, key: str, number: str, state: str, text: str) -> None:
        post = self.posts[key]

        def final() -> Post | None:
            own = [p for p in self.scene.world.posts.values() if p.reply_to == post.id and p.author.name == robot]
            return next((p for p in own if p.card and p.card.part == int(number) and p.card.state in FINAL), None)

        reply = await self.scene.until(final)
        assert reply.card.state == state, reply.raw
        _contains(reply, text)

    async def sums_up(self, robot: str, key: str, text: str) -> None:
        posts, name = self.scene.world.posts, f"joint:{self.posts[key].id}"
        found = await self.scene.until(lambda: [p for p in posts.values() if (p.author.name, p.key) == (robot, name)])
        _contains(found[0], text)
        await self._settled(key)

    async def answers(self, _: str, key: str, state: str, text: str) -> None:
        reply = await self.scene.final(self.posts[key])
        assert reply.card is not None
        assert reply.card.state == state, reply.raw
        _contains(reply, text)
        await self._settled(key)

    async def due(self, key: str, _: str) -> None:
        kept = await self.agent.journal.schedule(self.posts[key].id)
        assert kept is not None
        at = kept.next_at
        assert at is not None
        self.runs[key] += 1
        await replace(self.agent.schedules, now=lambda: at).step()

    async def ran(self, _: str, key: str, state: str, text: str) -> None:
        post, number = self.posts[key], self.runs[key]
        reply = (await self.scene.until(lambda: len(found := self._finals(post)) > number and found))[number]
        assert reply.card is not None
        assert reply.card.state == state, reply.raw
        _contains(reply, text)
        await self._settled(key)

    def _finals(self, post: Post) -> list[Post]:
        found = [reply for reply in self.scene.replies(post) if reply.card is not None and reply.card.state in FINAL]
        return sorted(found, key=lambda reply: int(reply.id))

    async def _settled(self, key: str) -> None:
        """Wait for the journal: the reply comes a moment before its row, and "again" reads the row."""
        async with asyncio.timeout(60):
            while self.posts[key].id in {c.command.post_id for c in await self.agent.journal.open_claims()}:
                await self.scene.world.wait(0.01)

    async def robot_replies(self, _: str, key: str, text: str) -> None:
        _contains(await self.scene.until(lambda: next(iter(self.scene.replies(self.posts[key])), None)), text)

    async def replied(self, _: str, key: str, times: str, __: str) -> None:
        await self.scene.until(lambda: len(self.scene.replies(self.posts[key])) == int(times))

    async def nothing(self, _: str, key: str, __: str) -> None:
        """Posts are processed in order: once a later one is answered, this one will not be."""
        self.scene.person("barrier", Role.MEMBER)
        await self.scene.final(await self.scene.post("barrier", f"@{ROBOT} help"))
        assert self.scene.replies(self.posts[key]) == []

    async def walked(self, metres: str, _: str) -> None:
        x_m, y_m = await self.place()
        allowed_m = TOLERANCE_M + TOLERANCE_SHARE * float(metres)  # of one move, if that is more than 10 %
        assert math.hypot(x_m - self.start[0], y_m - self.start[1]) == pytest.approx(
            float(metres), rel=0.1, abs=allowed_m
        )

    async def walks(self, _: str) -> None:
        await until(self.agent.driver.state, lambda state: math.hypot(*(state.velocity_mps or (0, 0))) >= 0.1)

    async def other_walks(self, name: str, _: str) -> None:
        self.others[name] = OtherRobot(name, self.scene.driver.socket.parent / "rooms")

    async def other_is_silent(self, name: str, _: str) -> None:
        self.others[name] = OtherRobot(name, self.scene.driver.socket.parent / "rooms", silent_s=60.0)

    async def other_rests(self, name: str, _: str) -> None:
        self.others.pop(name).rest()

    async def stood(self, _: str) -> None:
        assert await self.place() == pytest.approx(self.start, abs=0.001)

    async def place(self) -> tuple[float, float]:
        """Return the robot's position, from its driver."""
        pose = (await self.agent.driver.state()).pose
        assert pose is not None
        return pose.x_m, pose.y_m


def _contains(reply: Post, text: str) -> None:
    for line in text.splitlines():
        if not line.startswith("- "):
            continue
        wanted = line.removeprefix("- ").strip()
        if wanted.startswith("without: "):
            assert wanted.removeprefix("without: ") not in reply.raw
        else:
            assert wanted in reply.raw


_STEPS: tuple[tuple[str, Callable[..., Awaitable[None]]], ...] = (
    (r"(\w+) posts (\w+)(?:, (\d+) minutes ago)?", StoryRun.posts_),
    (rf"({ROBOT}) replies to (\w+)", StoryRun.robot_replies),
    (r"(\w+) is due", StoryRun.due),
    (rf"({ROBOT}) runs (\w+): (\w+)", StoryRun.ran),
    (r"(\w+) replies to (\w+): (\w+)", StoryRun.replies),
    (r"(\w+) edits (\w+)", StoryRun.edits),
    (r"(\w+) presses stop", StoryRun.presses),
    (r"(\w+) presses emergency stop", StoryRun.presses_emergency_stop),
    (r"(\w+) presses release", StoryRun.presses_release),
    (r"the robot is released", StoryRun.free),
    (r"the robot stays locked", StoryRun.stays_locked),
    (r"(\w+) removes (\w+)", StoryRun.removes),
    (r"(\w+) is suspended", StoryRun.suspended),
    (r"the owner releases the robot", StoryRun.released),
    (r"(\w+) shows (\w+)", StoryRun.shows),
    (r"(\w+) answers (\w+), part (\d): (\w+)", StoryRun.answers_part),
    (r"(\w+) sums up (\w+)", StoryRun.sums_up),
    (r"(\w+) answers (\w+): (\w+)", StoryRun.answers),
    (r"(\w+) replied to (\w+) (\d+) times", StoryRun.replied),
    (r"(\w+) says nothing to (\w+)", StoryRun.nothing),
    (r"the robot walks", StoryRun.walks),
    (r"(\w+) walks in the room", StoryRun.other_walks),
    (r"(\w+) is silent in the room", StoryRun.other_is_silent),
    (r"(\w+) rests", StoryRun.other_rests),
    (r"the robot walked ([\d.]+) m", StoryRun.walked),
    (r"the robot stands where it stood", StoryRun.stood),
)


async def run_section(story_run: StoryRun, heading: str, text: str) -> None:
    for pattern, step in _STEPS:
        if match := re.fullmatch(pattern, heading):
            await step(story_run, *match.groups(), text)
            return
    pytest.fail(f"no step of a story: {heading!r}")


@pytest.mark.parametrize("path", STORIES, ids=[p.stem for p in STORIES])
async def test_story(path: Path, driver: Driver, partners: Callable[[str], Driver], tmp_path: Path) -> None:
    story = read(path)
    with driver_of(story, driver, tmp_path / "driver") as its_driver:
        await told(story, its_driver, tmp_path, {name: partners(name) for name in story.agents})


async def told(story: Story, driver: Driver, tmp_path: Path, partners: Mapping[str, Driver]) -> None:
    scene = make_scene(driver, tmp_path, MemoryForum.world(**story.forum), poll_s=0.5, **story.robot)
    for name, what in story.accounts.items():
        kind = AccountKind(what) if what in frozenset(AccountKind) else AccountKind.HUMAN
        role = Role(what) if what in frozenset(Role) else Role.MEMBER
        scene.person(name, role, kind)
        scene.world.set_role(name, role)  # some exist already
    changed = {"driver": RealClient(driver.name, driver.socket)} if story.real else {}
    async with AsyncExitStack() as stack:
        agent = await stack.enter_async_context(scene.agent(**changed))
        for name, partner in partners.items():
            forum = scene.world.sign_in(name, kind=AccountKind.ROBOT_AGENT)
            further = scene.make(
                name=name, forum=forum, driver=partner.client(), open_journal=partial(open_journal, tmp_path, name)
            )
            await stack.enter_async_context(serving(further))
        story_run = StoryRun(scene, agent)
        story_run.start = await story_run.place()
        try:
            for heading, text in story.steps:
                await run_section(story_run, heading, text)
        finally:
            await story_run.released()  # the driver is shared by all stories


def test_there_are_stories() -> None:
    assert len(STORIES) >= 60
