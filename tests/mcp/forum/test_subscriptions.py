"""Subscriptions in the protocol before 2026: stored per session, dropped when the session ends, and limited."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

from agentrob.mcp.forum.identity import Identity, Rights
from agentrob.mcp.forum.subscriptions import MAX_SESSIONS, MAX_SUBSCRIPTIONS, SESSION_HEADER, Subscriptions
from tests.mcp.forum.inside import ALL, memory_world


class Session:
    """Receives updates like an SDK session; each request of a client has its own session object."""

    def __init__(self, told: list[str]) -> None:
        self.told = told

    async def send_resource_updated(self, uri: str) -> None:
        self.told.append(uri)


def request(session_id: str, told: list[str]) -> Any:
    return SimpleNamespace(session=Session(told), request=SimpleNamespace(headers={SESSION_HEADER: session_id}))


async def test_an_ended_session_gets_no_updates_and_others_do() -> None:
    world = memory_world()
    forum = world.sign_in("alice")
    topic_id = (await forum.create_topic("robots", "News", "hello", key="1")).post.topic_id
    uri = f"forum://topic/{topic_id}"
    subscriptions = Subscriptions(Identity("alice", forum, Rights(True, ALL)))
    first: list[str] = []
    second: list[str] = []
    assert subscriptions.subscribe(request("one", first), uri)
    assert subscriptions.subscribe(request("two", second), uri)
    n = 0

    async def until(told: list[str], more: int) -> None:
        nonlocal n
        async with asyncio.timeout(20):
            while len(told) < more:
                n += 1
                await forum.reply(topic_id, f"news {n}", key=f"news-{n}")
                await asyncio.sleep(0.05)

    await until(first, 1)
    subscriptions.drop("one")
    before = len(first)
    await until(second, len(second) + 2)
    assert (len(first), set(second)) == (before, {uri})
    subscriptions.unsubscribe(request("two", second), uri)
    before = len(second)
    await forum.reply(topic_id, "the last", key="last")
    await asyncio.sleep(0.2)
    assert len(second) == before
    await subscriptions.close()


async def test_subscriptions_and_sessions_are_bounded() -> None:
    subscriptions = Subscriptions(Identity("alice", memory_world().sign_in("alice"), Rights(True, ALL)))
    assert all(subscriptions.subscribe(request("one", []), f"forum://topic/{n}") for n in range(MAX_SUBSCRIPTIONS))
    assert not subscriptions.subscribe(request("one", []), "forum://topic/more")
    assert subscriptions.subscribe(request("one", []), "forum://topic/1"), "the same again is no more"
    for n in range(MAX_SESSIONS):
        assert subscriptions.subscribe(request(f"other {n}", []), "forum://topic/1")
    assert subscriptions.subscribe(request("one", []), "forum://topic/more"), "the oldest session was dropped"
    await subscriptions.close()
