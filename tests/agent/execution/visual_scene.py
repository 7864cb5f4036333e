"""Scripted models and a driver without a process, for tests of the visual loop."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from agentrob.agent.execution.execute import ExecutionHooks
from agentrob.agent.execution.visual import VisualTask
from agentrob.errors import LeaseLost
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.minds.llm.chat import Answer, Message, ModelReply, Tool
from agentrob.minds.llm.prompt import loop_prompt
from agentrob.minds.llm.tool_calls import checked_call
from agentrob.minds.visual_loop.goal import goal_sentence
from agentrob.minds.visual_loop.loop import LoopBudget
from agentrob.model import (
    Account,
    ActionResult,
    Capabilities,
    Command,
    Decision,
    Mandate,
    Op,
    Plan,
    Posture,
    Primitive,
    RobotState,
    Verdict,
)
from agentrob.robots.safety.guard import Guard
from agentrob.screening.mandate import goal_mandate

BALL = Goal((Subgoal(Aim.APPROACH, "ball", "red"), Subgoal(Aim.LOOK, "ball", "red", "beside")))
MOST = Mandate({Op.GET_FRONT_IMAGE: 10}, distance_m=5.0, degrees=720.0, seconds=120.0, steps=12, speed_mps=0.3)
COMMAND = Command(
    "p1", "t1", "hash", Account("1", "alice"), "quadruped", "walk to the red ball", "en", datetime.now(UTC), "trace"
)
Call = tuple[str, Any]


@dataclass
class Script:
    """A scripted model: for each turn a list of calls (name, arguments), words, or something to await."""

    turns: list[Any]
    name: str = "scripted"
    asked: list[Sequence[Message]] = field(default_factory=list)
    offered: list[list[str]] = field(default_factory=list)
    thinking: asyncio.Event = field(default_factory=asyncio.Event)

    async def turn(
        self, system_prompt: str, conversation: Sequence[Message], tools: Sequence[Tool], spent: Any = ()
    ) -> Answer[ModelReply]:
        self.asked.append(list(conversation))
        self.offered.append([tool.name for tool in tools])
        said = self.turns[min(len(self.asked), len(self.turns)) - 1]
        if callable(said):
            said = said(conversation)
        if isinstance(said, asyncio.Event):
            self.thinking.set()
            await said.wait()
            said = ""
        if isinstance(said, BaseException):
            raise said
        if isinstance(said, str):
            return Answer(ModelReply(said), self.name, ())
        calls = [checked_call(f"c{n}", name, raw, tools) for n, (name, raw) in enumerate(said)]
        return Answer(ModelReply("", tuple(calls)), self.name, ())

    async def prepare(self) -> None: ...

    async def close(self) -> None: ...


class LocalDriver:
    """The driver client's interface to a guard in this process; `steps` are the steps that reached the robot."""

    def __init__(self, guard: Guard) -> None:
        self.guard = guard
        self.steps: list[Primitive] = []
        self.ended: LeaseLost | None = None
        self.began = asyncio.Event()

    async def capabilities(self) -> Capabilities:
        return self.guard.capabilities

    async def state(self) -> RobotState:
        return self.guard.state()

    async def posture(self, *, joints: bool = True) -> Posture:
        return self.guard.posture()

    @asynccontextmanager
    async def lease(self, holder: str, since_s: float) -> AsyncIterator[str]:
        yield "lease"

    async def lost(self, lease: str) -> LeaseLost | None:
        return self.ended

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        if self.ended:
            raise self.ended
        self.steps.append(primitive)
        self.began.set()
        watch: Callable[[RobotState], str | None] = lambda _: self.ended.why if self.ended else None  # noqa: E731
        return await asyncio.to_thread(self.guard.step, primitive, watch, deadline_s)

    async def stop(self, by: str) -> None:
        await asyncio.to_thread(self.guard.stop)


def visual_task(
    model: Script, goal: Goal = BALL, most: Mandate = MOST, calls: int = 12, seconds: float = 60.0, idle: int = 3
) -> VisualTask:
    capabilities = Capabilities("fake", frozenset(Op), simulated=True)
    mandate = goal_mandate(goal, most, capabilities)
    budget = LoopBudget(calls, seconds, idle)
    prompt = loop_prompt("fake", "en")
    steps = [str(step.op) for step in goal.steps]
    return VisualTask(goal, goal_sentence(goal, "en", steps), prompt, model, mandate, capabilities, budget)  # type: ignore[arg-type]


def hooks(**changed: Any) -> ExecutionHooks:
    """Hooks that allow everything and never stop."""

    async def since() -> float:
        return 0.0

    async def permit(_: Plan) -> tuple[Verdict, Capabilities | None]:
        return Verdict(Decision.ALLOW, "test"), Capabilities("fake", frozenset(Op), simulated=True)

    async def alive() -> bool:
        return True

    async def stop(_: str) -> None: ...

    given: dict[str, Any] = {
        "since": since, "permit": permit, "ended": lambda: None, "alive": alive, "silent": lambda: False,
        "stop": stop, "on_step": lambda *_: None,
    }  # fmt: skip
    return ExecutionHooks(**{**given, **changed})
