"""Push on Discourse: the message bus, and the events that it omits."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from datetime import timedelta
from pathlib import Path

import pytest

from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumDenied, ForumLimited, ForumUnreachable
from agentrob.forums.discourse.forum import DiscourseForum
from agentrob.forums.discourse.http import DiscourseClient
from agentrob.forums.discourse.message_bus import MessageBusClient
from agentrob.forums.discourse.settings import Credentials
from agentrob.model import AccountKind, EventKind
from tests.forums.discourse.discourse_world import (
    CREATED,
    EDITED,
    PASSWORD,
    REMOVED,
    DiscourseWorld,
    Double,
    first,
    kinds_and_posts,
    write,
)


# ---------------------------------------------------------------- push
async def test_push_delivers_posts_edits_and_removals_at_once(
    robot: DiscourseForum, double: Double, topic: int
) -> None:
    """With a heartbeat every two minutes, only a message can arrive in time."""
    after, _ = await robot.now()
    stream = robot.stream(after, 120.0)
    assert (await anext(stream)).kind is EventKind.HEARTBEAT
    post = write(double.site, topic_id=topic, raw="@quadruped walk")
    async with asyncio.timeout(60):
        assert kinds_and_posts((await anext(stream),)) == [(CREATED, str(post.id))]
        double.site.revise(double.site.users[1], post, "@quadruped stop")
        assert (await first(stream, EDITED)).post is not None
        double.site.delete(double.site.users[1], post)
        assert kinds_and_posts((await first(stream, REMOVED),)) == [(REMOVED, str(post.id))]
    await stream.aclose()  # type: ignore[attr-defined]


async def test_an_edit_of_a_post_too_old_for_the_lists_is_found_in_its_topic(
    robot: DiscourseForum, double: Double, topic: int
) -> None:
    old = double.site.posts[1]
    for n in range(60):
        late = write(double.site, topic_id=topic, raw=f"some words {n}")
        late.created_at -= timedelta(hours=1)
    after, _ = await robot.now()
    stream = robot.stream(after, 5.0)
    await anext(stream)
    double.site.revise(double.site.users[1], old, "@quadruped stop")
    old.updated_at += timedelta(seconds=5)
    event = await first(stream, EDITED)
    assert event.post is not None
    assert event.post.raw == "@quadruped stop"
    await stream.aclose()  # type: ignore[attr-defined]


async def test_law_16_each_heartbeat_is_a_response_of_the_message_bus(
    robot: DiscourseForum, double: Double, topic: int
) -> None:
    after, _ = await robot.now()
    stream = robot.stream(after, 0.05)
    async with asyncio.timeout(60):
        for _ in range(4):
            assert (await anext(stream)).kind is EventKind.HEARTBEAT
    assert double.count("POST", "/message-bus/[0-9a-f]+/poll") >= 4
    await stream.aclose()  # type: ignore[attr-defined]


async def test_law_15_a_rate_limit_does_not_end_listening(robot: DiscourseForum, double: Double, topic: int) -> None:
    double.site.settings["rate_limit_create_post"] = 60
    await robot.reply(str(topic), "one", key="1")
    with pytest.raises(ForumLimited):
        await robot.reply(str(topic), "two", key="2")
    after, _ = await robot.now()
    stream = robot.stream(after, 0.05)
    for _ in range(3):
        assert (await anext(stream)).kind is EventKind.HEARTBEAT
    post = write(double.site, topic_id=topic, raw="@quadruped stop")
    assert kinds_and_posts((await first(stream, CREATED),)) == [(CREATED, str(post.id))]
    await stream.aclose()  # type: ignore[attr-defined]


async def test_push_works_with_a_session_as_with_a_key(world: DiscourseWorld, double: Double, topic: int) -> None:
    await world.sign_in("alice")
    forum = world.at(world.url, f"login:alice:{PASSWORD}")
    after, _ = await forum.now()
    stream = forum.stream(after, 0.05)
    await first(stream, EventKind.HEARTBEAT)
    post = write(double.site, topic_id=topic, raw="some words")
    assert kinds_and_posts((await first(stream, CREATED),)) == [(CREATED, str(post.id))]
    await stream.aclose()  # type: ignore[attr-defined]


@pytest.mark.parametrize("how", ["limited", "suspended"])
async def test_law_16_a_key_that_the_bus_silently_ignores_ends_the_stream(
    how: str, world: DiscourseWorld, double: Double
) -> None:
    """The message bus treats a limited or rejected key as anonymous, and omits what anonymous accounts may not read."""
    board = double.site.add_category("Inside", "inside", only=world.groups["robot-agents"])
    robot = await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    post = write(double.site, title="A topic", category=board.id, raw="the first post")
    after, _ = await robot.now()
    stream = robot.stream(after, 0.1)
    write(double.site, topic_id=post.topic, raw="@quadruped walk")
    assert (await first(stream, CREATED)).post is not None
    await first(stream, EventKind.HEARTBEAT)
    if how == "suspended":
        await world.suspend("quadruped")
    else:
        double.site.settings["max_admin_api_reqs_per_minute"] = 1
    double.site.bus._waiting.clear()  # the held request was accepted before
    write(double.site, topic_id=post.topic, raw="@quadruped stop")
    with pytest.raises(ForumDenied if how == "suspended" else ForumLimited):
        await first(stream, CREATED)


@pytest.mark.parametrize("interval_s", [0.0, 0.2])
async def test_long_polling_requests_that_end_are_renewed(
    interval_s: float, robot: DiscourseForum, double: Double, topic: int
) -> None:
    """A real Discourse ends them every 25 seconds, and at once if long polling is disabled."""
    double.site.settings["long_polling_interval_s"] = interval_s
    after, _ = await robot.now()
    stream = robot.stream(after, 0.1)
    async with asyncio.timeout(60):
        for _ in range(5):
            assert (await anext(stream)).kind is EventKind.HEARTBEAT
        for n in range(3):
            post = write(double.site, topic_id=topic, raw=f"some words {n}")
            assert (await first(stream, CREATED)).post is not None
            assert double.site.posts[post.id].number > 1
    await stream.aclose()  # type: ignore[attr-defined]


async def test_a_stream_ends_when_the_forum_stops(robot: DiscourseForum, double: Double, topic: int) -> None:
    after, _ = await robot.now()
    stream = robot.stream(after, 0.05)
    await anext(stream)
    robot._client._http.base_url = "http://127.0.0.1:9"
    with pytest.raises(ForumUnreachable):
        await first(stream, CREATED)


async def test_the_bus_is_parsed_from_chunks() -> None:
    """Proxies may split chunks anywhere, a separator within a message is doubled, and positions ahead of the server are
    corrected."""
    client = DiscourseClient("http://127.0.0.1:9", Credentials.of("alice:key"))
    bus = MessageBusClient(client)
    bus.listen_to(["7"])
    message = {"channel": "/topic/7", "message_id": 5, "data": {"id": 12, "type": "revised", "by": "a\r\n|\r\nb"}}
    status = {"channel": "/__status", "message_id": -1, "data": {"/latest": 40, "/topic/7": 4}}
    other = {"channel": "/topic/8", "message_id": 9, "data": {"id": 99}}
    whole = "".join(
        json.dumps(part).replace("\\r\\n|\\r\\n", "\r\n||\r\n") + "\r\n|\r\n" for part in ([], [status], [other])
    )
    whole += json.dumps([message]) + "\r\n|\r\n"
    asked: list[object] = []

    class Pieces:
        """A stream of three characters per chunk, once; the second request is never answered."""

        async def __aenter__(self) -> AsyncIterator[str]:
            async def pieces() -> AsyncIterator[str]:
                for start in range(0, len(whole), 3):
                    yield whole[start : start + 3]

            if len(asked) > 1:
                await asyncio.Event().wait()
            return pieces()

        async def __aexit__(self, *_: object) -> None: ...

    def stream(_: str, body: object) -> Pieces:
        asked.append(body)
        return Pieces()

    client.stream = stream  # type: ignore[method-assign, assignment]
    held = asyncio.create_task(bus.hold())
    async with asyncio.timeout(60):
        await bus.rang.wait()
    assert asked[0] == {"/latest": -1, "/topic/7": -1, "__seq": 1}
    assert bus.hints() == {12}
    assert bus._asked() == {"/latest": 40, "/topic/7": 5, "__seq": 2}
    held.cancel()
    await client.close()


def test_a_forum_is_found_by_its_kind() -> None:
    """The entry point in pyproject.toml names the adapter."""
    text = (Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8")
    assert 'discourse = "agentrob.forums.discourse.forum:DiscourseForum"' in text
    assert DiscourseForum(ForumConfig(kind="discourse", url="http://127.0.0.1:9"), "a:b").max_edits is None
