"""Laws 13 and 14 as a table: each way to stop, in each state of a command, and the command's final reply."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.model import AccountKind, Post, Primitive, Role
from agentrob.process.host_lock import HostLock
from agentrob.robots.driver.api import DriverServer
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.driver import Driver
from agentrob.robots.driver.lease import Leases
from agentrob.robots.driver.process import listening, lock_name, serve_stops
from agentrob.robots.driver.stop import halt_robot, stop_robot
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from tests.agent.agent_scene import FINAL, ROBOT, robot_settings
from tests.agent.laws.machine_scene import GatedClient, GatedMind, Gates, RecordingRobot, Stand
from tests.waiting import until

LIMIT_S = 60.0
#: Stops on the forum, and stops at the robot's machine without the forum.
ON_THE_FORUM = ("mention", "bare", "edit", "button", "halt")
AT_THE_MACHINE = ("driver", "second channel", "second channel halts")
#: State of the command: its end after a stop on the forum, and after one at the machine, which the agent notices by
#: the lease that it is refused or has lost.
TABLE = {
    "being read": ("cancelled", "stopped"),
    "queued": ("cancelled", "stopped"),
    "about to hold the robot": ("stopped", "stopped"),
    "about to move": ("stopped", "stopped"),
    "moving": ("stopped", "stopped"),
    "between steps": ("stopped", "stopped"),
    "waiting for the camera": ("stopped", "stopped"),
}
CASES = [(way, state) for way in ON_THE_FORUM + AT_THE_MACHINE for state in TABLE]


@pytest.fixture(scope="module")
def stand(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stand]:
    """A robot that takes two seconds for 5 m, with both channels of its driver."""
    folder, settings, robot = tmp_path_factory.mktemp("stand"), robot_settings(), RecordingRobot()
    robot.time_scale = 5.0
    driver = Driver(ROBOT, Guard(robot, settings, Halt(folder / "robot.halt")))
    driver.leases = Leases(LIMIT_S)  # a busy machine may delay a renewal, which is another law's subject
    with (
        listening(folder / "robot.sock") as listener,
        DriverServer(driver, listener),
        HostLock(lock_name(ROBOT, settings), "the robot") as lock,
    ):
        threading.Thread(target=serve_stops, args=(lock.socket, driver), daemon=True).start()
        yield Stand(folder, robot, driver)
        driver.close()


@dataclass
class Scenario:
    """A forum, the agent, and the robot's real motion."""

    stand: Stand
    folder: Path
    world: MemoryWorld = field(default_factory=MemoryForum.world)
    gates: Gates = field(default_factory=Gates)
    moved: list[Primitive] = field(default_factory=list)
    talk: Post | None = None
    _count: int = 0

    async def until(self, true: Callable[[], Any]) -> Any:
        return await until(true, limit_s=LIMIT_S)

    async def post(self, name: str, text: str, topic: str | None = None) -> Post:
        forum, key = self.world.sign_in(name), f"k{(count := self._count)}"
        self._count = count + 1
        if topic is None:
            return (await forum.create_topic("robots", "A topic", text, key=key)).post
        return (await forum.reply(topic, text, key=key)).post

    async def shows(self, post: Post, states: set[str]) -> str:
        def state() -> str:
            cards = [p.card for p in self.world.posts.values() if p.reply_to == post.id and p.card]
            return next((card.state for card in cards if card.state in states), "")

        return str(await self.until(state))

    @contextlib.asynccontextmanager
    async def agent(self) -> AsyncIterator[None]:
        for name, kind, role in (
            (ROBOT, AccountKind.ROBOT_AGENT, Role.MEMBER),
            ("alice", AccountKind.HUMAN, Role.OPERATOR),
            ("bob", AccountKind.HUMAN, Role.MEMBER),
        ):
            self.world.sign_in(name, kind=kind, role=role)
        self.stand.robot.gate, self.stand.robot.on_motion = self.gates.body, self.moved.append
        client = GatedClient(self.stand.socket, self.gates, lambda _: None)
        forum, mind = self.world.sign_in(ROBOT), GatedMind(self.gates)
        agent = RobotAgent(ROBOT, robot_settings(), forum, client, mind, self.folder)
        serving = asyncio.create_task(agent.run())
        try:
            await self.until(agent.ready.is_set)
            self.talk = await self.post("bob", "Nice weather")
            yield
        finally:
            self.gates.open()
            serving.cancel()
            await asyncio.gather(serving, return_exceptions=True)
            await agent.close()

    # ------------------------------------------------------------------ how far a command comes
    async def let(self, *gates: str) -> None:
        """Release each of these gates as soon as somebody waits at it."""
        for name in gates:
            gate = getattr(self.gates, name)
            await self.until(lambda gate=gate: gate.held)
            gate.let()

    async def bring(self, state: str) -> Post:
        """Bring a command into this state."""
        turn, two = f"@{ROBOT} turn left 80 degrees", f"@{ROBOT} turn left 20 degrees, then turn right 70 degrees"
        match state:
            case "being read":
                post, last = await self.post("alice", turn), "mind"
            case "queued":
                await self.post("alice", turn)
                await self.let("mind", "lease", "step")
                await self.until(lambda: self.gates.body.held)
                post = await self.post("alice", turn)
                await self.let("mind")
                await self.shows(post, {"queued"})
                return post
            case "about to hold the robot":
                post, last = await self.post("alice", turn), "lease"
                await self.let("mind")
            case "about to move":
                post, last = await self.post("alice", turn), "step"
                await self.let("mind", "lease")
            case "moving":
                post = await self.post("alice", f"@{ROBOT} walk forward 5 metres")
                await self.let("mind", "lease", "step", "body")
                await self.until(lambda: self.moved)
                return post
            case "between steps":
                post, last = await self.post("alice", two), "step"
                await self.let("mind", "lease", "step", "body")
            case _:
                post, last = await self.post("alice", f"@{ROBOT} take a photo and walk forward 1 metre"), "body"
                await self.let("mind", "lease", "step")
        await self.until(lambda: getattr(self.gates, last).held)
        return post

    # ------------------------------------------------------------------ how it is stopped
    async def stop(self, way: str, command: Post) -> None:
        """Return once the stop has reached the robot."""
        stops, settings = self.stand.robot.stopped, robot_settings()
        match way:
            case "mention":
                await self.post("bob", f"@{ROBOT} stop now, please!")
            case "bare":
                await self.post("bob", "快停下！", topic=command.topic_id)
            case "edit":
                assert self.talk is not None
                await self.world.sign_in("bob").edit(self.talk.id, f"@{ROBOT} stop")
            case "button":
                await self.world.sign_in("bob").press_stop(ROBOT)
            case "halt":
                await self.post("bob", f"@{ROBOT} emergency stop!")
            case "driver":
                async with DriverClient(ROBOT, self.stand.socket) as client:
                    await client.stop("somebody at the machine")
            case "second channel":
                await asyncio.to_thread(stop_robot, ROBOT, settings, "somebody at the machine")
            case "second channel halts":
                await asyncio.to_thread(halt_robot, ROBOT, settings, "somebody at the machine")
        await self.until(lambda: self.stand.robot.stopped > stops)


