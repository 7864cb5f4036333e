"""The adapters' memory does not grow with the number of posts, and what they forgot is not written twice."""

from __future__ import annotations

import asyncio
from collections import Counter
from typing import Any

import httpx2
import pytest

from agentrob.config.forum import ForumConfig
from agentrob.forums.bounded import BoundedDict
from agentrob.forums.discourse import forum as discourse
from agentrob.forums.discourse import mapping, writer
from agentrob.forums.nodebb import accounts
from agentrob.forums.nodebb import forum as nodebb
from agentrob.forums.nodebb import posts as nodebb_posts
from agentrob.forums.nodebb.clock import HeaderClock
from agentrob.forums.nodebb.markers import MarkedText, mark
from agentrob.forums.nodebb.settings import Credentials
from tests.forums.discourse.discourse_world import DiscourseWorld, Double, begin, texts

KEPT = 3


def too_many(*parts: object) -> dict[str, int]:
    """Return the containers of these objects that hold too many entries, with their sizes; boards are not counted."""
    held = {(type(part).__name__, name): value for part in parts for name, value in vars(part).items()}
    containers = {name: v for name, v in held.items() if isinstance(v, dict | list | set | BoundedDict)}
    return {".".join(name): len(v) for name, v in containers.items() if len(v) > KEPT and name[1] != "_boards"}


def test_a_bounded_dictionary_drops_the_oldest_entry() -> None:
    kept = BoundedDict[str, int](2)
    kept["a"], kept["b"] = 1, 2
    assert kept["a"] == 1  # a read does not renew an entry
    kept["c"] = 3
    assert dict(kept) == {"b": 2, "c": 3}
    kept["b"] = 4
    kept.update(d=5)
    assert dict(kept) == {"b": 4, "d": 5}


def test_the_oldest_post_of_a_key_is_kept_until_it_is_dropped() -> None:
    read = writer.ReadPosts(KEPT)
    read[8] = "k"
    read[5] = "k"
    assert read.first("k") == 5
    for number in range(10, 10 + KEPT):
        read[number] = None
    assert (read.first("k"), len(read), read._first) == (None, KEPT, {})


@pytest.fixture
def small_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(discourse, "_KEPT", KEPT)
    monkeypatch.setattr(discourse, "MOST_KNOWN", KEPT)
    monkeypatch.setattr(mapping, "_KEPT", KEPT)
    monkeypatch.setattr(writer, "_KEPT", KEPT)
    monkeypatch.setattr(writer, "_KEPT_TURNS", KEPT)


@pytest.mark.usefixtures("small_limits")
async def test_law_6_a_discourse_adapter_finds_posts_it_no_longer_remembers(
    world: DiscourseWorld, double: Double
) -> None:
    robot = await world.sign_in("quadruped")
    topics = [await begin(robot, f"begin {n}") for n in range(3 * KEPT)]
    for topic in topics:
        await robot.reply(topic, "Done.", key=f"reply:{topic}")
    assert too_many(robot, robot._writer, robot._versions) == {}
    again = await robot.reply(topics[0], "Done.", key=f"reply:{topics[0]}")
    assert not again.created
    assert await texts(robot, topics[0]) == ["hello there", "Done."]
    assert len(double.site.posts) == 2 * len(topics)


# ---------------------------------------------------------------------- NodeBB
class NodeBBClientDouble:
    """A NodeBB client that answers without a server and counts requests."""

    url, credentials, clock = "http://127.0.0.1", Credentials.of("login:quadruped:secret"), HeaderClock()

    def __init__(self) -> None:
        self.asked: Counter[str] = Counter()

    async def get(self, path: str, **_: object) -> dict[str, Any]:
        self.asked[path] += 1
        slug = path.split("/")[3]
        return {"uid": 1, "userslug": slug, "username": slug, "groups": []}

    async def get_v3(self, path: str) -> dict[str, Any]:
        self.asked[path] += 1
        return {"content": mark(MarkedText("Done.", f"key of {path}"))}

    async def ask(self, method: str, path: str, files: Any) -> httpx2.Response:
        self.asked[path] += 1
        return httpx2.Response(200, json={"response": {"images": [{"url": f"/assets/uploads/{self.asked[path]}.png"}]}})


async def test_a_nodebb_adapters_caches_are_bounded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in (nodebb, accounts, nodebb_posts):
        monkeypatch.setattr(module, "MOST_KNOWN", KEPT)
    client, many = NodeBBClientDouble(), range(3 * KEPT)
    monkeypatch.setattr(nodebb, "NodeBBClient", lambda url, credentials: client)
    forum = nodebb.NodeBBForum(ForumConfig(kind="nodebb"), "login:quadruped:secret")
    monkeypatch.setattr(forum, "post", lambda pid: asyncio.sleep(0, pid))
    places = await forum._upload([b"\x89PNG %d" % n for n in many])
    assert places == tuple(f"/assets/uploads/{n + 1}.png" for n in many), "also of pictures that are forgotten already"
    assert await forum._upload([b"\x89PNG %d" % many[-1]]) == places[-1:], "sent once"
    for n in many:
        await forum._written({"pid": n}, f"key {n}", "pid")
        await forum._reader._key_of(str(n))
        await forum._admin.by_slug(f"name-{n}")
    assert too_many(forum, forum._reader, forum._admin) == {}
    for n in (0, many[-1]):
        assert await forum._reader._key_of(str(n)) == f"key of /posts/{n}"
    assert (client.asked["/posts/0"], client.asked[f"/posts/{many[-1]}"]) == (2, 1)
