"""No post can end a listener (law 15): after hostile bodies, marks, cards and events a stop is still received."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator, Callable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import httpx2
import pytest
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from agentrob.agent.agent import RobotAgent
from agentrob.agent.intake.event_stream import EventStream
from agentrob.agent.intake.triage import Addressing, Route, triage
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.forums.discourse import markers as discourse_markers
from agentrob.forums.discourse.forum import DiscourseForum
from agentrob.forums.memory.forum import MemoryForum
from agentrob.forums.nodebb import markers as nodebb_markers
from agentrob.forums.nodebb.forum import NodeBBForum
from agentrob.forums.protocol import Event, Forum
from agentrob.mcp.adapter import McpForum
from agentrob.mcp.client import ForumClient
from agentrob.minds.rules import RulesMind
from agentrob.model import Account, AccountKind, EventKind, Post, Role
from tests.agent.agent_scene import FINAL, ROBOT, Driver, make_scene, robot_settings, serving
from tests.forums.discourse.discourse_world import Double, double_world
from tests.forums.hostile_posts import BODIES, CODES, HOSTILE_JSON, code, discourse_mark, malformed, nodebb_mark

FUZZ = settings(
    max_examples=60,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
)
NOW = datetime.now(UTC)


async def hears_a_stop(forum: Forum, cursor: str) -> None:
    """Assert that an agent's listener on this forum receives the stop that comes after everything else."""
    me = Account("1", ROBOT, AccountKind.ROBOT_AGENT)
    async with asyncio.timeout(60):
        async for event in EventStream(forum, cursor, poll_s=0.1).events():
            if event.post is None or event.kind is EventKind.POST_REMOVED:
                continue
            assert len(event.post.content_hash) == 64
            ears = Addressing(me, {ROBOT}, {"robots"}, NOW - timedelta(days=1), datetime.now(UTC), 120.0)
            if event.post.raw == f"@{ROBOT} stop":
                assert triage(event.post, ears).route is Route.STOP
                return
            triage(event.post, ears)


# ---------------------------------------------------------------------- marks
@pytest.mark.parametrize("told", HOSTILE_JSON)
def test_a_hostile_mark_is_text_and_no_key_or_card(told: str) -> None:
    for module, made in ((nodebb_markers, nodebb_mark), (discourse_markers, discourse_mark)):
        for ours in (True, False):
            found = module.unmark(made(code(told)), ours)
            assert found.card is None
            assert found.pictures == ()
            assert found.text.startswith("words")


@given(CODES, st.booleans())
def test_the_text_is_read_whatever_the_mark_contains(word: str, ours: bool) -> None:
    for module, made in ((nodebb_markers, nodebb_mark), (discourse_markers, discourse_mark)):
        assert module.unmark(made(word), ours).text.startswith("words")


def test_the_mark_of_a_stranger_is_never_decoded() -> None:
    ours = nodebb_markers.mark(nodebb_markers.MarkedText("words", "key", None, ("/assets/uploads/1.png",)))
    assert nodebb_markers.unmark(ours, ours=False) == nodebb_markers.MarkedText(
        "words", None, None, ("/assets/uploads/1.png",)
    )


@pytest.mark.parametrize("body", ["\n" * 32_000 + "x", "![](" * 8_000, "[//]: # (agentrob:a)\n" * 1_500, "`" * 32_000])
def test_searching_any_body_for_a_mark_is_fast(body: str) -> None:
    began = time.process_time()
    for module in (nodebb_markers, discourse_markers):
        module.unmark(body)
    nodebb_markers.pictures_in(body)
    nodebb_markers.names_in(body)
    assert time.process_time() - began < 1.0


# ---------------------------------------------------------------------- NodeBB
async def _known() -> None:
    """Use a clock that is already set, so that the adapter does not ask for the server's time."""


