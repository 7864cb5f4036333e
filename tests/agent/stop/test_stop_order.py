"""Law 14 under any clock of the forum.

It is set ahead and back, by seconds and by years, while posts and stops arrive, arrive late, and the agent or its
machine is restarted. Time is a number here, and nothing moves.
"""

from __future__ import annotations

import asyncio
import tempfile
import time
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from agentrob.agent.agent import RobotAgent
from agentrob.agent.queue.queue import QueuedCommand
from agentrob.agent.stop import stop_handler
from agentrob.agent.store import rows
from agentrob.forums.memory.forum import MemoryWorld
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, CommandState, EndReason, Role, StopResult
from tests.agent.agent_scene import ROBOT, robot_settings

BEGUN = datetime(2026, 11, 1, tzinfo=UTC)
DAY_S = 86_400.0
Action = tuple[str, float]


@dataclass
class Clock:
    """Seconds since `BEGUN`, and since the `machine`-th start of the machine."""

    true_s: float = 1000.0
    started_s: float = 0.0
    machine: int = 0

    def elapsed_s(self, _: int = 0) -> float:
        return self.true_s - self.started_s


@dataclass
class World(MemoryWorld):
    clock: Clock = field(default_factory=Clock)

    def now(self) -> datetime:
        return BEGUN + timedelta(seconds=self.clock.true_s + self.clock_offset_s)


class Robot:
    """A driver that can only be told to stop."""

    robot = ROBOT

    async def stop(self, by: str, running_only: bool = False) -> StopResult:
        return StopResult(latency_ms=1.0, confirmed=True)


class Scenario:
    """A forum and the agent of a robot.

    A command whose motion is about to begin waits until it is released; places are positions in the order of the
    forum's events.
    """

    def __init__(self, folder: Path, clock: Clock) -> None:
        self.folder, self.clock = folder, clock
        self.world = World(clock=clock)
        self.robot = self.world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)
        self.alice = self.world.sign_in("alice", role=Role.OPERATOR)
        self.bob = self.world.sign_in("bob")
        self.commands: dict[str, int] = {}
        self.stops: list[int] = []
        self.set_back: list[int] = []  # the places after which the clock was set back
        self.heard_after: dict[str, int] = {}  # the newest place when a command was received
        self.heard = 0
        self.ran: list[str] = []
        self.refused: dict[str, str] = {}
        self.gate = asyncio.Event()
        self.final_report = self
        self.waiting: set[asyncio.Task[Any] | None] = set()
        self.denied: set[asyncio.Task[Any]] = set()

    # ---------------------------------------------------------------- the agent, and what stands for its course
    async def start(self) -> None:
        self.agent = RobotAgent(ROBOT, robot_settings(), self.robot, Robot(), RulesMind(), self.folder)  # type: ignore[arg-type]
        self.agent._make_pipeline = lambda: self  # type: ignore[assignment, method-assign, return-value]
        await self.agent._start()
        self._note_heard()
        await self.idle()

    async def publish_left_replays(self) -> None:
        """Nothing was recorded."""

    async def end(self) -> None:
        for task in tuple(self.agent.tasks.running):
            task.cancel()
        await asyncio.gather(*self.agent.tasks.running, return_exceptions=True)
        self.waiting.clear()
        await self.agent.journal.close()

    async def idle(self) -> None:
        while busy := self.agent.tasks.running - self.waiting:
            await asyncio.wait(busy)

    async def run(self, job: QueuedCommand) -> None:
        post_id, journal, task = job.command.post_id, self.agent.journal, asyncio.current_task()
        self.waiting.add(task)
        await job.unless_ended(self.gate.wait())
        self.waiting.discard(task)
        if job.ended is not None:
            self.refused[post_id] = job.ended
        elif await journal._begin(post_id) is None:
            self.ran.append(post_id)
            later = [place for place in self.stops if self.commands[post_id] < place <= self.heard]
            assert not later, f"ran after the stops {later}, that were posted after it"
        self.agent.queue.leave(job)
        await journal.finish(post_id, CommandState.CANCELLED)

    def show_place(self, job: QueuedCommand) -> None:
        return None

    async def moves(self, trace_id: str) -> bool:
        return False

    # ---------------------------------------------------------------- events
    async def do(self, action: str, value: float = 0.0) -> None:
        self.clock.true_s += 0.001
        match action:
            case "command":
                await self.command()
            case "stop":
                await self.bob.create_topic("robots", "t", f"@{ROBOT} stop", key=self.key())
                self.stops.append(len(self.world.events))
            case "press":
                await self.bob.press_stop(ROBOT)
                self.stops.append(len(self.world.events))
            case "set":
                self.set_back += [len(self.world.events)] if value < self.world.clock_offset_s else []
                self.world.clock_offset_s = value
            case "pass":
                self.clock.true_s += value
            case "beat":
                self.agent.clock.note(self.world.now())
            case "hear":
                for event in await self.robot.changes(self.agent.event_stream.cursor):
                    self.agent.event_stream.cursor = event.id
                    self.agent._handle_event_safely(event)
                    self._note_heard()
            case "take":
                await self.agent.inbox.take_waiting()
            case "let":
                self.gate.set()
                self.waiting.clear()
                await self.idle()
                self.gate.clear()
            case "restart" | "reboot":
                await self.end()
                if action == "reboot":
                    self.clock.started_s, self.clock.machine = self.clock.true_s, self.clock.machine + 1
                await self.start()
        await self.idle()

    async def command(self) -> str:
        post = (await self.alice.create_topic("robots", "t", f"@{ROBOT} wave", key=self.key())).post
        self.commands[post.id] = len(self.world.events)
        return post.id

    def key(self) -> str:
        return str(len(self.world.events))

    def _note_heard(self) -> None:
        self.heard = max(self.heard, int(self.agent.event_stream.cursor))
        for post_id, place in self.commands.items():
            if place <= self.heard:
                self.heard_after.setdefault(post_id, len(self.world.events))

    # ---------------------------------------------------------------- invariants at the end
    async def finish(self) -> None:
        for action in ("hear", "take", "let"):
            await self.do(action)
        last = max(self.stops, default=0)
        for post_id, why in self.refused.items():
            if why in (EndReason.STOP, EndReason.CLOCK) and self.commands[post_id] > last:
                between = [p for p in self.set_back if last <= p <= self.heard_after[post_id]]
                assert between, f"{post_id} was posted after the last stop, and ended by it: {why}"
        for action in ("command", "hear", "take", "let", "pass") * 2:  # with the first of the two the agent may notice
            await self.do(action, 6.0)
        post_id = list(self.commands)[-1]
        assert post_id in self.ran, f"a stop blocks what is posted after it: {self.refused.get(post_id)}"


