"""Execute a screened goal through the robot's driver: a model calls the steps, each checked like a plan's step.

Every call is judged again before it moves anything: the mandate, the post, its author's rights, the limits, the stop
channel, the lease and, in the driver's process, the guard. A stop interrupts the model at once.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import structlog

from agentrob.agent.execution.execute import BY_PEOPLE, LOOK_S, SILENT, Execution, ExecutionHooks, Run
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
    Decision,
    Mandate,
    Outcome,
    Plan,
    Primitive,
    RobotState,
)
from agentrob.robots.driver.client import DriverClient
from agentrob.screening.mandate import mandate_violation

#: How often the lease is checked while a model thinks: a stop at the machine ends it.
ASK_LEASE_S = 0.5
#: Reasons after which the model may try another step; any other reason ends the command.
_GOES_ON = frozenset({"", "obstacle", "fence", "deadline", "stalled", "invalid", "unsupported", "ranges_unknown"})
#: Rules that refuse a step and not the command: the model gets the reason.
_OF_A_STEP = ("limit.", "plan.", "ops.", "consent.", "scene.")


_log = structlog.get_logger()
OnResult = Callable[[ActionResult], None]


class CommandEnded(Exception):
    """The loop must end now; `status` is the command's final state."""

    def __init__(self, status: CommandState) -> None:
        super().__init__(status)
        self.status = status


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


class VisualRun(Run):
    """One visual loop in progress; the `ToolExecutor` of the loop."""

    def __init__(
        self,
        driver: DriverClient,
        command: Command,
        visual_task: VisualTask,
        hooks: ExecutionHooks,
        on_result: OnResult,
    ) -> None:
        super().__init__(driver, command, Plan(), hooks)
        self.mandate = visual_task.mandate
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
        """Execute a step if permitted; raises `CommandEnded` if the whole command must end."""
        self.stepping = True
        try:
            if (problem := await self._problem(step)) is not None:
                return StepAttempt(None, problem)
            self.hooks.on_step(step, len(self.results))
            result = await self._step(step)
        finally:
            self.stepping = False
        self.on_result(result)
        if result.reason in BY_PEOPLE:
            await self._ask_who()
        goes_on = result.reason in _GOES_ON or result.reason.startswith("limit_")
        if result.outcome is Outcome.UNKNOWN or not (result.ok or goes_on):
            raise CommandEnded(self._status_of(result))
        return StepAttempt(result)

    async def _problem(self, step: Primitive) -> str | None:
        """Return None if the step may begin now, else the reason. Raises `CommandEnded` if no step may begin."""
        assert self.mandate is not None
        if (beyond := mandate_violation(self.mandate, self.results, step)) is not None:
            return beyond
        if (step.moves or not self.results) and (reason := await self._denied(step)) is not None:
            return reason
        if step.moves and not await self.hooks.alive():
            self._refused(step, SILENT, "The forum does not answer, so nobody could stop me.")
            raise CommandEnded(CommandState.INTERRUPTED)
        # There is no await between this check and the step, so an end that came earlier is never missed.
        if why := self.hooks.ended():
            raise CommandEnded(why.state_in_motion)
        return None

    async def _denied(self, step: Primitive) -> str | None:
        """Return why the step is refused in the current state. Raises `CommandEnded` if that ends the command."""
        verdict, capabilities = await self.hooks.permit(Plan((step,)))
        if verdict.decision is Decision.ALLOW and capabilities is not None:
            return None
        if verdict.rule.startswith(_OF_A_STEP):
            return verdict.reason
        self.verdict = verdict
        raise CommandEnded(self._status_of_verdict(verdict))

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
        return CommandState.DONE if self.end.claim == "done" else CommandState.FAILED

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
