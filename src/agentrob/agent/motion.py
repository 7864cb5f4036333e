"""The motion of one command: execute its plan or pursue its goal, at most once, and keep what was measured."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from functools import partial

from pydantic import TypeAdapter

from agentrob.agent.execution.execute import Execution, ExecutionHooks, execute
from agentrob.agent.execution.local_goal import run_local_task
from agentrob.agent.execution.room_entry import RoomEntry
from agentrob.agent.execution.visual import run_visual_task
from agentrob.agent.intake.authorization import CommandTerms, own_rights, permission
from agentrob.agent.intake.event_stream import EventStream
from agentrob.agent.media.poses import PoseSampler
from agentrob.agent.media.recorder import Recorder
from agentrob.agent.queue.queue import QueuedCommand
from agentrob.agent.stop.replies import StopReplies
from agentrob.agent.store.journal import NotBegun
from agentrob.agent.store.records import Records
from agentrob.agent.understanding.surroundings import Surroundings
from agentrob.agent.understanding.understand import Assessor
from agentrob.agent.understanding.visual_goal import local_task_of, visual_task_of
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumDenied, ForumError, ForumNotFound
from agentrob.forums.protocol import Forum
from agentrob.language.messages.catalog import say
from agentrob.minds.visual_loop.pursuit import without_model
from agentrob.model import Capabilities, CommandState, Decision, EndReason, Hindrance, Plan, Primitive, Verdict
from agentrob.robots.driver.client import DriverClient

#: A motion in the journal, as JSON.
EXECUTION = TypeAdapter(Execution)
#: How long a command waits between its steps for another robot of its room.
ROOM_S = 120.0
#: How often the post of a command that moves is read again, where a step may last longer than this. So many denials
#: without an answer in between end the command: one may be temporary.
READ_AGAIN_S, MOST_DENIALS = 5.0, 2


@dataclass(frozen=True)
class Motion:
    """Moves one robot for its commands. `assessor` knows the model that may steer by the camera, `on_motion` is called
    when a motion begins. While `ending` returns true no step begins."""

    name: str
    settings: RobotConfig
    forum: Forum
    driver: DriverClient
    event_stream: EventStream
    stops: StopReplies
    records: Records
    recorder: Recorder
    poses: PoseSampler
    surroundings: Surroundings
    assessor: Assessor
    room: RoomEntry
    ending: Callable[[], bool]
    on_motion: Callable[[], None]

    @property
    def terms(self) -> CommandTerms:
        """The terms by which commands are judged now."""
        names = tuple(self.assessor.names)
        return CommandTerms(
            self.settings.consents, self.event_stream.step_s, robot=self.name, scene=self.surroundings.scene,
            names=names, boards=tuple(self.settings.boards), rights=own_rights(self.settings),
        )  # fmt: skip

    def read(self, text: str) -> Execution:
        """The result of a motion from the journal, with its pictures as far as the files exist."""
        execution = EXECUTION.validate_json(text)
        results = self.records.with_pictures(execution.results, execution.pictures)
        return replace(execution, results=results)

    async def run(
        self,
        job: QueuedCommand,
        plan: Plan,
        terms: CommandTerms,
        on_step: Callable[[Primitive, int], None],
        on_wait: Callable[[Hindrance], None] = lambda _: None,
    ) -> str:
        """Do the motion; called at most once ever for a post. Returns the result as the journal keeps it. `on_step` is
        called with each step and its number before it begins, `on_wait` when it waits for another robot of its room.
        Raises `NotBegun` if the agent is being ended."""
        if self.ending():
            raise NotBegun
        job.moving, job.begun_s = True, time.monotonic()
        self.on_motion()
        known = job.assessment is not None and job.assessment.goal is not None
        terms = replace(terms, known=known, approval=job.decided)

        def begin_step(step: Primitive, number: int) -> None:
            self.poses.begin_step(step)
            on_step(step, number)

        def ended() -> EndReason | None:
            return job.ended or (EndReason.SHUTDOWN if self.ending() else None)

        async def enter_room(steps: Sequence[Primitive]) -> None:
            await self.room.enter(steps, on_wait, ended, ROOM_S)

        hooks = ExecutionHooks(
            since=lambda: self.stops.since(job.accepted_s - job.waited_s),
            permit=partial(self._permitted, job, terms),
            ended=ended,
            alive=self.event_stream.prove,
            silent=lambda: self.event_stream.silent,
            stop=self.stops.stop_running,
            on_step=begin_step,
            step_s=self.event_stream.step_s,
            enter_room=enter_room,
            on_run=partial(setattr, job, "run"),
        )
        reading = asyncio.create_task(self._end_when_unreachable(job))
        try:
            key = job.command.key
            with self.event_stream, self.recorder.filming(key), self.poses.recording(key, plan.steps):
                execution = await self._execute_plan(job, plan, hooks)
        finally:
            reading.cancel()
            job.moving = False
        with job.log_errors("poses not written"):
            await self.poses.written()
        return self._encode_result(job, execution)

    async def _end_when_unreachable(self, job: QueuedCommand) -> None:
        """End a command whose post was removed, is in another thread now, or can no longer be read, for instance
        because its topic was moved: a stop in its thread would not be received (law 13). Where steps are short, the
        check before each is enough."""
        denials = 0
        while self.event_stream.step_s > READ_AGAIN_S and job.ended is None:
            await asyncio.sleep(READ_AGAIN_S)
            try:
                post, denials = await self.forum.post(job.command.post_id), 0
                moved = EndReason.THREAD if post.topic_id != job.command.topic_id else None
                why = EndReason.REMOVED if post.removed else moved
            except ForumNotFound:
                why = EndReason.REMOVED
            except ForumDenied:
                denials += 1
                why = EndReason.REMOVED if denials >= MOST_DENIALS else None
            except ForumError:  # law 16 stops a robot whose forum is silent
                continue
            if why is not None and job.ended is None:
                job.end(why)

    async def _permitted(
        self, job: QueuedCommand, terms: CommandTerms, plan: Plan
    ) -> tuple[Verdict, Capabilities | None]:
        """Whether it may move now. Refused too if another agent of this account has posted its end meanwhile."""
        asked = permission(self.forum, self.driver, job.command, terms, plan)
        (verdict, capabilities), has_ended = await asyncio.gather(asked, job.status.has_ended())
        if has_ended:
            reason = say("agent.because.answered", job.command.language)
            return Verdict(Decision.REFUSE, "command.answered", reason), None
        return verdict, capabilities

    def _encode_result(self, job: QueuedCommand, execution: Execution) -> str:
        """The result of a motion as the journal keeps it. If this fails, the measurements are in
        `QueuedCommand.run`."""
        with job.log_errors("surroundings not brought up to date"):
            self.surroundings.after(execution.results, execution.looked)
        with job.log_errors("times not noted"):
            now, now_s = self.event_stream.now(), time.monotonic()
            if execution.first_motion_s is not None:
                job.note("first_motion", now - timedelta(seconds=now_s - execution.first_motion_s))
            ended_s = max((r.ended_s for r in execution.results if r.ended_s <= now_s), default=now_s)
            job.note("done", now - timedelta(seconds=now_s - (ended_s or now_s)))
        results = tuple(replace(r, image=None) for r in execution.results)
        pictures = ("",) * len(results)
        with job.log_errors("pictures not stored"):
            results, pictures = self.records.keep_pictures(job.command.key, execution.results)
        return EXECUTION.dump_json(replace(execution, results=results, pictures=pictures)).decode()

    async def _execute_plan(self, job: QueuedCommand, plan: Plan, hooks: ExecutionHooks) -> Execution:
        """Execute the plan, or pursue the goal, by a model or without one."""
        assessment, assessor = job.assessment, self.assessor
        if assessment is None or assessment.goal is None:
            return await execute(self.driver, job.command, plan, hooks)
        capabilities, seeing = await self.driver.capabilities(), assessor.vision_model
        if not assessor.by_model(assessment.goal, capabilities):
            if not without_model(assessment.goal, capabilities, assessor.detector):
                return Execution(CommandState.FAILED, message="no model with images is configured any more")
            task = local_task_of(assessment.goal, assessor.detector, capabilities, self.settings.eyes.fov_deg)
            return await run_local_task(self.driver, job.command, task, hooks)
        assert seeing is not None
        language = job.command.language
        visual_task = visual_task_of(
            assessment.goal, seeing, capabilities, self.settings.look, language, assessment.usage
        )
        return await run_visual_task(self.driver, job.command, visual_task, hooks)
