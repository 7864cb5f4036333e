"""Several robots on one memory forum, each with an agent and a driver of its own."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agentrob.agent.agent import RobotAgent
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, Post, Role
from tests.agent.agent_scene import FINAL, Driver, checked_cards, robot_settings, serving
from tests.agent.store.journal_store import open_journal


@dataclass
class JointScene:
    """A forum with the operator `alice` and robots by name."""

    world: MemoryWorld
    drivers: dict[str, Driver]
    folder: Path
    _number: int = 0

    def make(self, robot: str, **changed: Any) -> RobotAgent:
        forum = self.world.sign_in(robot, kind=AccountKind.ROBOT_AGENT)

        async def journal() -> Any:
            return await open_journal(self.folder, robot)

        arguments: dict[str, Any] = {
            "name": robot, "settings": robot_settings(poll_s=0.5), "forum": forum,
            "driver": self.drivers[robot].client(), "mind": RulesMind(), "data": self.folder, "open_journal": journal,
            **changed,
        }  # fmt: skip
        return RobotAgent(**arguments)

    @asynccontextmanager
    async def agents(self, *robots: str, **changed: Any) -> AsyncIterator[Sequence[RobotAgent]]:
        """Run the agents of these robots, by default of all, until the block ends."""
        made = [self.make(robot, **changed) for robot in robots or self.drivers]
        with checked_cards(self.world):
            async with AsyncExitStack() as stack:
                for agent in made:
                    await stack.enter_async_context(serving(agent))
                for agent in made:
                    await agent.ready.wait()
                yield made

    async def post(self, text: str, name: str = "alice", topic: str | None = None) -> Post:
        self._number += 1
        forum = self.world.sign_in(name)
        if topic is None:
            return (await forum.create_topic("robots", "A topic", text, key=f"k{self._number}")).post
        return (await forum.reply(topic, text, key=f"k{self._number}")).post

    def replies(self, post: Post, robot: str = "") -> list[Post]:
        """The robots' replies to a post, in the order of the thread."""
        return [p for p in self.world.posts.values() if p.reply_to == post.id and robot in ("", p.author.name)]

    def part(self, post: Post, number: int, robot: str = "") -> Post | None:
        """The status post of a part."""
        for reply in self.replies(post, robot):
            if reply.card is not None and reply.card.part == number and not reply.card.takes:
                return reply
        return None

    async def until(self, condition: Any, limit_s: float = 60.0) -> Any:
        async with asyncio.timeout(limit_s):
            while not (found := condition()):
                await self.world.wait(0.05)
        return found

    async def ends(self, post: Post, number: int, robot: str = "") -> Post:
        """Wait for the final reply of a part."""

        def ended() -> Post | None:
            found = self.part(post, number, robot)
            return found if found is not None and found.card is not None and found.card.state in FINAL else None

        return await self.until(ended)

    async def shows(self, post: Post, number: int, state: str, robot: str = "") -> Post:
        """Wait until a part shows a state."""

        def there() -> Post | None:
            found = self.part(post, number, robot)
            return found if found is not None and found.card is not None and found.card.state == state else None

        return await self.until(there)

    def summaries(self, post: Post) -> list[Post]:
        return [reply for reply in self.replies(post) if reply.key == f"joint:{post.id}"]

    async def summary(self, post: Post) -> Post:
        return (await self.until(lambda: self.summaries(post)))[0]


def make_joint_scene(drivers: dict[str, Driver], folder: Path, **world: Any) -> JointScene:
    scene = JointScene(MemoryForum.world(**world), drivers, folder)
    for robot in drivers:
        scene.world.sign_in(robot, kind=AccountKind.ROBOT_AGENT)
    scene.world.sign_in("alice", role=Role.OPERATOR)
    scene.world.sign_in("bob", role=Role.MEMBER)
    return scene
