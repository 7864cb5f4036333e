"""Carry out a screened plan step by step under its mandate. No other code of the agent moves a robot.

Each result is stored on the `Run` at once, before it is used, so that a bug cannot lose a measurement (law 18).
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
import traceback
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace

import structlog

from agentrob.errors import LeaseLost, RobotBusy, RobotError
from agentrob.minds.visual_loop.loop import LoopRecord
from agentrob.model import (
    ActionResult,
    Capabilities,
    Command,
    CommandState,
    Decision,
    EndReason,
    Mandate,
    Outcome,
    Plan,
    Primitive,
    Verdict,
)
from agentrob.robots.driver.client import DriverClient
from agentrob.screening.mandate import mandate_of, mandate_violation

LOOK_S = 0.05
#: How long to retry for the lease of a busy robot; the lease of a dead process expires within a second.
BUSY_S = 1.5
#: Why the agent ended a step: the forum did not answer, so a stop could not have arrived.
SILENT = "stop_channel"
#: Why the result of a step is unknown: the driver stopped answering.
UNREACHABLE = "unreachable"
#: Why a step or a command ended: an error in the agent.
INTERNAL = "internal"
#: The rule of a verdict when the forum did not answer, so that the command may have changed.
UNVERIFIED = "command.unverified"
#: How long to wait for the driver's result of a step that an error in the agent ended.
TELL_S = 5.0
#: Why a step ended: a person stopped it.
BY_PEOPLE = frozenset({EndReason.STOP, "halt"})
LAPSED = "lease_lapsed"
#: A step that is refused because another robot took the room first is tried this often.
ROOM_TAKEN, ROOM_TRIES = frozenset({"room_busy", "room_restless"}), 3
FENCED = "fenced"
_BY_US = frozenset({EndReason.SHUTDOWN, SILENT, LAPSED, FENCED})
_log = structlog.get_logger()


async def _enters(_: Sequence[Primitive]) -> None:
    """The robot shares no room."""


@dataclass(frozen=True, slots=True)
class ExecutionHooks:
    """Callbacks through which the agent controls a running command.

    `since` returns the time (monotonic seconds) since when no stop may have come. `permit` judges a plan again, on the
    current state. `ended` returns the reason as soon as the command must end. `alive` waits until the stop channel is
    proven alive; `silent` returns whether it no longer is. `stop` stops the robot. `on_step` is called with each step
    and its number from 0. A step takes at most `step_s`. `enter_room` waits until these steps may begin in the room
    that the robot shares, or until waiting does not help: the driver then refuses the first one. `on_run` gets the run
    before its first step; its results can be read at any time.
    """

    since: Callable[[], Awaitable[float]]
    permit: Callable[[Plan], Awaitable[tuple[Verdict, Capabilities | None]]]
    ended: Callable[[], EndReason | None]
    alive: Callable[[], Awaitable[bool]]
    silent: Callable[[], bool]
    stop: Callable[[str], Awaitable[object]]
    on_step: Callable[[Primitive, int], None]
    step_s: float = math.inf
    enter_room: Callable[[Sequence[Primitive]], Awaitable[object]] = _enters
    on_run: Callable[[Run], None] = lambda _: None


@dataclass(frozen=True, slots=True)
class Execution:
    """The result of a plan, with one result per step. `first_motion_s` is monotonic. `message` is an English sentence
    of the driver; `fault` is set if an error in the agent ended it.

    `findings` are sentences in the language of the post about what was found. `stopped_by` is the name given by
    somebody who stopped the robot at the driver. `pictures` are the paths of the steps' pictures ("" for none), once
    they are on disk. `looked` records the visual loop, if a model steered.
    """

    status: CommandState
    results: tuple[ActionResult, ...] = ()
    verdict: Verdict | None = None
    message: str = ""
    first_motion_s: float | None = None
    pictures: tuple[str, ...] = ()
    stopped_by: str = ""
    looked: LoopRecord | None = None
    fault: str = ""
    findings: tuple[str, ...] = ()


class Run:
    """One execution in progress, of a plan or (`agentrob.agent.execution.visual`) of a goal."""

    def __init__(self, driver: DriverClient, command: Command, plan: Plan, hooks: ExecutionHooks) -> None:
        self.driver = driver
        self.command = command
        self.plan = plan
        self.hooks = hooks
        self.results: list[ActionResult] = []
        self.verdict: Verdict | None = None
        self.first_motion_s: float | None = None
        self.mandate: Mandate | None = None
        self.lease = ""
        self.stopped_by = ""
        self.status, self.message, self.fault = CommandState.FAILED, "", ""
        self.started_s = time.monotonic()

    async def steps(self) -> CommandState:
        """Do the steps; return the command's final state."""
        for number, step in enumerate(self.plan.steps):
            for _ in range(ROOM_TRIES):
                await self.wait_for_room(self.plan.steps[number:])
                if (status := await self._may(step)) is not None:
                    return status
                self.hooks.on_step(step, number)
                result = await self._step(step)
                if result.outcome is not Outcome.REFUSED or result.reason not in ROOM_TAKEN:
                    break
                self.results.remove(result)  # another robot took the room first: nothing moved, and it waits again
            else:
                self.results.append(result)
            if not result.ok:
                if result.reason in BY_PEOPLE:
                    await self._ask_who()
                return self._status_of(result)
        return CommandState.DONE

    async def wait_for_room(self, steps: Sequence[Primitive]) -> None:
        """Wait for the shared room; the time does not count as the command's."""
        began_s = time.monotonic()
        await self.hooks.enter_room(steps)
        self.started_s += time.monotonic() - began_s

    async def _may(self, step: Primitive) -> CommandState | None:
        """Return None if the step may begin now, else the final state of the command."""
        if step.moves or not self.results:
            self.verdict, capabilities = await self.hooks.permit(self.plan)
            if self.verdict.decision is not Decision.ALLOW or capabilities is None:
                return self._status_of_verdict(self.verdict)
            self.mandate = self.mandate or mandate_of(self.plan, capabilities)
        assert self.mandate is not None
        if (beyond := mandate_violation(self.mandate, self.results, step)) is not None:
            self._refused(step, "mandate", beyond)
            return CommandState.REFUSED
        if step.moves and not await self.hooks.alive():
            self._refused(step, SILENT, "The forum does not answer, so nobody could stop me.")
            return CommandState.INTERRUPTED
        # There is no await between this check and the step, so an end that came earlier is never missed.
        return why.state_in_motion if (why := self.hooks.ended()) else None

    def _refused(self, step: Primitive, reason: str, message: str) -> None:
        now_s = time.monotonic()
        self.results.append(
            ActionResult(step, Outcome.REFUSED, reason=reason, message=message, started_s=now_s, ended_s=now_s)
        )

    async def _step(self, step: Primitive) -> ActionResult:
        """Do a step and store its result at once."""
        sent_s = time.monotonic()
        deadline_s = min(self.hooks.step_s, max(0.1, self.left_s()))
        stepping = asyncio.create_task(self.driver.step(self.lease, step, deadline_s))
        ended_by = ""
        try:
            while not stepping.done():
                await asyncio.wait({stepping}, timeout=LOOK_S)
                if (
                    not ended_by
                    and not stepping.done()
                    and (ended_by := self._must_end(step))
                    and ended_by != EndReason.STOP
                ):
                    await self._stop(ended_by)
        except Exception:  # the step is no longer supervised, so stop it; the driver reports how far it went
            _log.error("step ended by a fault of the agent", trace=traceback.format_exc())
            ended_by = self.fault = INTERNAL
            await self._stop(INTERNAL)
            await asyncio.wait({stepping}, timeout=TELL_S)
        finally:
            if not stepping.done():
                stepping.cancel()
                await asyncio.shield(self._stop(EndReason.SHUTDOWN))
                await asyncio.wait({stepping})
        result = _outcome(stepping, step, sent_s)
        stopped_by_us = ended_by and result.outcome in (Outcome.STOPPED, Outcome.INTERRUPTED)
        if stopped_by_us and (result.reason in BY_PEOPLE or result.reason == LAPSED):  # after a stop, the lease lapses
            result = replace(result, reason=ended_by)
        self.results.append(result)
        if step.moves and self.first_motion_s is None and result.outcome is not Outcome.REFUSED:
            self.first_motion_s = result.started_s if sent_s <= result.started_s <= time.monotonic() else sent_s
        return result

    def left_s(self) -> float:
        """Seconds that the next step may take."""
        assert self.mandate is not None
        return self.mandate.seconds - (time.monotonic() - self.started_s)

    async def _ask_who(self) -> None:
        """Ask the driver who stopped the robot: the forum may not know."""
        with contextlib.suppress(RobotError):
            if (lost := await self.driver.lost(self.lease)) is not None:
                self.stopped_by = lost.by

    def _must_end(self, step: Primitive) -> str:
        if why := self.hooks.ended():
            return why
        return SILENT if step.moves and self.hooks.silent() else ""

    async def _stop(self, why: str) -> None:
        try:
            await self.hooks.stop(why)
        except RobotError:
            pass  # the lease lapses, and then the driver stops the robot
        except Exception:
            _log.error("stop failed", trace=traceback.format_exc())

    def _status_of_verdict(self, verdict: Verdict) -> CommandState:
        """Return the final state of a command that may not begin its next step.

        If the forum did not answer, a command that has moved the robot is interrupted.
        """
        if verdict.rule == UNVERIFIED and any(result.moved for result in self.results):
            return CommandState.INTERRUPTED
        return CommandState.CANCELLED if verdict.rule.startswith("command.") else CommandState.REFUSED

    def _status_of(self, result: ActionResult) -> CommandState:
        if result.outcome in (Outcome.STOPPED, Outcome.INTERRUPTED):
            if result.reason in BY_PEOPLE:
                return CommandState.STOPPED
            return CommandState.INTERRUPTED if result.reason in _BY_US else CommandState.FAILED
        if result.reason == UNREACHABLE:
            return CommandState.INTERRUPTED  # it began, and how far it went is unknown
        if result.outcome is Outcome.REFUSED and len(self.results) == 1:
            return CommandState.REFUSED
        return CommandState.FAILED

    def _status_of_lost_lease(self, lost: LeaseLost) -> tuple[CommandState, str]:
        """Return the final state and the message of a command whose lease was lost between two steps."""
        if lost.why in BY_PEOPLE:
            return CommandState.STOPPED, ""
        # A stop through this agent ends the renewals first, so the lease may be lost before the driver has the stop.
        if lost.why == LAPSED and (why := self.hooks.ended()):
            return why.state_in_motion, ""
        if lost.why == EndReason.RELEASE and not self.results:  # accepted before the release at the robot
            return CommandState.CANCELLED, str(lost)
        return CommandState.INTERRUPTED if lost.why in _BY_US else CommandState.FAILED, str(lost)

    async def run_with_lease(self, work: Callable[[], Awaitable[CommandState]]) -> Execution:
        """Do `work`, which returns the command's final state, while holding the robot's lease.

        Raises nothing but a cancellation: an unusable robot or an error in the agent is a result.
        """
        self.hooks.on_run(self)
        try:
            async with contextlib.AsyncExitStack() as stack:
                await take_lease(stack, self)
                self.status = await work()
        except LeaseLost as e:  # a stop came after the command was accepted, perhaps not through the forum
            self.stopped_by = e.by
            self.status, self.message = self._status_of_lost_lease(e)
        except RobotError as e:
            self.message = str(e)
        except Exception:
            _log.error("command failed", trace=traceback.format_exc())
            self.fault = INTERNAL
        return self.execution()

    def execution(self) -> Execution:
        """The result so far; steps without a result have not begun."""
        rest = self.plan.steps[len(self.results) :]
        skipped = (ActionResult(step, Outcome.SKIPPED) for step in rest)
        return Execution(
            self.status, (*self.results, *skipped), self.verdict, self.message, self.first_motion_s,
            stopped_by=self.stopped_by, fault=self.fault,
        )  # fmt: skip


