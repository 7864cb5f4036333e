"""A screened plan, step by step under its mandate, through the robot's driver: the only deed that moves anything."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace

from agentrob.errors import LeaseLost, RobotBusy, RobotError, RobotUnreachable
from agentrob.judge.mandate import mandate_of, within
from agentrob.minds.loop import Looked
from agentrob.model import (
    ActionResult,
    Capabilities,
    Command,
    Decision,
    Mandate,
    Outcome,
    Plan,
    Primitive,
    Verdict,
)
from agentrob.robots.client import DriverClient

LOOK_S = 0.05
#: How long a busy robot is asked again: the lease of one who died lapses within a second.
BUSY_S = 1.5
#: Why a step ended that we ended ourselves; each is a status, or makes one.
STOP, SHUTDOWN, SILENT = "stop", "shutdown", "stop_channel"
#: Why a step's end is not known: the driver did not answer any more.
UNREACHABLE = "unreachable"
_BY_PEOPLE = frozenset({"stop", "halt"})
_BY_US = frozenset({SHUTDOWN, SILENT, "lease_lapsed"})


@dataclass(frozen=True, slots=True)
class Reins:
    """How the agent holds a running command.

    `since` tells since when (monotonic seconds) no stop may have come. `permit` judges a plan of the command anew on
    today's state. `ended` gives a stable word as soon as the command must end
    (`stop`, `shutdown`, or what cancelled it). `alive` waits until the stop channel is proven alive, `silent` tells
    that it no longer is. `stop` stops the robot at our own wish, `on_step` hears which step begins and its number
    from 0, and no step takes longer than `step_s`.
    """

    since: Callable[[], Awaitable[float]]
    permit: Callable[[Plan], Awaitable[tuple[Verdict, Capabilities | None]]]
    ended: Callable[[], str | None]
    alive: Callable[[], Awaitable[bool]]
    silent: Callable[[], bool]
    stop: Callable[[str], Awaitable[object]]
    on_step: Callable[[Primitive, int], None]
    step_s: float = math.inf


@dataclass(frozen=True, slots=True)
class Execution:
    """What came of a plan: one result per step. `first_motion_s` is monotonic; `message` is an English sentence.

    `stopped_by` is who stopped the robot past us, as they called themselves. `pictures` are the files of the steps'
    pictures ("" for none), once they are on disk; `looked` is the loop of a model that steered.
    """

    status: str
    results: tuple[ActionResult, ...] = ()
    verdict: Verdict | None = None
    message: str = ""
    first_motion_s: float | None = None
    pictures: tuple[str, ...] = ()
    stopped_by: str = ""
    looked: Looked | None = None


class Run:
    """One execution under way, of a plan or (`agentrob.agent.look`) of a goal."""

    def __init__(self, driver: DriverClient, command: Command, plan: Plan, reins: Reins) -> None:
        self.driver = driver
        self.command = command
        self.plan = plan
        self.reins = reins
        self.results: list[ActionResult] = []
        self.verdict: Verdict | None = None
        self.first_motion_s: float | None = None
        self.mandate: Mandate | None = None
        self.lease = ""
        self.stopped_by = ""
        self.started_s = time.monotonic()

    async def steps(self) -> str:
        """Do the steps; returns the command's status."""
        for number, step in enumerate(self.plan.steps):
            if (status := await self._may(step)) is not None:
                return status
            self.reins.on_step(step, number)
            result = await self._step(step)
            self.results.append(result)
            if not result.ok:
                if result.reason in _BY_PEOPLE:
                    await self._ask_who()
                return self._status_of(result)
        return "done"

    async def _may(self, step: Primitive) -> str | None:
        """None when the step may begin now, else the status that the command ends with."""
        if step.moves or not self.results:
            self.verdict, capabilities = await self.reins.permit(self.plan)
            if self.verdict.decision is not Decision.ALLOW or capabilities is None:
                return "cancelled" if self.verdict.rule.startswith("command.") else "refused"
            self.mandate = self.mandate or mandate_of(self.plan, capabilities)
        assert self.mandate is not None
        if (beyond := within(self.mandate, self.results, step)) is not None:
            self._refused(step, "mandate", beyond)
            return "refused"
        if step.moves and not await self.reins.alive():
            self._refused(step, SILENT, "The forum does not answer, so nobody could stop me.")
            return "interrupted"
        # Nothing is awaited between this look and the step: whatever ended the command before now, ends it here.
        return self._status_of_end(why) if (why := self.reins.ended()) else None

    def _refused(self, step: Primitive, reason: str, message: str) -> None:
        now_s = time.monotonic()
        self.results.append(
            ActionResult(step, Outcome.REFUSED, reason=reason, message=message, started_s=now_s, ended_s=now_s)
        )

    async def _step(self, step: Primitive) -> ActionResult:
        sent_s = time.monotonic()
        deadline_s = min(self.reins.step_s, max(0.1, self.left_s()))
        stepping = asyncio.create_task(self.driver.step(self.lease, step, deadline_s))
        ended_by = ""
        try:
            while not stepping.done():
                await asyncio.wait({stepping}, timeout=LOOK_S)
                if not ended_by and not stepping.done() and (ended_by := self._must_end(step)) and ended_by != STOP:
                    await self._stop(ended_by)
            result = _outcome(stepping, step, sent_s)
        finally:
            if not stepping.done():
                stepping.cancel()
                await asyncio.shield(self._stop(SHUTDOWN))
        if step.moves and self.first_motion_s is None and result.outcome is not Outcome.REFUSED:
            self.first_motion_s = result.started_s if sent_s <= result.started_s <= time.monotonic() else sent_s
        stopped_by_us = ended_by and result.outcome in (Outcome.STOPPED, Outcome.INTERRUPTED)
        return replace(result, reason=ended_by) if stopped_by_us and result.reason in _BY_PEOPLE else result

    def left_s(self) -> float:
        """Seconds that the next step may take."""
        assert self.mandate is not None
        return self.mandate.seconds - (time.monotonic() - self.started_s)

    async def _ask_who(self) -> None:
        """Whose stop it was: the driver knows, also when the forum does not."""
        with contextlib.suppress(RobotError):
            if (lost := await self.driver.lost(self.lease)) is not None:
                self.stopped_by = lost.by

    def _must_end(self, step: Primitive) -> str:
        if why := self.reins.ended():
            return why
        return SILENT if step.moves and self.reins.silent() else ""

    async def _stop(self, why: str) -> None:
        with contextlib.suppress(RobotError):  # then the lease lapses, and the driver stops the robot by itself
            await self.reins.stop(why)

    def _status_of(self, result: ActionResult) -> str:
        if result.outcome in (Outcome.STOPPED, Outcome.INTERRUPTED):
            if result.reason in _BY_PEOPLE:
                return "stopped"
            return "interrupted" if result.reason in _BY_US else "failed"
        if result.reason == UNREACHABLE:
            return "interrupted"  # begun, and nobody can tell how far it went
        if result.outcome is Outcome.REFUSED and len(self.results) == 1:
            return "refused"
        return "failed"

    def _status_of_end(self, why: str) -> str:
        return {STOP: "stopped", SHUTDOWN: "interrupted"}.get(why, "cancelled")

    def execution(self, status: str, message: str = "") -> Execution:
        rest = self.plan.steps[len(self.results) :]
        skipped = (ActionResult(step, Outcome.SKIPPED) for step in rest)
        return Execution(
            status, (*self.results, *skipped), self.verdict, message, self.first_motion_s, stopped_by=self.stopped_by
        )


