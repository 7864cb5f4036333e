"""A fake robot that logs what it really did, behind a real driver, and gates on the path of a command."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import ActionResult, Plan, Primitive, StopResult, Understanding
from agentrob.robots.control.controller import REST, Velocity
from agentrob.robots.driver.api import DriverServer
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.driver import Driver
from agentrob.robots.driver.process import listening
from agentrob.robots.fake import FakeRobot
from agentrob.robots.protocol import Watch
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from tests.agent.agent_scene import ROBOT, robot_settings

TIME_SCALE = 10.0


class Gate:
    """Holds each caller until it is released; `held` are the waiting callers by their keys."""

    def __init__(self) -> None:
        self.open = False
        self._waiting: dict[asyncio.Event, object] = {}

    @property
    def held(self) -> list[object]:
        return [what for event, what in self._waiting.items() if not event.is_set()]

    async def wait(self, what: object) -> None:
        if self.open:
            return
        event = asyncio.Event()
        self._waiting[event] = what
        try:
            await event.wait()
        finally:
            del self._waiting[event]

    def let(self) -> None:
        for event in self._waiting:
            event.set()


class BodyGate:
    """The same gate inside the robot, in the driver's threads: a step is held until it is released or must end."""

    def __init__(self) -> None:
        self.open = False
        self.holding = False
        self._let = threading.Event()

    @property
    def held(self) -> list[object]:
        return [self] if self.holding and not self._let.is_set() else []

    def wait(self, ends: Callable[[], bool]) -> None:
        self._let.clear()
        self.holding = True
        try:
            while not self.open and not ends() and not self._let.wait(0.005):
                pass
        finally:
            self.holding = False

    def let(self) -> None:
        if self.holding:
            self._let.set()


class Gates:
    """The gates on the path of a command: reading, before the lease, after the permission, before the motion."""

    def __init__(self) -> None:
        self.mind, self.lease, self.step, self.body = Gate(), Gate(), Gate(), BodyGate()

    def let_all(self) -> None:
        """Release everybody to the next gate."""
        for gate in (self.body, self.step, self.lease, self.mind):
            gate.let()

    def open(self) -> None:
        """Release everybody for good."""
        for gate in (self.body, self.step, self.lease, self.mind):
            gate.open = True
            gate.let()


class RecordingRobot(FakeRobot):
    """Calls `on_step` when the guard accepts a step, and `on_motion` when the body is first commanded to move for it;
    counts stops."""

    def __init__(self) -> None:
        self.gate = BodyGate()
        self.on_step: Callable[[Primitive], None] = lambda _: None
        self.on_motion: Callable[[Primitive], None] = lambda _: None
        self.stopped = 0
        self._at: Primitive | None = None
        super().__init__(robot_settings(options={"time_scale": TIME_SCALE}))

    def limit(self, step_deg: float) -> None:
        self.capabilities = replace(self.capabilities, limits=replace(self.capabilities.limits, step_deg=step_deg))

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        stops = self.stopped
        self.on_step(primitive)
        self.gate.wait(lambda: self.stopped != stops or watch(self.state()) is not None)
        self._at = primitive
        return super().step(primitive, lambda state: "stop" if self.stopped != stops else watch(state))

    def command(self, velocity: Velocity) -> None:
        if velocity != REST and self._at is not None:
            step, self._at = self._at, None
            self.on_motion(step)
        super().command(velocity)

    def stop(self) -> StopResult:
        self.stopped += 1
        return super().stop()


class Stand:
    """A ledger robot behind guard, lease and socket in this process, served like a real driver."""

    def __init__(self, folder: Path, robot: RecordingRobot, driver: Driver) -> None:
        self.folder, self.robot, self.driver = folder, robot, driver
        self.socket = folder / "robot.sock"

    def limit(self, step_deg: float) -> None:
        """Change the owner's limit for one turn."""
        self.robot.limit(step_deg)
        self.driver.guard.capabilities = self.robot.capabilities


@contextlib.contextmanager
def robot_stand(folder: Path) -> Iterator[Stand]:
    robot = RecordingRobot()
    driver = Driver(ROBOT, Guard(robot, robot_settings(), Halt(folder / "robot.halt")))
    with listening(folder / "robot.sock") as addressee, DriverServer(driver, addressee):
        yield Stand(folder, robot, driver)
        driver.close()


class GatedClient(DriverClient):
    """The agent's driver client with two gates: before the lease, and between the last check and the step."""

    def __init__(self, socket: Path, gates: Gates, on_step: Callable[[Primitive], None]) -> None:
        super().__init__(ROBOT, socket)
        self._gates, self._on_step = gates, on_step

    @contextlib.asynccontextmanager
    async def lease(self, holder: str, since_s: float | None = None) -> AsyncIterator[str]:
        await self._gates.lease.wait(holder)
        async with super().lease(holder, since_s) as lease:
            yield lease

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        self._on_step(primitive)
        await self._gates.step.wait(primitive)
        return await super().step(lease, primitive, deadline_s)


class GatedMind(RulesMind):
    """A mind that reads a post when it is released."""

    def __init__(self, gates: Gates) -> None:
        self._gate = gates.mind

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        await self._gate.wait(text)
        return await super().understand(text, addressee, history)