async def run_actions(actions: list[Action], clock: Clock) -> Scenario:
    with tempfile.TemporaryDirectory() as folder:
        scenario = Scenario(Path(folder), clock)
        await scenario.start()
        try:
            for action, value in actions:
                await scenario.do(action, value)
            await scenario.finish()
        finally:
            await scenario.end()
        return scenario


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Return the monotonic clock of agents whose journal only stores rows."""
    made = Clock()
    monkeypatch.setattr(time, "clock_gettime", lambda which: made.elapsed_s())
    for module in (stop_handler, rows):
        monkeypatch.setattr(module, "boot", lambda: f"machine-{made.machine}")
    return made


OFFSETS = st.sampled_from([0.0, 3.0, -3.0, 60.0, -60.0, 3600.0, -3600.0, 400 * DAY_S, 399 * DAY_S, -30 * DAY_S])
ACTIONS = st.one_of(
    st.sampled_from(["command", "command", "stop", "press", "beat", "hear", "take", "let", "restart", "reboot"]).map(
        lambda action: (action, 0.0)
    ),
    st.tuples(st.just("set"), OFFSETS),
    st.tuples(st.just("pass"), st.sampled_from([0.01, 2.0, 30.0, 300.0])),
)


def parse_actions(actions: str) -> list[Action]:
    return [(words[0], float(words[1]) if words[1:] else 0.0) for words in map(str.split, actions.split(", "))]


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
@given(st.lists(ACTIONS, min_size=3, max_size=25))
@example(parse_actions("set 3600, command, set 0, stop, hear, take, let"))
@example(parse_actions("set 3600, command, hear, take, set 0, stop, restart, let"))
@example(parse_actions("set 3600, command, hear, take, set 0, stop, reboot, let"))
@example(parse_actions("set 34560000, stop, hear, set 0"))
@example(parse_actions("set 34560000, stop, hear, set 0, restart, reboot"))
@example(parse_actions("set 34560000, stop, hear, pass 2, beat, set 0, set 34473600"))
@example(parse_actions("stop, hear, set -3600, command, hear"))
@example(parse_actions("set 34560000, reboot, set 0, stop"))
def test_law_14_whatever_the_clock_does_a_stop_ends_what_was_before_it_and_blocks_nothing_after_it(
    clock: Clock, actions: list[Action]
) -> None:
    clock.__init__()  # type: ignore[misc]
    asyncio.run(run_actions(actions, clock))
