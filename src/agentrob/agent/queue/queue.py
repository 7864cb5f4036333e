"""The queue of one robot: commands wait in the order of acceptance, and one runs at a time."""

from __future__ import annotations

import asyncio
import contextlib
import time
import traceback
from collections.abc import Callable, Coroutine, Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import cached_property
from typing import Any, TypeVar

import structlog

from agentrob.agent.execution.execute import Run
from agentrob.agent.store.rows import ApprovalDecision, ApprovalRequest
from agentrob.agent.understanding.extract import Assessment
from agentrob.config.robots import RobotConfig
from agentrob.language.joint.parts import JointCommand
from agentrob.language.joint.reading import joint_command
from agentrob.minds.visual_loop.loop import LoopRecord
from agentrob.minds.visual_loop.pursuit import in_words
from agentrob.model import Command, EndReason, StopResult
from agentrob.rehearsal.preview import Preview

#: No run of a schedule begins later than this after its time.
LATE_S = 300.0
T = TypeVar("T")
_log = structlog.get_logger()


def expiry_s(command: Command, settings: RobotConfig) -> float:
    """Return how long after its post, or after the time of its run, a command may begin."""
    return settings.queue_expiry_s if command.run is None else min(settings.queue_expiry_s, LATE_S)


@dataclass(frozen=True, slots=True)
class ShownPreview:
    """A preview beside the question for an approval: since when it is there, by the forum's clock, and the number of
    pictures that the status post has by it."""

    at: datetime
    pictures: int


@dataclass(eq=False)
class QueuedCommand:
    """One command in progress, from its claim to its final reply.

    `known`: an earlier process claimed it, `waited_s` seconds before `accepted_s` (monotonic). `begun`: its motion
    began in that process, so only its report is left to write, and it cannot be ended. `ended` is the reason why it may
    not continue. `admitted`: it has passed its account's rate limit. Other commands pass it until it is `ready` (read
    and judged) and while it is `held`. `asked` is its approval request with the decision, if it needs one. `stop`
    returns the result of the stop that ended it, `stopped_by` names who stopped it, and `cancelled_earlier` counts the
    commands that it cancelled. `assessment` is how it was understood, `looked` the visual loop of a model that steered.
    `takes_s` is its estimated duration, None while that is not known; `begun_s` (monotonic) when it began to move.
    `preview` is what was found when it was rehearsed, `shown` since when that is beside its question, `recalled`
    whether what an earlier process showed was looked for, and `asking` the task that writes the question.
    `run` is its execution in this process with the results so far, `status` its status post, `task` the task that
    processes it. `waits_for_others`: it is a part of a post that waits for other parts; `fresh_s` (monotonic) is then
    when that wait ended, from which on it counts as queued. `left_to` is the robot that does it instead, and `because`
    why it was ended, in a sentence, where `ended` alone does not say it.
    """

    command: Command
    known: bool = False
    begun: bool = False
    accepted_s: float = field(default_factory=time.monotonic)
    waited_s: float = 0.0
    ended: EndReason | None = None
    admitted: bool = False
    held: bool = False
    asked: ApprovalRequest | None = None
    ready: bool = False
    moving: bool = False
    stopped_by: str = ""
    cancelled_earlier: int = 0
    stop: asyncio.Task[StopResult | None] | None = None
    timings_ms: dict[str, float] = field(default_factory=dict)
    assessment: Assessment | None = None
    looked: LoopRecord | None = None
    takes_s: float | None = None
    begun_s: float | None = None
    preview: Preview | None = None
    shown: ShownPreview | None = None
    recalled: bool = False
    asking: asyncio.Task[None] | None = None
    run: Run | None = None
    status: Any = None
    task: asyncio.Task[None] | None = None
    waits_for_others: bool = False
    fresh_s: float | None = None
    left_to: str = ""
    because: str = ""
    _changed: asyncio.Event = field(default_factory=asyncio.Event)

    def note(self, name: str, at: datetime) -> None:
        """Record the first time that something happened, in milliseconds after the post."""
        self.timings_ms.setdefault(name, max(0.0, (at - self.command.posted_at).total_seconds() * 1000))

    @property
    def motion_ended(self) -> bool:
        """Whether its motion has ended in this process, so that only its report is left to write."""
        return self.begun_s is not None and not self.moving

    @property
    def can_end(self) -> bool:
        """Whether it may still be ended: not what was ended before, and nothing whose motion is over."""
        return self.ended is None and not self.begun and not self.motion_ended

    @property
    def left_s(self) -> float | None:
        """Return about how long it still takes once it is its turn; None if that is not known."""
        if self.takes_s is None:
            return None
        return max(0.0, self.takes_s - (time.monotonic() - self.begun_s if self.begun_s is not None else 0.0))

    @cached_property
    def joint(self) -> JointCommand | None:
        """Return the parts of its post, if it is one of several."""
        found = joint_command(self.command.text) if self.command.part else None
        return found if isinstance(found, JointCommand) else None

    @property
    def queued_s(self) -> float:
        """Return the time since which it counts as queued, in seconds of the monotonic clock."""
        return self.accepted_s - self.waited_s if self.fresh_s is None else self.fresh_s

    @property
    def decided(self) -> ApprovalDecision | None:
        """Return the decision on its approval, if there is one."""
        return self.asked.decided if self.asked is not None else None

    @property
    def only_waits(self) -> bool:
        """Return whether it waits for an approval and nothing else: that is asked for, and its preview shown."""
        waits = self.held and self.asked is not None and self.decided is None
        return waits and (self.asking is None or self.asking.done())

    @property
    def goal_text(self) -> str:
        """Return the visual goal in our words; empty for a plan."""
        goal = self.assessment.goal if self.assessment is not None else None
        return in_words(goal, self.command.language) if goal is not None else ""

    @property
    def page(self) -> str:
        """Return the post that has the command's page, empty if there is none yet."""
        return page_post(self.command, self.status.post_id if self.status is not None else None)

    @contextlib.contextmanager
    def log_errors(self, problem: str) -> Iterator[None]:
        """Log an error in work that accompanies its motion or report, and continue without the result."""
        try:
            yield
        except Exception:
            _log.error(problem, post=self.command.post_id, trace=traceback.format_exc())

    def decide(self, decided: ApprovalDecision) -> None:
        """Record the decision on its approval."""
        assert self.asked is not None
        self.asked = replace(self.asked, decided=decided)
        self._changed.set()

    def notify(self) -> None:
        """Wake the tasks that wait for a change of this command."""
        self._changed.set()

    def end(self, why: EndReason) -> None:
        """End it; the first reason is kept."""
        if self.can_end:
            self.ended = why
        self._changed.set()

    async def unless_ended(self, work: Coroutine[Any, Any, T]) -> T | None:
        """Return the result of `work`; cancel it and return None if the command is ended first (law 14)."""
        if self.ended is not None:
            work.close()
            return None
        doing, ended = asyncio.ensure_future(work), asyncio.ensure_future(self._until_ended())
        try:
            await asyncio.wait({doing, ended}, return_when=asyncio.FIRST_COMPLETED)
            return doing.result() if doing.done() else None
        finally:
            doing.cancel()
            ended.cancel()

    async def _until_ended(self) -> None:
        while self.ended is None:
            self._changed.clear()
            await self._changed.wait()


