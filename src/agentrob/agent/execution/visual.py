"""Execute a screened goal through the robot's driver: a model calls the steps, each checked like a plan's step (see
`goal_run`). A stop interrupts the model at once."""

from __future__ import annotations

import asyncio
import contextlib
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import structlog

from agentrob.agent.execution.execute import LOOK_S, Execution, ExecutionHooks
from agentrob.agent.execution.goal_run import CommandEnded, GoalRun
from agentrob.errors import RobotError, RobotUnreachable
from agentrob.language.goal import Goal
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.usage import Usage
from agentrob.minds.visual_loop.claims import contradiction
from agentrob.minds.visual_loop.loop import LoopBudget, LoopEnd, LoopRecord, StepAttempt, VisualLoop
from agentrob.model import (
    ActionResult,
    Capabilities,
    Command,
    CommandState,
    Mandate,
    Primitive,
    RobotState,
)
from agentrob.robots.driver.client import DriverClient

#: How often the lease is checked while a model thinks: a stop at the machine ends it.
ASK_LEASE_S = 0.5


_log = structlog.get_logger()
OnResult = Callable[[ActionResult], None]


@dataclass(frozen=True, slots=True)
class VisualTask:
    """A goal, the model that sees, and its limits. `goal_text` is the goal in the agent's words."""

    goal: Goal
    goal_text: str
    prompt: str
    vision_model: ChatModel
    mandate: Mandate
    capabilities: Capabilities
    budget: LoopBudget
    spent: Sequence[Usage] = ()


class VisualRun(GoalRun):
    """One visual loop in progress; the `ToolExecutor` of the loop."""

    def __init__(
        self,
        driver: DriverClient,
        command: Command,
        visual_task: VisualTask,
        hooks: ExecutionHooks,
        on_result: OnResult,
    ) -> None:
        super().__init__(driver, command, visual_task.mandate, hooks)
        self.visual_task = visual_task
        self.on_result = on_result
        self.stepping = False
        self.end = LoopEnd("cut")
        self.loop = VisualLoop(
            visual_task.vision_model, visual_task.prompt, visual_task.goal_text, visual_task.mandate,
            visual_task.capabilities, self, visual_task.budget, visual_task.spent,
        )  # fmt: skip

    # ------------------------------------------------------------ the tool executor
    @property
    def used(self) -> Sequence[ActionResult]:
        return self.results

    async def state(self) -> RobotState | None:
        try:
            return await self.driver.state()
        except RobotError:
            return None

    async def act(self, step: Primitive) -> StepAttempt:
        self.stepping = True
        try:
            return await super().act(step)
        finally:
            self.stepping = False

    def _settled(self, result: ActionResult) -> None:
        self.stepping = False
        self.on_result(result)

    def left_s(self) -> float:
        moved_s = sum(r.duration_s for r in self.results)
        return min(self.visual_task.mandate.seconds - moved_s, self.visual_task.budget.seconds - self.since_s())

    def since_s(self) -> float:
        return time.monotonic() - self.started_s

    # ------------------------------------------------------------ the loop, and what ends it
    async def reached(self) -> CommandState:
        """Run the loop to its end; return the command's final state."""
        try:
            self.end = await self.follow()
        except CommandEnded as e:
            return e.status
        if self.end.claim == "done":
            return CommandState.DONE
        why = self.hooks.ended()  # it may have come while the loop ended by itself
        return CommandState.FAILED if why is None else why.state_in_motion

    async def follow(self) -> LoopEnd:
        """Run the loop to its end. Raises `CommandEnded` or `LeaseLost` as soon as it is interrupted."""
        looping = asyncio.create_task(self.loop.run())
        asked_s = time.monotonic()
        try:
            while not looping.done():
                await asyncio.wait({looping}, timeout=LOOK_S)
                if looping.done() or self.stepping:
                    continue  # a step checks the same conditions itself
                if why := self.hooks.ended():
                    raise CommandEnded(why.state_in_motion)
                if time.monotonic() - asked_s > ASK_LEASE_S:
                    await self._keeps_lease()
                    asked_s = time.monotonic()
            return looping.result()
        finally:
            if not looping.done():
                looping.cancel()
                await asyncio.wait({looping})

    async def _keeps_lease(self) -> None:
        with contextlib.suppress(RobotUnreachable):  # the next step reports it
            if (lost := await self.driver.lost(self.lease)) is not None and not self.stepping:
                raise lost

    def loop_record(self, end: LoopEnd) -> LoopRecord:
        results = self.results
        denied = contradiction(self.visual_task.goal, end.claim, end.did, results, self.command.language)
        loop = self.loop
        return LoopRecord(self.visual_task.goal_text, end, tuple(loop.turns), tuple(loop.usage), loop.mind, denied)

    def execution(self) -> Execution:
        execution = super().execution()
        try:
            looked: LoopRecord | None = self.loop_record(self.end)
        except Exception:  # report the measurements anyway; a claim that cannot be checked does not count
            _log.error("loop not described", trace=traceback.format_exc())
            looked = None
        if (looked is None or looked.contradicted) and execution.status is CommandState.DONE:
            execution = replace(execution, status=CommandState.FAILED)
        return replace(execution, looked=looked)


async def run_visual_task(
    driver: DriverClient,
    command: Command,
    visual_task: VisualTask,
    hooks: ExecutionHooks,
    on_result: OnResult = lambda _: None,
) -> Execution:
    """Hold the robot's lease while a model works towards the goal. Raises nothing but a cancellation."""
    run = VisualRun(driver, command, visual_task, hooks, on_result)
    return await run.run_with_lease(run.reached)
