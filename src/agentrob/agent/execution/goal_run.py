"""Pursue a screened goal step by step through the robot's driver; each step is judged before it moves anything.

Every step is judged again: the mandate, the post, its author's rights, the limits, the stop channel, the lease and, in
the driver's process, the guard.
"""

from __future__ import annotations

from agentrob.agent.execution.execute import BY_PEOPLE, SILENT, ExecutionHooks, Run
from agentrob.minds.visual_loop.loop import StepAttempt
from agentrob.model import ActionResult, Command, CommandState, Decision, Mandate, Outcome, Plan, Primitive
from agentrob.robots.driver.client import DriverClient
from agentrob.screening.mandate import mandate_violation

#: Reasons after which another step may be tried; any other reason ends the command.
_GOES_ON = frozenset({"", "obstacle", "fence", "deadline", "stalled", "invalid", "unsupported", "ranges_unknown"})
#: Rules that refuse a step and not the command.
_OF_A_STEP = ("limit.", "plan.", "ops.", "consent.", "scene.")


class CommandEnded(Exception):
    """The command must end now; `status` is its final state."""

    def __init__(self, status: CommandState) -> None:
        super().__init__(status)
        self.status = status


class GoalRun(Run):
    """One pursuit of a goal in progress, within a mandate that was fixed before its first step."""

    def __init__(self, driver: DriverClient, command: Command, mandate: Mandate, hooks: ExecutionHooks) -> None:
        super().__init__(driver, command, Plan(), hooks)
        self.mandate: Mandate = mandate

    async def act(self, step: Primitive) -> StepAttempt:
        """Execute a step if permitted; raises `CommandEnded` if the whole command must end."""
        await self.wait_for_room([step])
        if (problem := await self._problem(step)) is not None:
            return StepAttempt(None, problem)
        self.hooks.on_step(step, len(self.results))
        result = await self._step(step)
        self._settled(result)
        if result.reason in BY_PEOPLE:
            await self._ask_who()
        goes_on = result.reason in _GOES_ON or result.reason.startswith("limit_")
        if result.outcome is Outcome.UNKNOWN or not (result.ok or goes_on):
            raise CommandEnded(self._status_of(result))
        return StepAttempt(result)

    def _settled(self, result: ActionResult) -> None:
        """Called with the result of each step, before it is judged."""

    async def _problem(self, step: Primitive) -> str | None:
        """Return None if the step may begin now, else the reason. Raises `CommandEnded` if no step may begin."""
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
