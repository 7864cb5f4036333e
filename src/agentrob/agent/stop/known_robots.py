"""Know which accounts are robots: only a mention of a known robot may turn a stop away from this one (law 13).

An unknown account may be a person who is warned ("@alice stop it!"), so the robot stops. No stop waits for a lookup:
the forum's robots are listed once at the start, authors of posts are noted, and an unknown account that a post mentions
is looked up afterwards, for the next time.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Collection, Coroutine
from typing import Any

import structlog

from agentrob.forums.bounded import BoundedDict
from agentrob.forums.protocol import Forum, RobotDirectory
from agentrob.model import Account, AccountKind

#: The most names that are remembered, of robots and of accounts that were looked up.
MOST = 1_000
#: When a name is looked up again, and how many lookups can wait.
AGAIN_S, MOST_WAITING = 600.0, 8
#: How long the forum's list of robots may take before the agent starts without it, and when it is asked for again.
LIST_S, LIST_AGAIN_S = 3.0, 10.0
_log = structlog.get_logger()


class KnownRobots:
    """The robots known on one forum. `spawn` starts a task that nobody awaits."""

    def __init__(self, forum: Forum, spawn: Callable[[Coroutine[Any, Any, Any]], object]) -> None:
        self._forum = forum
        self._spawn = spawn
        self._robots: BoundedDict[str, None] = BoundedDict(MOST)
        self._asked_s: BoundedDict[str, float] = BoundedDict(MOST)
        self._waiting: list[str] = []
        self._listed = False

    @property
    def names(self) -> Collection[str]:
        return self._robots.keys()

    async def list_robots(self) -> None:
        """Load the forum's robots, if it lists them. Never raises: the agent starts anyway, and `list_later`."""
        if self._listed or not isinstance(self._forum, RobotDirectory):
            self._listed = True
            return
        try:
            async with asyncio.timeout(LIST_S):
                for name in await self._forum.robot_names():
                    self._robots[name.lower()] = None
            self._listed = True
        except Exception as error:
            _log.warning("the forum's robots are not known", error=repr(error)[:200])

    async def list_later(self) -> None:
        """Load the forum's robots again and again until they are known: else each mention of one is looked up."""
        while not self._listed:
            await asyncio.sleep(LIST_AGAIN_S)
            await self.list_robots()

    def note(self, account: Account) -> None:
        """Record whether the author of a post, or an account that was looked up, is a robot."""
        name = account.name.lower()
        if account.kind is AccountKind.ROBOT_AGENT:
            self._robots[name] = None
        else:
            self._robots.pop(name, None)

    def look_up(self, names: Collection[str]) -> None:
        """Look up accounts that are not known to be robots. Never waits."""
        idle = not self._waiting
        for name in names:
            asked_s = self._asked_s.get(name)
            if name in self._robots or len(self._waiting) >= MOST_WAITING:
                continue
            if asked_s is None or time.monotonic() - asked_s > AGAIN_S:
                self._asked_s[name] = time.monotonic()
                self._waiting.append(name)
        if idle and self._waiting:
            self._spawn(self._ask())

    async def _ask(self) -> None:
        while self._waiting:
            try:
                if (account := await self._forum.account(self._waiting[0])) is not None:
                    self.note(account)
            except Exception as error:
                _log.info("an account is not known", account=self._waiting[0], error=repr(error)[:200])
            self._waiting.pop(0)