class NodeBBDouble:
    """The endpoints of a NodeBB that a listener uses; `spoil` changes its data about one post."""

    def __init__(self, bodies: list[str]) -> None:
        at_ms = int(datetime.now(UTC).timestamp() * 1000)
        self.stored = {
            n: {"pid": n, "tid": 1, "uid": 7, "content": body, "timestamp": at_ms + n, "deleted": 0}
            for n, body in enumerate(bodies, 1)
        }
        self.shown = {
            n: {"topic": {"cid": 1}, "user": {"userslug": "alice"}, "content": f"<p>{p['content']}</p>"}
            for n, p in self.stored.items()
        }
        self.listed = {
            n: {"pid": n, "tid": 1, "topic": {"cid": 1}, "timestamp": p["timestamp"], "content": p["content"]}
            for n, p in self.stored.items()
        }
        #: Posts from before the listener started are not delivered.
        self.until = 0

    def forum(self) -> NodeBBForum:
        forum = NodeBBForum(ForumConfig(kind="nodebb", url="http://127.0.0.1:9"), "token")
        forum._client.clock.add(NOW, NOW, NOW)
        forum._client.set_clock = _known  # type: ignore[method-assign]
        forum._client._http = httpx2.AsyncClient(transport=httpx2.MockTransport(self.answer), base_url="http://forum")
        return forum

    def answer(self, request: httpx2.Request) -> httpx2.Response:
        path = request.url.path
        if path == "/api/recent/posts":
            rows = [row for n, row in sorted(self.listed.items(), reverse=True) if n <= self.until]
            return self._json(rows if request.url.params["page"] == "1" else [])
        if path.startswith("/api/v3/posts/"):
            number, _, what = path.removeprefix("/api/v3/posts/").partition("/")
            return self._json({"response": (self.shown if what == "summary" else self.stored)[int(number)]})
        slug = path.removeprefix("/api/user/").partition("/")[0]
        uid = {"alice": 7, ROBOT: 8}.get(slug, 9)
        return self._json({
            "userslug": ROBOT if path == "/api/self" else slug, "uid": uid, "username": slug, "groups": [],
            "categories": [{"cid": 1, "handle": "robots", "name": "Robots"}],
        })  # fmt: skip

    @staticmethod
    def _json(told: Any) -> httpx2.Response:
        headers = {"content-type": "application/json"}
        return httpx2.Response(200, content=json.dumps(told).encode("utf-8", "surrogatepass"), headers=headers)


async def _nodebb_hears(double: NodeBBDouble) -> None:
    forum = double.forum()
    before, _ = await forum._tracker.newest(), double.until
    double.until = len(double.stored)
    await hears_a_stop(forum, before)
    await hears_a_stop(double.forum(), before)  # and so does a restarted agent
    await forum.close()


async def test_law_15_on_nodebb_a_stop_is_heard_after_posts_with_every_hostile_body() -> None:
    await _nodebb_hears(NodeBBDouble([*BODIES, f"@{ROBOT} stop"]))


@FUZZ
@given(st.data())
def test_law_15_on_nodebb_a_stop_is_heard_after_malformed_data_about_another_post(data: st.DataObject) -> None:
    double = NodeBBDouble(["hello", "again", f"@{ROBOT} stop"])
    for rows in (double.stored, double.shown, double.listed):
        if data.draw(st.booleans()):
            rows[2] = data.draw(malformed(rows[2]))
    asyncio.run(_nodebb_hears(double))


# ---------------------------------------------------------------------- Discourse
@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings())
    yield made
    made.end()


def _final(double: Double, text: str) -> str:
    """Return the state on the robot's card in reply to the post with this text."""
    posts = double.site.posts.values()
    asked = next((p for p in posts if p.raw.startswith(text)), None)
    for post in posts:
        card = discourse_markers.unmark(post.raw).card
        if asked and card and card.state in FINAL and post.topic == asked.topic and post.reply_to == asked.number:
            return card.state
    return ""


async def _until(reader: DiscourseForum, found: Callable[[], str]) -> str:
    """Wait until a condition on the forum holds, checking it after each write."""
    after, _ = await reader.now()
    async with asyncio.timeout(60):
        async for _ in reader.stream(after, 0.25):
            if state := found():
                return state
    raise AssertionError("the stream ended")