async def execute(driver: DriverClient, command: Command, plan: Plan, hooks: ExecutionHooks) -> Execution:
    """Hold the robot's lease for the whole command and do its steps until one does not succeed. Raises nothing but a
    cancellation (see `Run.run_with_lease`)."""
    run = Run(driver, command, plan, hooks)
    return await run.run_with_lease(run.steps)


def holder_of(trace_id: str) -> str:
    """Return the holder's name for the lease of a command."""
    return f"agent {trace_id}"


async def take_lease(stack: contextlib.AsyncExitStack, run: Run) -> None:
    """Take the robot's lease, with retries: the lease of a killed agent takes a moment to expire."""
    until_s = time.monotonic() + BUSY_S
    while run.hooks.ended() is None:
        try:
            lease = run.driver.lease(holder_of(run.command.trace_id), await run.hooks.since())
            run.lease = await stack.enter_async_context(lease)
            return
        except RobotBusy:
            if time.monotonic() >= until_s:
                raise
            await asyncio.sleep(LOOK_S)


def _outcome(stepping: asyncio.Task[ActionResult], step: Primitive, sent_s: float) -> ActionResult:
    """Return the driver's result of a step, or an unknown result if the driver gave none."""
    try:
        return stepping.result()
    except LeaseLost as e:
        reason, outcome, text = e.why, Outcome.STOPPED, str(e)
    except RobotError as e:
        reason, outcome, text = UNREACHABLE, Outcome.UNKNOWN, str(e)
    except asyncio.CancelledError:  # the wait of `TELL_S` is over
        reason, outcome, text = UNREACHABLE, Outcome.UNKNOWN, "The driver did not say how far the step went."
    except Exception as e:  # it was sent, whatever the answer was
        reason, outcome, text = UNREACHABLE, Outcome.UNKNOWN, f"The driver's answer cannot be read ({e!r})."
    return ActionResult(step, outcome, reason=reason, message=text, started_s=sent_s, ended_s=time.monotonic())


def decisive(execution: Execution, verdict: Verdict) -> Verdict:
    """Return the verdict for the report: the guard's if it refused a step that the screen allowed."""
    last = execution.verdict or verdict
    refused = next((r for r in execution.results if r.outcome is Outcome.REFUSED), None)
    if execution.status is CommandState.REFUSED and last.decision is Decision.ALLOW and refused is not None:
        return Verdict(Decision.REFUSE, f"guard.{refused.reason}")
    return last
