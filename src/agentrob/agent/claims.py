"""Claim a command on the forum by its status post, so that no second agent carries it out (law 6)."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from enum import Enum, auto
from functools import partial

from agentrob.agent.execution.execute import holder_of
from agentrob.agent.queue.queue import CommandQueue, QueuedCommand, expiry_s
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting.status_post import DeniedWrites, Shown, is_final, left_open, retry_until_answered
from agentrob.agent.store.journal import Journal
from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError
from agentrob.forums.protocol import Forum
from agentrob.model import CommandState, EndReason
from agentrob.robots.driver.client import DriverClient


class Claim(Enum):
    """Whose a command is, by its claim on the forum."""

    OURS = auto()
    ENDED = auto()  # its final report is there
    OTHERS = auto()  # another agent's, or of a journal that is lost


@dataclass(frozen=True)
class Claims:
    """The claims of one robot's commands. `now` is the forum's clock."""

    settings: RobotConfig
    forum: Forum
    driver: DriverClient
    journal: Journal
    queue: CommandQueue
    writes: DeniedWrites
    now: Callable[[], datetime]

    async def claim(self, job: QueuedCommand) -> Claim:
        """Post the first status of a command, unless it is there."""
        command = job.command
        shown = Shown(reply_text.seen(command.language, command.trace_id), command.card(CommandState.SEEN))
        written = await self.writes.when_allowed(partial(job.status.claim, shown), partial(self._denied, job))
        job.note("seen", self.now())
        post = written.post
        if not written.created:
            state = post.card.state if post.card else ""
            if is_final(post.card):  # what our journal knows of it may be more than whoever posted that knew
                if not await self.journal.moved(command.key, ended=True):
                    return Claim.ENDED
            elif command.trace_id not in (post.raw, post.card.trace_id if post.card else ""):
                return Claim.OTHERS
            elif state == CommandState.RUNNING and not await self.journal.moved(command.key):
                return Claim.OTHERS  # a journal that knows of no motion may be an old copy: the forum knows more
            job.status.adopt(post)
        await self.journal.set_status_post(command.key, post.id)
        return Claim.OURS

    async def abandoned(self, job: QueuedCommand) -> bool:
        """Leave a command to others; return whether nobody carries it out, so that nobody will report its end."""
        await self.journal.cancel(job.command.key)
        self.queue.leave(job)
        claimed = await retry_until_answered(partial(self.forum.post, job.status.post_id))
        return await left_open(self.forum, claimed, self.moves)

    async def _denied(self, job: QueuedCommand, seconds: float) -> None:
        """The forum denies us the claim: let others pass meanwhile. A command that has become too old only waits for
        its reply."""
        await self.queue.let_others_pass(job, seconds)
        waited_s = job.waited_s + time.monotonic() - job.accepted_s
        if job.can_end and waited_s > expiry_s(job.command, self.settings):
            job.end(EndReason.EXPIRED)
            self.queue.leave(job)
            await self.journal.end([job.command.key], EndReason.EXPIRED)

    async def moves(self, trace_id: str) -> bool:
        """Whether the driver now carries out the command of this trace id, from whichever agent."""
        with contextlib.suppress(RobotError):
            return await self.driver.holder() == holder_of(trace_id)
        return False
