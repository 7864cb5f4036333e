"""Run the agents of several robots in one process, and take over robots whose worker has died.

The worker takes each robot whose journal nobody holds, as long as it has room, and serves it in a task of its own. When
an agent ends, its robot is free again, for this worker or another. One robot's failure ends nothing of another's.
"""

from __future__ import annotations

import asyncio
import contextlib
import traceback
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, Protocol

import structlog

from agentrob.agent.store.journal import Journal
from agentrob.agent.store.journals import Journals
from agentrob.errors import JournalError, JournalHeld

#: How often a worker looks for robots that nobody holds.
TAKE_S = 1.0
#: How many robots are taken at a time. A robot counts until its agent is ready, for `START_S` at most. More at a time
#: would not be served sooner, and the stops of others would wait behind their requests.
AT_A_TIME, START_S = 2, 0.5
#: A standby lets other workers take the robots during this time.
STANDBY_S = 5.0
#: How long until an agent that failed is started again, at first and at most.
AGAIN_S = (1.0, 30.0)
#: An agent that ran for this long is started again after the first delay.
STEADY_S = 60.0
_log = structlog.get_logger()


class Agent(Protocol):
    """An agent as a worker uses it (`agentrob.agent.agent.RobotAgent`)."""

    async def run(self, on_ready: Callable[[], None] = ...) -> None: ...

    async def close(self) -> None: ...

    def drain(self) -> None: ...


class WorkerObserver:
    """Is notified of what happens to the robots of a worker; counts it, for instance."""

    def restarted(self, robot: str) -> None:
        """The robot's agent ended by an error and is started again."""

    def taken_over(self, robot: str) -> None:
        """The robot was served by another worker before."""

    def journal_failed(self, robot: str) -> None:
        """The robot's journal could not be opened or was lost."""

    def left(self, robot: str) -> None:
        """The robot's agent ended."""


