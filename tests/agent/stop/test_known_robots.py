"""Which accounts are known to be robots, and that the look-up never delays a stop (laws 13 and 15)."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any

import pytest

from agentrob.agent.stop import known_robots
from agentrob.agent.stop.known_robots import KnownRobots
from agentrob.errors import ForumUnreachable
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.model import Account, AccountKind


class CountingForum(MemoryForum):
    """A forum that does not answer about accounts until `answers` is set; `raises` is raised once."""

    asked: list[str]
    answers: asyncio.Event
    raises: Exception | None = None

    async def account(self, name: str) -> Account | None:
        self.asked.append(name)
        await self.answers.wait()
        if self.raises is not None:
            self.raises, raised = None, self.raises
            raise raised
        return await super().account(name)


def made(world: MemoryWorld) -> tuple[CountingForum, KnownRobots, list[asyncio.Task[Any]]]:
    forum, tasks = CountingForum(world, "quadruped"), list[asyncio.Task[Any]]()
    forum.asked, forum.answers = [], asyncio.Event()

    def spawn(work: Coroutine[Any, Any, Any]) -> None:
        tasks.append(asyncio.ensure_future(work))

    return forum, KnownRobots(forum, spawn), tasks


async def test_law_13_who_writes_and_who_is_looked_up_is_known_and_people_are_no_robots() -> None:
    forum, known, tasks = made(world := MemoryForum.world())
    for name, kind in (("humanoid", AccountKind.ROBOT_AGENT), ("alice", AccountKind.HUMAN)):
        world.sign_in(name, kind=kind)
    forum.answers.set()
    known.look_up(["humanoid", "alice", "nobody"])
    assert set(known.names) == set(), "nobody waited for it"
    await asyncio.gather(*tasks)
    assert (set(known.names), forum.asked) == ({"humanoid"}, ["humanoid", "alice", "nobody"])
    known.look_up(["humanoid", "alice", "nobody"])
    assert len(tasks) == 1, "nor is anybody asked about again at once"
    known.note(Account("9", "humanoid", AccountKind.HUMAN))
    assert set(known.names) == set(), "it became a person's"


async def test_law_15_posts_with_many_names_ask_about_a_few_one_at_a_time() -> None:
    forum, known, tasks = made(MemoryForum.world())
    for post in range(50):
        known.look_up([f"name{post}-{n}" for n in range(100)])
    await asyncio.sleep(0)
    assert (len(tasks), len(forum.asked)) == (1, 1)
    forum.answers.set()
    await asyncio.gather(*tasks)
    assert len(forum.asked) == known_robots.MOST_WAITING


async def test_law_15_whatever_the_forum_raises_the_next_name_is_asked_about() -> None:
    for error in (ForumUnreachable("away"), RuntimeError("a bug of an adapter")):
        forum, known, tasks = made(world := MemoryForum.world())
        world.sign_in("humanoid", kind=AccountKind.ROBOT_AGENT)
        forum.raises = error
        forum.answers.set()
        known.look_up(["alice", "humanoid"])
        await asyncio.gather(*tasks)
        assert set(known.names) == {"humanoid"}


async def test_robots_that_could_not_be_listed_at_the_start_are_listed_later(monkeypatch: pytest.MonkeyPatch) -> None:
    forum, known, _ = made(world := MemoryForum.world())
    world.sign_in("humanoid", kind=AccountKind.ROBOT_AGENT)
    world.reachable = False
    await known.list_robots()
    assert set(known.names) == set()
    monkeypatch.setattr(known_robots, "LIST_AGAIN_S", 0.01)
    listing = asyncio.create_task(known.list_later())
    await asyncio.sleep(0)
    world.reachable = True
    async with asyncio.timeout(30):
        await listing
    assert "humanoid" in known.names
    await forum.close()


async def test_an_agent_starts_whatever_the_list_of_robots_is() -> None:
    class FailingForum(CountingForum):
        async def robot_names(self) -> tuple[str, ...]:
            raise RuntimeError("a bug of an adapter")

    world = MemoryForum.world()
    world.sign_in("humanoid", kind=AccountKind.ROBOT_AGENT)
    known = KnownRobots(FailingForum(world, "quadruped"), lambda _: None)
    await known.list_robots()
    assert set(known.names) == set()
    known = KnownRobots(MemoryForum(world, "quadruped"), lambda _: None)
    await known.list_robots()
    assert set(known.names) == {"humanoid"}