def page_post(command: Command, status_post: str | None) -> str:
    """Return the post that has a command's page, record and replay, empty if there is none: its own one, and for a run
    of a schedule or a further part that of the report, since a post has one page."""
    return command.post_id if command.run is None and not command.further else status_post or ""


class CommandQueue:
    """The commands that wait or run. `on_change` is called when one is added, removed or moves up."""

    def __init__(self, on_change: Callable[[], None] = lambda: None) -> None:
        self._jobs: list[QueuedCommand] = []
        self._turn: QueuedCommand | None = None
        self._closed = False
        self._on_change = on_change

    def __len__(self) -> int:
        return len(self._jobs)

    def __iter__(self) -> Iterator[QueuedCommand]:
        return iter(tuple(self._jobs))

    @property
    def posts(self) -> list[str]:
        """Return the posts of all commands in progress, the next one first and held ones last."""
        return [job.command.post_id for job in sorted(self._jobs, key=lambda job: job.held)]

    @property
    def moving(self) -> QueuedCommand | None:
        """Return the command that moves the robot now."""
        return next((job for job in self._jobs if job.moving), None)

    @property
    def current(self) -> QueuedCommand | None:
        """Return the command whose turn it is: it moves the robot, or is about to."""
        return self._turn

    def find(self, post_id: str) -> QueuedCommand | None:
        return next((job for job in self._jobs if job.command.post_id == post_id), None)

    def asking(self) -> set[asyncio.Task[Any]]:
        """Return the tasks of the commands that only wait: for an approval, or for other parts of their posts."""
        return {job.task for job in self._jobs if job.task and (job.waits_for_others or job.only_waits)}

    def ahead(self, job: QueuedCommand) -> list[QueuedCommand]:
        """Return the commands ahead of it, the one that is done directly before it last; none if it is next."""
        before = [other for other in self._jobs[: self._jobs.index(job)] if other.ready and not other.held]
        turn = self._turn
        return before if turn is None or turn is job or turn in before else [turn, *before]

    def place(self, job: QueuedCommand) -> int:
        """Return how many commands are ahead of it; 0 if it is next."""
        return len(self.ahead(job))

    def of_same_author(self, before: QueuedCommand) -> list[QueuedCommand]:
        """Return the earlier commands of its account that are still in progress."""
        author = before.command.author.id
        return [job for job in self._jobs[: self._jobs.index(before)] if job.command.author.id == author]

    def number_of(self, account_id: str) -> int:
        """Return how many commands of this account are in progress."""
        return sum(job.command.author.id == account_id for job in self._jobs)

    async def in_order(self, job: QueuedCommand) -> None:
        """Wait until the earlier commands of its account have passed the rate limit or ended."""
        while job.ended is None and not all(other.admitted for other in self.of_same_author(job)):
            job._changed.clear()
            await job._changed.wait()

    def mark_admitted(self, job: QueuedCommand) -> None:
        job.admitted = True
        self._notify_waiting()

    def topics(self) -> frozenset[str]:
        """Return the threads in which a bare "stop" addresses this robot."""
        return frozenset(job.command.topic_id for job in self._jobs)

    def enter(self, job: QueuedCommand) -> None:
        self._jobs.append(job)
        self._on_change()

    def leave(self, job: QueuedCommand) -> None:
        """Remove a command. Removing it twice does nothing."""
        if job in self._jobs:
            self._jobs.remove(job)
            if self._turn is job:
                self._turn = None
            self._notify_waiting()

    def wake(self) -> None:
        """Wake the tasks of all commands, which then check what they wait for."""
        for job in self._jobs:
            job._changed.set()

    def _notify_waiting(self) -> None:
        self.wake()
        self._on_change()

    def end_all(self, why: EndReason) -> list[QueuedCommand]:
        """End every command; return those that had not been ended."""
        return self._end(self._jobs, why)

    def end_posted(self, until: datetime, why: EndReason) -> list[QueuedCommand]:
        """End every command posted at this time or earlier; return those that had not been ended."""
        return self._end([job for job in self._jobs if job.command.posted_at <= until], why)

    def end_before(self, job: QueuedCommand, why: EndReason) -> list[QueuedCommand]:
        """End every command accepted before this one, regardless of the times of the posts; return those that had not
        been ended."""
        return self._end(self._jobs[: self._jobs.index(job)] if job in self._jobs else [], why)

    def end_waiting(self, job: QueuedCommand, why: EndReason) -> list[QueuedCommand]:
        """End the earlier commands of its account that are not moving; return those that had not been ended."""
        return self._end([other for other in self.of_same_author(job) if not other.moving], why)

    def _end(self, jobs: Sequence[QueuedCommand], why: EndReason) -> list[QueuedCommand]:
        found = [job for job in jobs if job.can_end]
        for job in found:
            job.end(why)
        return found

    async def turn(self, job: QueuedCommand, expiry_s: float) -> bool:
        """Wait for the command's turn. Return False if it was ended or is older than `expiry_s`."""
        job.ready = True
        left_s = None if job.begun else expiry_s - (time.monotonic() - job.queued_s)
        if left_s is not None and left_s <= 0:
            job.end(EndReason.EXPIRED)
        try:
            async with asyncio.timeout(left_s):
                while job.ended is None and not self._is_next(job):
                    job._changed.clear()
                    await job._changed.wait()
        except TimeoutError:
            job.end(EndReason.EXPIRED)
        if job.ended is None:
            self._turn = job
        return job.ended is None

    def close(self) -> None:
        """Start no more commands: those that wait are processed after the agent's next start."""
        self._closed = True

    def _is_next(self, job: QueuedCommand) -> bool:
        return not self._closed and self._turn is None and next(j for j in self._jobs if j.ready and not j.held) is job

    async def let_others_pass(self, job: QueuedCommand, seconds: float) -> None:
        """Let other commands pass it for this long, even if it is ended meanwhile."""
        job.held = True
        self._notify_waiting()
        try:
            await asyncio.sleep(seconds)
        finally:
            job.held = False

    async def hold(self, job: QueuedCommand, seconds: float, until: Callable[[], object] = lambda: False) -> bool:
        """Let other commands pass it for this long, or `until` a condition holds; it keeps its place.

        Return False if it was ended meanwhile.
        """
        job.held = True
        self._notify_waiting()
        try:
            async with asyncio.timeout(seconds):
                while job.ended is None and not until():
                    job._changed.clear()
                    await job._changed.wait()
        except TimeoutError:
            pass
        finally:
            job.held = False
        return job.ended is None
