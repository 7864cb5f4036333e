"""A memory forum, a fake robot behind a real driver process, and an agent between them."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from agentrob.agent.agent import RobotAgent
from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError
from agentrob.eyes.colours import ColourDetector
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.forums.protocol import Forum
from agentrob.minds.protocol import Mind
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, CommandState, Post, Role
from agentrob.model.lifecycle import TRANSITIONS
from agentrob.robots.driver import driver as driver_module
from agentrob.robots.driver import fencing
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.lease import Leases
from agentrob.robots.driver.process import run_driver
from tests.agent.store.journal_store import JournalStore, open_journal
from tests.forked_process import ForkedProcess

ROBOT = "quadruped"
WIDE = {"x_min_m": -1000.0, "x_max_m": 1000.0, "y_min_m": -1000.0, "y_max_m": 1000.0}
FINAL = {"done", "failed", "refused", "asks_back", "stopped", "interrupted", "cancelled", "expired", "answered"}


def reachable(state: CommandState) -> set[CommandState]:
    """Return every state that can follow this one, directly or indirectly."""
    found: set[CommandState] = set()
    ahead = [state]
    while ahead:
        new = TRANSITIONS[ahead.pop()] - found
        found |= new
        ahead += new
    return found


@contextmanager
def checked_cards(world: MemoryWorld) -> Iterator[None]:
    """Check that the states of each status post follow the table of transitions.

    An edit may skip states, and a guessed end may be replaced by a measured one.
    """
    shown = {post.id: post.card for post in world.posts.values() if post.card is not None}
    begun = len(world.events)
    yield
    for event in world.events[begun:]:
        if (post := event.post) is None or post.card is None or not (post.key or "").startswith("claim:"):
            continue
        before, shown[post.id] = shown.get(post.id), post.card
        if before is None or before.state == post.card.state:
            continue
        guess = before.state == CommandState.INTERRUPTED and before.steps == 0
        allowed = FINAL if guess else reachable(CommandState(before.state))
        assert post.card.state in allowed, f"post {post.id} went from {before.state} to {post.card.state}"


def robot_settings(**more: Any) -> RobotConfig:
    """Return the settings of a fake robot in a large room, at ten times real time."""
    options = {"time_scale": 10, "room": [-1000, 1000, -1000, 1000], **more.pop("options", {})}
    common = {
        "model": "fake",
        # Other test processes on this host may control a robot of the same name.
        "domain": int(os.environ["AGENTROB_TEST_DOMAIN"]),
        "simulated": True,
        "home_on_start": True,
        "fence": WIDE,
        "rates": {"commands_per_hour": 0, "cooldown_s": 0, "waiting": 0},
        "options": options,
    }
    return RobotConfig.model_validate({**common, **more})


#: An agent that shares its process with a test, on a machine that runs several, may renew its lease late.
PATIENT_LEASE_S = 5.0


def run_test_driver(lease_s: float, name: str, settings: RobotConfig, socket: Path, folder: Path) -> None:
    """Run a driver whose leases last `lease_s`, and that remembers more databases than an owner has, because each test
    has its own; the main function of its process."""
    driver_module.Leases = partial(Leases, lease_s)  # type: ignore[misc,assignment]
    fencing.STORES = 1000
    run_driver(name, settings, socket, folder)


class Driver:
    """A driver in its own process. Tests in which an agent dies or its lease lapses set `lease_s` to the `TTL_S` of
    real drivers. `run` is the main function of another driver."""

    def __init__(
        self,
        folder: Path,
        settings: RobotConfig,
        name: str = ROBOT,
        run: Callable[..., None] | None = None,
        lease_s: float = PATIENT_LEASE_S,
    ) -> None:
        self.name = name
        self.socket = folder / f"{name}.sock"
        self.settings = settings
        self.process = ForkedProcess(
            run or partial(run_test_driver, lease_s), name, settings, self.socket, folder, keep_stderr=False
        )
        assert json.loads(self.process.stdout.readline())["ready"]

    def client(self) -> DriverClient:
        return DriverClient(self.name, self.socket)

    def end(self) -> None:
        self.process.terminate()
        self.process.wait(60)
        self.process.close()


@asynccontextmanager
async def held_by(holder: str, driver: Driver) -> AsyncIterator[None]:
    """Hold a robot's lease from another process, as a console does, so that this one cannot fail to renew it."""
    console = ForkedProcess(_hold, driver.name, driver.socket, holder)
    try:
        assert await asyncio.to_thread(console.stdout.readline) == "held\n"
        yield
    finally:
        console.send_signal(signal.SIGINT)
        await asyncio.to_thread(console.wait, 60)
        console.close()


