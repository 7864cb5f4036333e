"""Sum up a post to several robots once all its parts have ended: one reply, by the robot that the post names first.

All agents know which robot that is, and the forum writes a reply only once under its key. The posts to sum up are in
the journal, so that a restart does it.
"""

from __future__ import annotations

import asyncio
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

import structlog

from agentrob.agent.joint import evidence
from agentrob.agent.joint.texts import summary
from agentrob.agent.joint.thread import PartThreads
from agentrob.agent.reporting.status_post import retry_until_answered
from agentrob.agent.store.journal import Journal
from agentrob.errors import ForumDenied, ForumError, ForumNotFound, JournalError
from agentrob.forums.protocol import Forum
from agentrob.language.joint.parts import JointCommand
from agentrob.language.joint.reading import joint_command
from agentrob.model import Command

#: How often parts are looked at again, how much later than it should have ended one counts as not ended, and how often
#: the reply is tried.
LOOK_S, LATE_S, TRIES = 5.0, 30.0, 9
_log = structlog.get_logger()


@dataclass
class PartSummaries:
    """The summaries of one robot. `now` is the forum's clock."""

    forum: Forum
    journal: Journal
    threads: PartThreads
    now: Callable[[], datetime]

    def __post_init__(self) -> None:
        self._changed = asyncio.Event()

    def changed(self) -> None:
        """Look again: a robot showed something about a part."""
        self._changed.set()

    async def run(self) -> None:
        """Write summaries until cancelled."""
        while True:
            self._changed.clear()
            waiting = 0
            try:
                waiting = await self.step()
            except JournalError as e:
                _log.error("summaries not read", error=str(e))
            except Exception:  # none ends the agent, which must hear the next stop
                _log.error("summaries not handled", trace=traceback.format_exc())
            try:
                async with asyncio.timeout(LOOK_S if waiting else None):
                    await self._changed.wait()
            except TimeoutError:
                pass

    async def add(self, command: Command) -> None:
        """Note in the journal that this robot sums up a post."""
        await self.journal.add_summary(command)
        self.changed()

    async def step(self) -> int:
        """Write the summaries of posts whose parts have ended; return how many are left."""
        commands = await self.journal.summaries()
        return sum([not await self._sum_up(command) for command in commands])

    async def _sum_up(self, command: Command) -> bool:
        """Whether nothing is left to do for this command."""
        joint = joint_command(command.text)
        if not isinstance(joint, JointCommand):  # kept by another version, which read the post otherwise
            await self.journal.set_summary_reported(command.key)
            return True
        posts = self.threads.known(command)
        if not self._ended(command, joint, posts):
            posts = await self.threads.read_or_known(command)
        if not self._ended(command, joint, posts):
            return False
        statuses = [evidence.status_of(part, posts) for part in joint.parts]
        text = summary(joint, statuses, command.language)
        try:
            await retry_until_answered(
                lambda: self.forum.reply(
                    command.topic_id, text, key=f"joint:{command.post_id}", reply_to=command.post_id
                ),
                TRIES,
            )
        except (ForumNotFound, ForumDenied) as e:
            _log.warning("parts not summed up", post=command.post_id, error=str(e))
        except ForumError as e:
            _log.warning("parts not summed up yet", post=command.post_id, error=str(e))
            return False
        await self.journal.set_summary_reported(command.key)
        return True

    def _ended(self, command: Command, joint: JointCommand, posts: Any) -> bool:
        """Whether every part has ended, or is long past the time by which it should have."""
        for part in joint.parts:
            status = evidence.status_of(part, posts)
            if status.has_ended:
                continue
            until = evidence.until_of(joint, part.number, status, command.posted_at)
            if self.now() <= until + timedelta(seconds=LATE_S):
                return False
        return True