@pytest.mark.parametrize(("way", "state"), CASES)
async def test_laws_13_and_14_a_stop_ends_a_command_in_any_state(
    stand: Stand, tmp_path: Path, way: str, state: str
) -> None:
    scenario = Scenario(stand, tmp_path)
    async with scenario.agent():
        command = await scenario.bring(state)
        await scenario.stop(way, command)
        moved = len(scenario.moved)
        scenario.gates.open()
        ended = await scenario.shows(command, FINAL)
        later = await scenario.shows(await scenario.post("alice", f"@{ROBOT} wave"), FINAL)
        halts = way in ("halt", "second channel halts")
        if halts:
            stand.driver.release("owner")
        assert ended == TABLE[state][way in AT_THE_MACHINE]
        assert later == ("refused" if halts else "done")
        assert scenario.moved[moved:] == []


#: Each of these was once ignored when posted in the thread of a walk.
PLAIN_WORDS = {
    "stop right there": "I took this as a stop",
    "omg stop it's going to fall": "I took this as a stop",
    "wait": "I took this as a stop",
    "stop what you are doing": "I took this as a stop",
    "brake!": "I took this as a stop",
    "刹车": "当作停止命令",
    "要撞了快停": "当作停止命令",
}


@pytest.mark.parametrize("text", PLAIN_WORDS)
async def test_law_13_plain_words_in_the_thread_stop_what_moves(stand: Stand, tmp_path: Path, text: str) -> None:
    scenario = Scenario(stand, tmp_path)
    async with scenario.agent():
        command = await scenario.bring("moving")
        stop = await scenario.post("bob", text, topic=command.topic_id)
        assert await scenario.shows(command, FINAL) == "stopped"
        reply = await scenario.until(
            lambda: next((p for p in scenario.world.posts.values() if p.reply_to == stop.id), None)
        )
        assert PLAIN_WORDS[text] in reply.raw
        assert "ms after the stop" in reply.raw or "毫秒后速度归零" in reply.raw
        scenario.gates.open()
        later = await scenario.post("alice", f"@{ROBOT} wave")
        assert await scenario.shows(later, FINAL) == "done"


async def test_law_13_an_edit_into_plain_words_stops_what_moves(stand: Stand, tmp_path: Path) -> None:
    scenario = Scenario(stand, tmp_path)
    async with scenario.agent():
        command = await scenario.bring("moving")
        talk = await scenario.post("bob", "nice!", topic=command.topic_id)
        await scenario.world.sign_in("bob").edit(talk.id, "nice! oh no, careful, the cat")
        assert await scenario.shows(command, FINAL) == "stopped"
