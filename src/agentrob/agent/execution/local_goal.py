"""Reach a goal without a model: go home by odometry, or look with a detector and turn towards what was found.

The steps are ordinary ones, decided on the way within the mandate (see `goal_run`).
The report says in sentences what was found.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass, replace

import structlog

from agentrob.agent.execution.execute import Execution, ExecutionHooks
from agentrob.agent.execution.goal_run import CommandEnded, GoalRun
from agentrob.agent.execution.way_home import from_home, way_home
from agentrob.eyes.protocol import Detector
from agentrob.eyes.sight import Seen, marked, seen_in
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.language.messages.catalog import say
from agentrob.minds.visual_loop.seen_text import colours_text, mark_text, seen_text, thing_text
from agentrob.model import (
    PHOTO,
    Capabilities,
    Command,
    CommandState,
    Decision,
    Direction,
    Mandate,
    Op,
    Plan,
    Pose,
    Primitive,
    Verdict,
)
from agentrob.model.estimate import seconds_of
from agentrob.robots.driver.client import DriverClient

#: So near to straight ahead a turn towards a thing ends, and after so many turns in any case; then it has failed if the
#: thing is farther aside than the second.
FACED_DEG, MISSED_DEG, MOST_TURNS = 4.0, 10.0, 4
#: A look around turns so far after each picture; with the field of view that covers a full turn.
AROUND_DEG, FULL_TURN_DEG = 45.0, 360.0
#: The way home is corrected once if it ends farther away than this, and has failed beyond the second.
CORRECTED_M, FAILED_M = 0.15, 0.5
#: How long a detector may look at one picture.
LOOK_LIMIT_S = 10.0
_PICTURE = Primitive(PHOTO)
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class LocalTask:
    """A goal, what it may use up, and the detector that looks. `fov_deg` is the camera's vertical field of view."""

    goal: Goal
    mandate: Mandate
    capabilities: Capabilities
    detector: Detector | None
    fov_deg: float