class Worker:
    """The agents of `robots`, of which it serves at most `most` at a time. `make_agent` makes the agent of a robot
    whose journal was opened. `on_ready` is called with the name of each robot whose posts are answered from now on."""

    def __init__(
        self,
        robots: Sequence[str],
        journals: Journals,
        make_agent: Callable[[str, Journal], Agent],
        most: int | None = None,
        standby: bool = False,
        on_ready: Callable[[str], None] = lambda _: None,
        observer: WorkerObserver | None = None,
    ) -> None:
        self._robots = tuple(robots)
        self._journals = journals
        self._make_agent = make_agent
        self._room = len(self._robots) if most is None else most
        self._standby = standby
        self._on_ready = on_ready
        self._observer = observer or WorkerObserver()
        self._freed = asyncio.Event()
        #: The robots that it serves now, or is about to.
        self.serving: set[str] = set()
        #: The robots whose journals are being opened.
        self._opening: set[str] = set()
        #: When each robot whose agent ended may be taken again, and after which delay.
        self._again: dict[str, tuple[float, float]] = {}
        self._held_logged: set[str] = set()
        self._draining = False
        self._tasks: dict[str, asyncio.Task[Any]] = {}
        #: The agents that answer posts.
        self._ready: dict[str, Agent] = {}

    async def run(self) -> None:
        """Serve until cancelled; then the agents stop their robots and report what ran as interrupted. Returns after
        `drain`."""
        if self._standby:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(STANDBY_S):
                    await self._freed.wait()  # `drain` ends it
        try:
            async with asyncio.TaskGroup() as group:
                while not self._draining:
                    self._freed.clear()
                    await self._take_free(group)
                    with contextlib.suppress(TimeoutError):
                        async with asyncio.timeout(TAKE_S):
                            await self._freed.wait()
        finally:
            await self._journals.close()

    def drain(self) -> None:
        """Take no more robots, let each agent finish the command that moves, give its robot back, and end `run`."""
        self._draining = True
        self._freed.set()
        for robot, task in self._tasks.items():
            if robot in self._ready:
                self._ready[robot].drain()
            else:
                task.cancel()  # nothing moves yet

    async def _take_free(self, group: asyncio.TaskGroup) -> None:
        """Take the robots that nobody holds, as long as there is room."""
        now_s = asyncio.get_running_loop().time()
        wanted = [r for r in self._robots if r not in self.serving and self._again.get(r, (0.0, 0.0))[0] <= now_s]
        if not wanted or len(self.serving) >= self._room:
            return
        try:
            free = await self._journals.free(wanted)
        except JournalError as e:
            _log.error("robots not taken; trying again", error=str(e))
            return
        for robot in wanted:
            if robot not in free:
                self._log_held(robot)
        to_take = iter([robot for robot in wanted if robot in free])
        async with asyncio.TaskGroup() as taking:
            for _ in range(AT_A_TIME):
                taking.create_task(self._take_each(to_take, group))

    async def _take_each(self, robots: Iterator[str], group: asyncio.TaskGroup) -> None:
        """Take robots from an iterator that other tasks share, one after the other, as long as there is room."""
        while len(self.serving) + len(self._opening) < self._room and not self._draining:
            if (robot := next(robots, None)) is None:
                return
            self._opening.add(robot)
            try:
                journal = await self._open(robot)
            finally:
                self._opening.discard(robot)
            if journal is None:
                continue
            if robot in self._held_logged:
                self._held_logged.discard(robot)
                self._observer.taken_over(robot)
            self.serving.add(robot)
            started = asyncio.Event()
            group.create_task(self._serve(robot, journal, started), name=f"robot {robot}")
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(START_S):
                    await started.wait()

    async def _open(self, robot: str) -> Journal | None:
        try:
            return await self._journals.open(robot)
        except JournalHeld:
            self._log_held(robot)
        except JournalError as e:
            _log.error("journal not opened; trying again", robot=robot, error=str(e))
            self._observer.journal_failed(robot)
        return None

    def _log_held(self, robot: str) -> None:
        if robot not in self._held_logged:
            _log.info("robot held by another worker; waiting for it", robot=robot)
            self._held_logged.add(robot)

    async def _serve(self, robot: str, journal: Journal, started: asyncio.Event) -> None:
        """Serve a robot until its agent fails; then it is free again. Set `started` when the agent is ready or ends."""
        begun_s = asyncio.get_running_loop().time()
        agent: Agent | None = None
        if (task := asyncio.current_task()) is not None:  # not before: cancelled, it would never close the journal
            self._tasks[robot] = task
        try:
            if self._draining:
                return
            agent = self._make_agent(robot, journal)
            await agent.run(on_ready=partial(self._got_ready, robot, agent, started))
        except Exception as e:
            journal_lost = all(isinstance(part, JournalError) for part in _parts(e))
            trace = None if journal_lost else traceback.format_exc()  # anything else is a defect
            _log.error("agent ended; starting it again", robot=robot, error=_one_line(e), trace=trace)
            if journal_lost:
                self._observer.journal_failed(robot)
            self._observer.restarted(robot)
        finally:
            started.set()
            self._ready.pop(robot, None)
            self._tasks.pop(robot, None)
            with contextlib.suppress(Exception):  # the reason was logged already
                if agent is not None:
                    await agent.close()
            with contextlib.suppress(JournalError):
                await journal.close()
            self._free(robot, asyncio.get_running_loop().time() - begun_s)

    def _free(self, robot: str, served_s: float) -> None:
        first_s, longest_s = AGAIN_S
        delay_s = first_s if served_s > STEADY_S else min(longest_s, self._again.get(robot, (0.0, first_s / 2))[1] * 2)
        loop = asyncio.get_running_loop()
        self._again[robot] = loop.time() + delay_s, delay_s
        self.serving.discard(robot)
        self._observer.left(robot)
        self._freed.set()
        loop.call_later(delay_s, self._freed.set)

    def _got_ready(self, robot: str, agent: Agent, started: asyncio.Event) -> None:
        self._ready[robot] = agent
        started.set()
        if self._draining:
            agent.drain()
        self._on_ready(robot)


def _parts(error: BaseException) -> list[BaseException]:
    """An error, or the errors in a group."""
    if isinstance(error, BaseExceptionGroup):
        return [leaf for part in error.exceptions for leaf in _parts(part)]
    return [error]


def _one_line(error: BaseException) -> str:
    """An error as one line; of a group, its parts."""
    return "; ".join(f"{type(part).__name__}: {part}" for part in _parts(error))