def _hold(robot: str, socket: Path, holder: str) -> None:
    async def hold() -> None:
        async with DriverClient(robot, socket) as client, client.lease(holder):
            sys.stdout.write("held\n")
            sys.stdout.flush()
            await asyncio.Event().wait()

    with suppress(KeyboardInterrupt):
        asyncio.run(hold())


@asynccontextmanager
async def serving(agent: RobotAgent) -> AsyncIterator[None]:
    """Run the agent until the block ends."""
    running = asyncio.create_task(agent.run())
    ready = asyncio.create_task(agent.ready.wait())
    await asyncio.wait({running, ready}, return_when=asyncio.FIRST_COMPLETED)
    ready.cancel()
    try:
        if running.done():
            running.result()
        yield
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await agent.close()


@dataclass
class Scene:
    """A forum with the operator `alice`, the member `bob` and one robot's agent."""

    world: MemoryWorld
    driver: Driver
    folder: Path
    settings: RobotConfig
    mind: Mind = field(default_factory=RulesMind)
    #: How long to wait for what a test expects.
    limit_s: float = 60.0
    _keys: Iterator[int] = field(default_factory=lambda: iter(range(10**6)))

    @property
    def journal(self) -> JournalStore:
        """The agent's journal, from outside."""
        return JournalStore(self.folder, ROBOT)

    def person(self, name: str, role: Role = Role.OPERATOR, kind: AccountKind = AccountKind.HUMAN) -> MemoryForum:
        return self.world.sign_in(name, role=role, kind=kind)

    async def post(self, name: str, text: str, topic: str | None = None, reply_to: str | None = None) -> Post:
        forum = self.world.sign_in(name)
        if topic is None:
            return (await forum.create_topic("robots", "A topic", text, key=f"k{next(self._keys)}")).post
        return (await forum.reply(topic, text, key=f"k{next(self._keys)}", reply_to=reply_to)).post

    def replies(self, post: Post) -> list[Post]:
        """Return the robot's replies to a post."""
        return [p for p in self.world.posts.values() if p.reply_to == post.id and p.author.name == ROBOT]

    async def until(self, condition: Callable[[], Any], limit_s: float | None = None) -> Any:
        """Wait until a condition on the forum holds, and return its value."""
        async with asyncio.timeout(self.limit_s if limit_s is None else limit_s):
            while not (found := condition()):
                await self.world.wait(0.05)
        return found

    async def final(self, post: Post, limit_s: float | None = None) -> Post:
        """Wait for the robot's final reply to a post."""
        return await self.until(
            lambda: next((p for p in self.replies(post) if p.card and p.card.state in FINAL), None), limit_s
        )

    async def state(self, post: Post, state: str) -> Post:
        """Wait until the robot's reply to a post shows a state."""
        return await self.until(lambda: next((p for p in self.replies(post) if p.card and p.card.state == state), None))

    @asynccontextmanager
    async def agent(self, **changed: Any) -> AsyncIterator[RobotAgent]:
        """Run an agent until the block ends. `changed` replaces constructor arguments."""
        agent = self.make(**changed)
        with checked_cards(self.world):
            async with serving(agent):
                yield agent

    def make(self, **changed: Any) -> RobotAgent:
        forum: Forum = self.world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)
        arguments: dict[str, Any] = {
            "name": ROBOT, "settings": self.settings, "forum": forum, "driver": self.driver.client(),
            "mind": self.mind, "data": self.folder, "detector": ColourDetector({}),
            "open_journal": partial(open_journal, self.folder, ROBOT),
            **changed,
        }  # fmt: skip
        return RobotAgent(**arguments)


async def set_home(driver: Driver, by: str) -> None:
    """Set the robot's home where it is, as soon as it has stood still for a moment."""
    async with driver.client() as client, asyncio.timeout(60):
        while True:
            with suppress(RobotError):
                return await client.home(by)
            await asyncio.sleep(0.05)


def make_scene(driver: Driver, folder: Path, world: MemoryWorld | None = None, **settings: Any) -> Scene:
    scene = Scene(world or MemoryForum.world(), driver, folder, robot_settings(**settings))
    scene.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)
    scene.person("alice")
    scene.person("bob", Role.MEMBER)
    return scene