class LocalGoalRun(GoalRun):
    """One pursuit of such a goal. `findings` are sentences in the language of the post."""

    def __init__(self, driver: DriverClient, command: Command, task: LocalTask, hooks: ExecutionHooks) -> None:
        super().__init__(driver, command, task.mandate, hooks)
        self.task = task
        self.findings: list[str] = []
        self._looked_at: int | None = None

    async def reached(self) -> CommandState:
        """Pursue all parts of the goal; return the command's final state."""
        try:
            for part in self.task.goal.tasks:
                self._looked_at = None
                await self._pursue(part)
        except CommandEnded as e:
            return e.status
        return CommandState.DONE

    async def _pursue(self, part: Subgoal) -> None:
        match part.aim:
            case Aim.STEP if part.step is not None:
                await self._do(part.step)
            case Aim.HOME:
                await self._go_home()
            case Aim.FACE | Aim.FIND:
                await self._face(part)
            case Aim.SEE:
                await self._see(part)
            case Aim.COLOURS:
                seen = await self._look()
                self.findings.append(colours_text(seen, self.command.language))
                await self._mark(seen)
            case _:
                raise ValueError(f"{part.aim} needs a model")

    async def _do(self, step: Primitive) -> None:
        """Execute a step; raises `CommandEnded` unless it was done."""
        attempt = await self.act(step)
        if attempt.result is None:
            self._refused(step, "mandate", attempt.problem)
            raise CommandEnded(CommandState.FAILED if len(self.results) > 1 else CommandState.REFUSED)
        if not attempt.result.ok:
            raise CommandEnded(self._status_of(attempt.result))

    def _fail(self, key: str, **values: object) -> CommandEnded:
        self.findings.append(say(key, self.command.language, **values))
        return CommandEnded(CommandState.FAILED)

    # ------------------------------------------------------------ home
    async def _go_home(self) -> None:
        """Walk home by odometry, and correct the way once."""
        await self._walk_home(await self._pose())
        pose = await self._pose()
        if from_home(pose)[0] > CORRECTED_M:
            await self._walk_home(pose)
            pose = await self._pose()
        metres, degrees = from_home(pose)
        if metres > FAILED_M:
            raise self._fail("home.missed", metres=f"{metres:.2f}")
        self.findings.append(say("home.reached", self.command.language, metres=metres, degrees=abs(degrees)))

    async def _walk_home(self, pose: Pose) -> None:
        steps = way_home(pose, self.task.capabilities)
        if steps:
            verdict, _ = await self.hooks.permit(Plan(tuple(steps)))
            if verdict.decision is not Decision.ALLOW:
                self.verdict = verdict
                raise CommandEnded(self._status_of_verdict(verdict))
        for step in steps:
            await self._do(step)

    async def _pose(self) -> Pose:
        """Return where the robot is in the frame of its home; ends the command if nobody knows."""
        pose = (await self.driver.posture(joints=False)).pose
        if pose is None:
            reason = say("agent.reason.not_homed", self.command.language)
            self.verdict = Verdict(Decision.REFUSE, "guard.not_homed", reason)
            raise CommandEnded(self._status_of_verdict(self.verdict))
        return pose

    # ------------------------------------------------------------ eyes
    async def _see(self, part: Subgoal) -> None:
        seen = await self._look()
        found = matching(part, seen)
        language = self.command.language
        if found is None:
            self.findings.append(say("eyes.not_seen", language, thing=thing_text(part.thing, part.colour, language)))
            return
        self.findings.append(say("eyes.seen", language, thing=seen_text(found, language)))
        await self._mark([found])

    async def _face(self, part: Subgoal) -> None:
        """Turn towards a thing, look again, and say its measured angle."""
        language, found = self.command.language, matching(part, await self._look())
        if found is None:
            found = await self._search(part)
        for _ in range(MOST_TURNS):
            if abs(found.left_deg) <= FACED_DEG:
                break
            await self._do(_turn(found.left_deg))
            again = matching(part, await self._look())
            if again is None:
                raise self._fail("eyes.lost", thing=thing_text(part.thing, part.colour, language))
            found = again
        await self._mark([found])
        if abs(found.left_deg) > MISSED_DEG:
            raise self._fail("eyes.not_faced", thing=seen_text(found, language))
        side = "left" if found.left_deg >= 0 else "right"
        thing = thing_text(found.thing, found.colour, language)
        self.findings.append(say(f"eyes.faced.{side}", language, thing=thing, degrees=abs(found.left_deg)))

    async def _search(self, part: Subgoal) -> Seen:
        """Look around in steps, if a full turn is within the limits; raises `CommandEnded` if nothing is found."""
        thing = thing_text(part.thing, part.colour, self.command.language)
        turn = _turn(AROUND_DEG)
        around = [turn, _PICTURE] * (round(FULL_TURN_DEG / AROUND_DEG) - 1)
        if not self._has_left(around):
            raise self._fail("eyes.not_ahead", thing=thing, degrees=f"{FULL_TURN_DEG:g}")
        for step in around:
            if step.moves:
                await self._do(step)
            elif (found := matching(part, await self._look())) is not None:
                return found
        raise self._fail("eyes.not_around", thing=thing)

    def _has_left(self, steps: Sequence[Primitive]) -> bool:
        """Return whether the mandate has room for these steps and a last turn, and time for them."""
        motions = sum(r.primitive.moves for r in self.results) + sum(step.moves for step in steps) + 1
        enough = self.mandate.motions is None or motions <= self.mandate.motions
        return enough and seconds_of(Plan(tuple(steps)), self.task.capabilities) <= self.left_s()

    async def _look(self) -> tuple[Seen, ...]:
        """Take a picture and return what the detector finds in it. Only the newest picture of a part is kept."""
        if self._looked_at is not None:
            self.results[self._looked_at] = replace(self.results[self._looked_at], image=None)
        await self._do(_PICTURE)
        self._looked_at = len(self.results) - 1
        jpeg, detector = self.results[self._looked_at].image, self.task.detector
        if not jpeg or detector is None:
            raise self._fail("eyes.no_picture")
        try:
            async with asyncio.timeout(LOOK_LIMIT_S):
                return await asyncio.to_thread(seen_in, jpeg, detector, self.task.fov_deg)
        except Exception as e:  # an owner's detector runs here
            _log.warning("detector failed", error=str(e) or type(e).__name__)
            raise self._fail("eyes.failed", error=type(e).__name__) from e

    async def _mark(self, seen: Sequence[Seen]) -> None:
        """Draw what was found into the newest picture."""
        at = self._looked_at
        if at is None or not seen or not (jpeg := self.results[at].image):
            return
        try:
            labels = [(one, mark_text(one)) for one in seen]
            self.results[at] = replace(self.results[at], image=await asyncio.to_thread(marked, jpeg, labels))
        except (OSError, ValueError) as e:  # the sentence says it all the same
            _log.warning("picture not marked", error=str(e))

    def execution(self) -> Execution:
        return replace(super().execution(), findings=tuple(self.findings))


def matching(part: Subgoal, seen: Sequence[Seen]) -> Seen | None:
    """Return the surest detection of what a part of a goal names; one of unclear shape if there is no other."""
    coloured = [one for one in seen if not part.colour or one.colour == part.colour]
    exact = (one for one in coloured if one.thing == part.thing)
    return next(exact, None) or next((one for one in coloured if part.colour and not one.thing), None)


def _turn(left_deg: float) -> Primitive:
    side = Direction.LEFT if left_deg > 0 else Direction.RIGHT
    return Primitive(Op.TURN, side, degrees=round(abs(left_deg), 1))


async def run_local_task(driver: DriverClient, command: Command, task: LocalTask, hooks: ExecutionHooks) -> Execution:
    """Hold the robot's lease while a goal is pursued without a model. Raises nothing but a cancellation."""
    run = LocalGoalRun(driver, command, task, hooks)
    return await run.run_with_lease(run.reached)