async def test_law_15_on_discourse_an_agent_stops_its_robot_and_restarts_despite_hostile_posts(
    driver: Driver, tmp_path: Path
) -> None:
    async with double_world() as (world, double):
        alice = await world.sign_in("alice", role=Role.OPERATOR)
        robot = await world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)

        def agent(forum: DiscourseForum) -> RobotAgent:
            return RobotAgent(ROBOT, robot_settings(), forum, driver.client(), RulesMind(), tmp_path)

        async with serving(agent(robot)):
            walk = (
                await alice.create_topic("robots", "A far walk", "@quadruped walk forward 5 m, then back", key="1")
            ).post
            for body in BODIES[len(HOSTILE_JSON) // 2 :]:
                told = body.encode("utf-8", "replace").decode() or "."  # Discourse keeps no lone surrogates
                double.site.write(double.site.users[1], {"topic_id": int(walk.topic_id), "raw": told})
            await alice.reply(walk.topic_id, "@quadruped stop", key="2")
            assert await _until(alice, lambda: _final(double, "@quadruped walk forward 5 m")) in (
                "stopped",
                "cancelled",
            )
        async with serving(agent(await world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT))):
            await alice.create_topic("robots", "Another walk", "@quadruped walk forward 1 m", key="3")
            assert await _until(alice, lambda: _final(double, "@quadruped walk forward 1 m")) == "done"


# ---------------------------------------------------------------------- our board
_POST = {
    "id": "2", "topic_id": "1", "board_id": "robots", "raw": "hello", "created_at": NOW.isoformat(), "version": 1,
    "author": {"id": "7", "name": "alice", "kind": "human", "role": "operator"}, "mentions": [], "images": [],
    "card": {"robot": ROBOT, "state": "done", "step": 1},
}  # fmt: skip


def _event(number: int, post: dict[str, Any]) -> dict[str, Any]:
    return {"id": str(number), "kind": "post.created", "at": NOW.isoformat(), "post": post}


def _board(events: list[Any], streamed: bool) -> BoardForum:
    async def answer(request: httpx2.Request) -> httpx2.Response:
        if request.url.path.endswith("/events"):
            kinds = [e.get("kind", "post.created") if isinstance(e, dict) else "post.created" for e in events]
            told = [
                (k if isinstance(k, str) and k.isascii() else "post.created", e)
                for k, e in zip(kinds, events, strict=True)
            ]
            sent = "".join(f"event: {' '.join(k.split())}\ndata: {json.dumps(e)}\n\n" for k, e in told)
            return httpx2.Response(200, content=sent.encode(), headers={"content-type": "text/event-stream"})
        if "after" in request.url.params:
            return httpx2.Response(200, content=json.dumps({"items": events}).encode())
        return httpx2.Response(200, content=json.dumps({"now": {"id": "0", "at": NOW.isoformat()}}).encode())

    forum = BoardForum(ForumConfig(url="http://board"), "token")
    forum._http = httpx2.AsyncClient(transport=httpx2.MockTransport(answer), base_url="http://board/api/v1")
    forum.live = streamed
    return forum


@FUZZ
@given(malformed(_event(1, _POST)), st.booleans())
@example(_event(1, {**_POST, "card": {"step": float("inf")}}), True)
@example(_event(1, {**_POST, "raw": "\ud800"}), False)
def test_law_15_on_our_board_a_stop_is_heard_after_any_event(event: dict[str, Any], streamed: bool) -> None:
    stop = _event(2, {**_POST, "id": "3", "raw": f"@{ROBOT} stop", "card": None})
    asyncio.run(hears_a_stop(_board([event, stop], streamed), "0"))