async def execute(driver: DriverClient, command: Command, plan: Plan, reins: Reins) -> Execution:
    """Hold the robot's lease for the whole command and do its steps until one does not succeed. Never raises a
    `RobotError`: a robot that cannot be used is a result."""
    run = Run(driver, command, plan, reins)
    status, message = "failed", ""
    try:
        async with contextlib.AsyncExitStack() as stack:
            await take_lease(stack, run)
            status = await run.steps()
    except LeaseLost as e:  # a stop came after the command was accepted, perhaps one that the forum knows nothing of
        run.stopped_by = e.by
        status, message = ("stopped", "") if e.why in _BY_PEOPLE else ("failed", str(e))
    except (RobotBusy, RobotUnreachable, RobotError) as e:
        message = str(e)
    return run.execution(status, message)


async def take_lease(stack: contextlib.AsyncExitStack, run: Run) -> None:
    """Take the robot's lease. An agent that was killed keeps it for a moment longer, so a busy robot is asked again."""
    until_s = time.monotonic() + BUSY_S
    while run.reins.ended() is None:
        try:
            lease = run.driver.lease(f"agent {run.command.trace_id}", await run.reins.since())
            run.lease = await stack.enter_async_context(lease)
            return
        except RobotBusy:
            if time.monotonic() >= until_s:
                raise
            await asyncio.sleep(LOOK_S)


def _outcome(stepping: asyncio.Task[ActionResult], step: Primitive, sent_s: float) -> ActionResult:
    """A step's result, also when the driver gave none."""
    try:
        return stepping.result()
    except LeaseLost as e:
        reason, outcome, said = e.why, Outcome.STOPPED, str(e)
    except RobotError as e:
        reason, outcome, said = UNREACHABLE, Outcome.UNKNOWN, str(e)
    return ActionResult(step, outcome, reason=reason, message=said, started_s=sent_s, ended_s=time.monotonic())


def decisive(execution: Execution, verdict: Verdict) -> Verdict:
    """The verdict that the report names: the guard's, where it refused what the screen had let pass."""
    last = execution.verdict or verdict
    if execution.status == "refused" and last.decision is Decision.ALLOW and execution.results:
        return Verdict(Decision.REFUSE, f"guard.{execution.results[0].reason}")
    return last
