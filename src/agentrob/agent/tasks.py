"""Run the background tasks of one agent: log the errors of each, restart those that must go on, cancel them all."""

from __future__ import annotations

import asyncio
import traceback
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

import structlog

#: When a task that must not end is restarted after an error.
RESTART_S = 1.0
_log = structlog.get_logger()


class BackgroundTasks:
    """The tasks that an agent started and that still run. An error in one is logged and ends only that one."""

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self.running: set[asyncio.Task[Any]] = set()

    def spawn(self, work: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        task = asyncio.create_task(work)
        self.running.add(task)
        task.add_done_callback(self._done)
        return task

    async def restarted(self, run: Callable[[], Awaitable[None]]) -> None:
        """Run a task until cancelled. Its errors are logged and never end the agent, which must hear stops."""
        while True:
            try:
                await run()
            except Exception:
                _log.error("task failed, restarting it", robot=self._robot, trace=traceback.format_exc())
            await asyncio.sleep(RESTART_S)

    async def cancel_all(self) -> None:
        """Cancel what runs, and wait until it has ended."""
        for task in tuple(self.running):
            task.cancel()
        await asyncio.gather(*self.running, return_exceptions=True)

    def _done(self, task: asyncio.Task[Any]) -> None:
        self.running.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            _log.error("task failed", robot=self._robot, trace="".join(traceback.format_exception(error)))
