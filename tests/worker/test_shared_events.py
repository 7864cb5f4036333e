"""Agents that share an event stream receive what each would receive alone."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator
from dataclasses import replace

import pytest

from agentrob.errors import ForumDenied, ForumUnreachable
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.forums.discourse.forum import DiscourseForum
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.forums.nodebb.forum import NodeBBForum
from agentrob.forums.protocol import BEFORE_ALL, Event, Events
from agentrob.mcp.adapter import McpForum
from agentrob.model import AccountKind, CommandState, EventKind, Role, StatusCard
from agentrob.worker import shared_events
from agentrob.worker.shared_events import MOST_WAITING, SharedEvents

LIMIT_S = 30.0


class CountedForum(MemoryForum):
    """Counts its open streams; a denied one may not open any."""

    open = opened = 0
    begun: asyncio.Event
    closed: asyncio.Event
    denied = False
    #: How often this account asked for changes, its stream included.
    asked = 0

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        self.asked += 1
        return await super().changes(after, limit)

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        if self.denied:
            raise ForumDenied("this account may not read")
        type(self).open += 1
        type(self).opened += 1
        self.begun.set()
        try:
            async for event in super().stream(after, heartbeat_s):
                yield event
        finally:
            type(self).open -= 1
            self.closed.set()


class Listening:
    """Collects the posts of a stream in a task."""

    def __init__(self, events: Events, after: str, heartbeat_s: float = 0.05) -> None:
        self.texts: list[str] = []
        self._arrived = asyncio.Event()
        self.task = asyncio.create_task(self._listen(events, after, heartbeat_s))

    async def _listen(self, events: Events, after: str, heartbeat_s: float) -> None:
        async for event in events.stream(after, heartbeat_s):
            if event.post is not None:
                self.texts.append(event.post.raw)
            self._arrived.set()

    async def until(self, count: int) -> None:
        async with asyncio.timeout(LIMIT_S):
            while len(self.texts) < count:
                self._arrived.clear()
                await self._arrived.wait()

    async def end(self) -> None:
        self.task.cancel()
        await asyncio.gather(self.task, return_exceptions=True)


@pytest.fixture
def world() -> MemoryWorld:
    CountedForum.open, CountedForum.opened = 0, 0
    CountedForum.begun, CountedForum.closed = asyncio.Event(), asyncio.Event()
    world = MemoryForum.world()
    world.sign_in("alice", role=Role.OPERATOR)
    for name in ("rex", "ada", "kim"):
        world.sign_in(name)
    return world


async def post(world: MemoryWorld, *texts: str) -> None:
    for text in texts:
        await MemoryForum(world, "alice").create_topic("robots", "A topic", text, key=text)


async def test_two_agents_of_the_same_role_share_one_stream_and_miss_nothing(world: MemoryWorld) -> None:
    start, _ = await MemoryForum(world, "rex").now()
    await post(world, "one", "two")
    shared = SharedEvents()
    rex = Listening(shared.of(CountedForum(world, "rex")), start)
    await rex.until(2)
    await post(world, "three")
    await rex.until(3)
    ada = Listening(shared.of(CountedForum(world, "ada")), start)
    await ada.until(3)
    await post(world, "four")
    await asyncio.gather(rex.until(4), ada.until(4))
    assert rex.texts == ada.texts == ["one", "two", "three", "four"]
    assert CountedForum.open == 1
    await rex.end()
    await post(world, "five")
    await ada.until(5)
    assert ada.texts[-1] == "five"
    await ada.end()
    assert CountedForum.open == 0


async def test_when_the_agent_that_reads_the_stream_ends_another_one_reads_on(world: MemoryWorld) -> None:
    start, _ = await MemoryForum(world, "rex").now()
    shared = SharedEvents()
    rex, ada = (Listening(shared.of(CountedForum(world, name)), start) for name in ("rex", "ada"))
    await post(world, "one")
    await asyncio.gather(rex.until(1), ada.until(1))
    await rex.end()
    for number in range(2, 12):
        await post(world, str(number))
    await ada.until(11)
    assert ada.texts == ["one", *map(str, range(2, 12))]
    assert not ada.task.done()
    assert CountedForum.open == 1
    await ada.end()


async def test_an_account_of_another_role_has_a_stream_of_its_own(world: MemoryWorld) -> None:
    world.sign_in("chief", role=Role.ADMIN)
    start, _ = await MemoryForum(world, "rex").now()
    shared = SharedEvents()
    both = [Listening(shared.of(CountedForum(world, name)), start) for name in ("rex", "chief")]
    await post(world, "one")
    for listening in both:
        await listening.until(1)
    assert CountedForum.open == 2
    for listening in both:
        await listening.end()


class PrivateForum(CountedForum):
    """A forum with a category for each robot: posts that begin with `for NAME` can be read by that account alone."""

    def __init__(self, world: MemoryWorld, name: str) -> None:
        super().__init__(world, name)
        self.readable_by_role = False
        self._reader = name

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        return tuple(event for event in await super().changes(after, limit) if self._may_read(event))

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        async for event in super().stream(after, heartbeat_s):
            if self._may_read(event):
                yield event

    def _may_read(self, event: Event) -> bool:
        return event.post is None or event.post.raw.startswith(f"for {self._reader}")


async def test_law_13_where_accounts_of_one_role_may_not_read_the_same_each_hears_its_own_stop(
    world: MemoryWorld,
) -> None:
    start, _ = await MemoryForum(world, "rex").now()
    shared = SharedEvents()
    rex, ada = (Listening(shared.of(PrivateForum(world, name)), start) for name in ("rex", "ada"))
    await post(world, "for rex: stop", "for ada: stop")
    await asyncio.gather(rex.until(1), ada.until(1))
    await post(world, "for ada: walk", "for rex: walk")
    await asyncio.gather(rex.until(2), ada.until(2))
    assert rex.texts == ["for rex: stop", "for rex: walk"]
    assert ada.texts == ["for ada: stop", "for ada: walk"]
    await asyncio.gather(rex.end(), ada.end())


@pytest.mark.parametrize(
    ("forum", "shared"),
    [(BoardForum, True), (NodeBBForum, False), (DiscourseForum, False), (McpForum, False)],
    ids=["board", "nodebb", "discourse", "mcp"],
)
def test_only_a_forum_whose_accounts_of_one_role_read_the_same_is_shared(forum: type, shared: bool) -> None:
    assert getattr(forum, "readable_by_role", False) is shared


async def test_an_account_whose_role_changes_joins_the_stream_of_its_new_role(
    world: MemoryWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shared_events, "CHECK_ROLES_S", 0.01)
    start, _ = await MemoryForum(world, "rex").now()
    shared = SharedEvents()
    rex, ada = (shared.of(CountedForum(world, name)) for name in ("rex", "ada"))
    leaving, staying = Listening(rex, start), Listening(ada, start)
    await post(world, "one")
    await asyncio.gather(leaving.until(1), staying.until(1))
    world.set_role("rex", Role.MODERATOR)
    with pytest.raises(ForumUnreachable, match="role"):
        async with asyncio.timeout(LIMIT_S):
            await leaving.task
    newest, _ = await rex.now()
    again = Listening(rex, newest)
    await post(world, "two")
    await asyncio.gather(again.until(1), staying.until(2))
    assert (again.texts, staying.texts) == (["two"], ["one", "two"])
    assert CountedForum.open == 2
    await asyncio.gather(again.end(), staying.end())


async def test_posts_written_while_an_agent_joins_arrive_once_and_in_order(world: MemoryWorld) -> None:
    start, _ = await MemoryForum(world, "rex").now()
    shared = SharedEvents()
    first = Listening(shared.of(CountedForum(world, "rex")), start)
    await post(world, "0")
    await first.until(1)
    joined = []
    for number in range(1, 40):
        joined.append(Listening(shared.of(CountedForum(world, "ada")), start))
        await post(world, str(number))
        await asyncio.sleep(0)
    for listening in (first, *joined):
        await listening.until(40)
        assert listening.texts == [str(number) for number in range(40)]
        await listening.end()


async def listening_to_all(
    world: MemoryWorld, shared: SharedEvents, forum: CountedForum, *texts: str
) -> tuple[Listening, str]:
    """An agent that has read these posts from the stream, and the event before them."""
    start, _ = await forum.now()
    rex = Listening(shared.of(forum), start)
    await post(world, "first")
    await rex.until(1)
    before, _ = await forum.now()
    for number, text in enumerate(texts):
        await post(world, text)
        await rex.until(number + 2)
    return rex, before


async def test_what_an_agent_missed_comes_from_the_stream_while_that_has_all_of_it(world: MemoryWorld) -> None:
    shared = SharedEvents()
    rex, before = await listening_to_all(world, shared, CountedForum(world, "rex"), "one", "two", "three")
    forum = CountedForum(world, "ada")
    ada = shared.of(forum)
    newest, _ = await ada.now()
    missed = await ada.changes(before)
    assert missed == await MemoryForum(world, "ada").changes(before)
    assert await ada.changes(before, limit=2) == missed[:2]
    assert await ada.changes(newest) == ()
    listening = Listening(ada, missed[1].id)
    await listening.until(1)
    await post(world, "four")
    await listening.until(2)
    assert listening.texts == ["three", "four"], "each once: not again what was handled before"
    assert forum.asked == 0
    await asyncio.gather(rex.end(), listening.end())


@pytest.mark.parametrize(
    ("constant", "value"), [("MOST_KEPT", 1), ("KEPT_S", 0.0), ("ALIVE_S", 0.0)], ids=["many", "old", "silent"]
)
async def test_what_the_stream_may_lack_is_read_from_the_forum(
    world: MemoryWorld, monkeypatch: pytest.MonkeyPatch, constant: str, value: float
) -> None:
    monkeypatch.setattr(shared_events, constant, value)
    shared = SharedEvents()
    rex, before = await listening_to_all(world, shared, CountedForum(world, "rex"), "one", "two", "three")
    forum = CountedForum(world, "ada")
    ada = shared.of(forum)
    await ada.now()
    assert await ada.changes(before) == await MemoryForum(world, "ada").changes(before)
    assert forum.asked == 1
    listening = Listening(ada, before)
    await listening.until(3)
    assert listening.texts[:3] == ["one", "two", "three"]
    await asyncio.gather(rex.end(), listening.end())


class HeldForum(CountedForum):
    """Its stream delivers a post that says "held" only when `released`."""

    released: asyncio.Event

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        async for event in super().stream(after, heartbeat_s):
            if event.post is not None and event.post.raw == "held":
                await self.released.wait()
            yield event


async def test_a_stop_that_the_stream_has_not_delivered_yet_is_read_from_the_forum(world: MemoryWorld) -> None:
    shared, held = SharedEvents(), HeldForum(world, "rex")
    held.released = asyncio.Event()
    rex, before = await listening_to_all(world, shared, held, "one")
    await post(world, "held")
    ada = shared.of(CountedForum(world, "ada"))
    await ada.now()
    assert [event.post.raw for event in await ada.changes(before) if event.post] == ["one", "held"]
    held.released.set()
    await rex.until(3)
    assert [event.post.raw for event in await ada.changes(before) if event.post] == ["one", "held"]
    await rex.end()


class UnwrittenStops(CountedForum):
    """Announces a stop that it could not write after each post; its event has the id of the one before."""

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        async for event in super().stream(after, heartbeat_s):
            yield event
            if event.post is not None:
                yield replace(event, kind=EventKind.ROBOT_STOP, post=None, robot="ada")


async def test_a_stop_that_the_forum_could_not_write_is_among_what_was_missed(world: MemoryWorld) -> None:
    shared = SharedEvents()
    rex, _ = await listening_to_all(world, shared, UnwrittenStops(world, "rex"), "one", "two")
    _, one, two = await MemoryForum(world, "rex").changes(BEFORE_ALL)
    ada = shared.of(CountedForum(world, "ada"))
    await ada.now()
    stop, then, *_ = await ada.changes(one.id)
    assert (stop.kind, stop.robot, then) == (EventKind.ROBOT_STOP, "ada", two)
    await rex.end()


async def test_a_stream_that_is_cut_is_opened_once_again_for_everybody(world: MemoryWorld) -> None:
    start, _ = await MemoryForum(world, "rex").now()
    shared = SharedEvents()
    both = [Listening(shared.of(CountedForum(world, name)), start) for name in ("rex", "ada")]
    await post(world, "one")
    for listening in both:
        await listening.until(1)
    opened = CountedForum.opened
    world.reachable = False
    async with asyncio.timeout(LIMIT_S):
        await CountedForum.closed.wait()
    world.reachable = True
    await post(world, "two")
    await asyncio.gather(*(listening.until(2) for listening in both))
    assert [listening.texts for listening in both] == [["one", "two"]] * 2
    assert CountedForum.open == 1
    assert CountedForum.opened - opened <= 2
    for listening in both:
        await listening.end()


async def test_an_account_that_may_not_read_is_cut_off_alone(world: MemoryWorld) -> None:
    start, _ = await MemoryForum(world, "rex").now()
    shared = SharedEvents()
    denied = CountedForum(world, "rex")
    denied.denied = True
    rex = Listening(shared.of(denied), start)
    ada = Listening(shared.of(CountedForum(world, "ada")), start)
    await post(world, "one")
    await ada.until(1)
    with pytest.raises(ForumDenied):
        async with asyncio.timeout(LIMIT_S):
            await rex.task
    await ada.end()


async def test_an_agent_that_handles_nothing_does_not_grow_without_limit(world: MemoryWorld) -> None:
    shared = SharedEvents()
    start, _ = await MemoryForum(world, "rex").now()
    ada = Listening(shared.of(CountedForum(world, "ada")), start)
    stuck = shared.of(CountedForum(world, "rex")).stream(start, 0.05)
    await post(world, "one")
    assert (await anext(stuck)).post is not None  # it never asks for more until all are written
    await ada.until(1)
    alice = MemoryForum(world, "alice")
    topic = (await alice.create_topic("robots", "Many", "two", key="two")).post.topic_id
    for number in range(MOST_WAITING + 10):
        await alice.reply(topic, "more", key=f"more {number}")
        if number % 1000 == 0:
            await ada.until(number + 3)
    await ada.until(MOST_WAITING + 12)
    with pytest.raises(ForumUnreachable, match="wait to be handled"):
        async for _ in stuck:
            pass
    await ada.end()


async def listening_without_heartbeats(world: MemoryWorld, start: str) -> Listening:
    """An agent whose stream has begun."""
    rex = Listening(SharedEvents().of(CountedForum(world, "rex")), start, heartbeat_s=60.0)
    async with asyncio.timeout(LIMIT_S):
        await CountedForum.begun.wait()
    return rex


async def test_posts_of_robots_wait_for_the_next_event_and_none_is_lost(
    world: MemoryWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shared_events, "LAZY_S", math.inf)
    world.sign_in("robot", kind=AccountKind.ROBOT_AGENT, role=Role.OPERATOR)
    robot = MemoryForum(world, "robot")
    start, _ = await MemoryForum(world, "rex").now()
    rex = await listening_without_heartbeats(world, start)
    await post(world, "first")
    await rex.until(1)
    topic = (await robot.create_topic("robots", "A topic", "r0", key="r0")).post.topic_id
    for number in range(1, 20):
        await robot.reply(topic, f"r{number}", key=f"r{number}")
    for _ in range(100):
        await asyncio.sleep(0)
    assert rex.texts == ["first"], "nobody obeys robots: they need not wake the agent"
    stopped = StatusCard("robot", CommandState.STOPPED, trace_id="t")
    await robot.reply(topic, "stopped", key="stopped", card=stopped)
    await rex.until(22)  # at once: the other robots of a joint command stop, too
    await robot.reply(topic, "later", key="later")
    await post(world, "last")
    await rex.until(24)
    assert rex.texts == ["first", *(f"r{number}" for number in range(20)), "stopped", "later", "last"]
    await rex.end()


async def test_a_post_of_a_robot_proves_that_the_stream_is_alive(world: MemoryWorld) -> None:
    world.sign_in("robot", kind=AccountKind.ROBOT_AGENT, role=Role.OPERATOR)
    start, _ = await MemoryForum(world, "rex").now()
    rex = await listening_without_heartbeats(world, start)
    await MemoryForum(world, "robot").create_topic("robots", "A topic", "alone", key="alone")
    await rex.until(1)
    await rex.end()