# ---------------------------------------------------------------------- behind an MCP server
class _Server:
    """A client whose server sends these events, at once and endlessly."""

    def __init__(self, events: list[Any]) -> None:
        self._told = json.dumps({"events": events, "at": NOW.isoformat()})

    def client(self) -> ForumClient:
        client = ForumClient(lambda: None)  # type: ignore[arg-type,return-value]

        async def contents(uri: str, limit_s: float | None) -> list[Any]:
            facts = {"account": {"id": "1", "name": ROBOT}, "event": "0", "at": NOW.isoformat(), "live": True}
            text = json.dumps(facts) if uri.endswith("/me") else self._told
            return [type("Content", (), {"text": text})()]

        client._contents = contents  # type: ignore[method-assign]
        return client


@FUZZ
@given(malformed(_event(1, {**_POST, "body": "hello"})), st.booleans())
@example(_event(1, {**_POST, "body": "\ud800"}), True)
@example(_event(1, {**_POST, "body": "x", "card": {"robot": 1, "state": float("inf")}}), True)
def test_law_15_behind_mcp_a_stop_is_heard_after_any_event(event: dict[str, Any], live: bool) -> None:
    stop = _event(2, {**_POST, "id": "3", "body": f"@{ROBOT} stop", "card": None})
    forum = McpForum.from_client(_Server([event, stop]).client())
    forum.live = live
    asyncio.run(hears_a_stop(forum, "0"))


# ---------------------------------------------------------------------- in memory, and third-party adapters
async def test_law_15_an_agent_hears_a_stop_after_posts_with_every_hostile_body(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)
    async with scene.agent():
        walk = await scene.post("alice", "@quadruped walk forward 5 m, then back")
        for body in BODIES:
            await scene.post("bob", f"@quadruped {body}", walk.topic_id)
            await scene.post("bob", body, walk.topic_id)
        await scene.post("bob", "@quadruped stop", walk.topic_id)
        assert (await scene.final(walk)).card.state in ("stopped", "cancelled")  # type: ignore[union-attr]
        again = await scene.post("alice", "@quadruped walk forward 1 m")
        assert (await scene.final(again)).card.state == "done"  # type: ignore[union-attr]


class _UnreliableForum(MemoryForum):
    """A third party's adapter that sometimes raises arbitrary errors and delivers values that are not posts."""

    moods: Iterator[Exception]

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        if (mood := next(self.moods, None)) is not None:
            raise mood
        async for event in super().stream(after, heartbeat_s):
            if event.post is not None and event.post.raw == "nonsense":
                broken = Post("9", "1", "robots", event.post.author, None, event.at)  # type: ignore[arg-type]
                yield Event(event.id, event.kind, event.at, post=broken)
            else:
                yield event


async def test_law_15_the_agent_keeps_listening_whatever_an_adapter_raises(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)
    forum = _UnreliableForum(scene.world, ROBOT)
    forum.moods = iter([RecursionError("deep"), OverflowError("infinity"), RuntimeError("bug")])
    async with scene.agent(forum=forum):
        walk = await scene.post("alice", "@quadruped walk forward 5 m, then back")
        await scene.post("bob", "nonsense", walk.topic_id)
        await scene.post("bob", "@quadruped stop", walk.topic_id)
        assert (await scene.final(walk)).card.state in ("stopped", "cancelled")  # type: ignore[union-attr]


# ---------------------------------------------------------------------- cards
def test_law_1_a_card_of_another_robot_is_ignored_on_an_old_board_and_behind_mcp() -> None:
    """The board refuses such a card, but an earlier version or another server may deliver one."""
    for kind, card, counts in (
        ("robot_agent", {"robot": ROBOT, "state": "done"}, True),
        ("robot_agent", {"robot": "humanoid", "state": "done"}, False),
        ("human", {"robot": ROBOT, "state": "done"}, False),
    ):
        author = {"id": "8", "name": ROBOT, "kind": kind, "role": "member"}
        told = _event(1, {**_POST, "author": author, "card": card})

        async def read(forum: Forum) -> list[Event]:
            return list(await forum.changes("0"))

        over = _event(1, {**_POST, "author": author, "card": card, "body": "hello"})
        for forum in (_board([told], streamed=False), McpForum.from_client(_Server([over]).client())):
            (event,) = asyncio.run(read(forum))
            assert event.post is not None
            assert (event.post.card is not None) is counts, (forum, kind, card)
