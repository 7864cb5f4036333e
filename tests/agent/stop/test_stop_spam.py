"""Ten accounts post stops as fast as they can (law 15): they end what runs, and delay nobody else."""

from __future__ import annotations

import asyncio
import threading
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.agent.stop.replies import FOLD_S
from agentrob.board.db.writer import MAX_WAITING
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from agentrob.model import ActionResult, Post, Primitive, Role, StopResult
from agentrob.robots.driver.client import DriverClient
from tests.agent.agent_scene import FINAL, ROBOT, Driver, Scene, robot_settings, serving
from tests.board.running_board import LIMIT_S, RunningBoard, running_board
from tests.waiting import until, walks

SHOUTERS, TIMES = 10, 24
#: Moderators are told once, after the third stop.
NOTICE = "times within 5 minutes"
COMMAND, LATER = f"@{ROBOT} walk forward 5 metres", f"@{ROBOT} turn left 30 degrees"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    """Return a scene in real time, so that there is a motion to stop."""
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings(options={"time_scale": 1}), name="shouted-at")
    yield made
    made.end()


class LoggingClient(DriverClient):
    """Records in order what the agent requested from the driver."""

    def __init__(self, driver: Driver) -> None:
        super().__init__(driver.name, driver.socket)
        self.log: list[str] = []

    async def stop(self, by: str, *, running_only: bool = False) -> StopResult:
        self.log.append("stop")
        return await super().stop(by, running_only=running_only)

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        self.log.append(str(primitive.op))
        return await super().step(lease, primitive, deadline_s)


async def until_it_walks(driver: Driver) -> None:
    async with driver.client() as client:
        await until(client.state, walks)


# ---------------------------------------------------------------------- the memory forum
async def post_every_stop(scene: Scene, name: str, running: Post, shared: Post) -> int:
    """Post every form of a stop in four threads; return how many stop posts and presses there were."""
    forum = scene.person(name, Role.MEMBER)
    own = await scene.post(name, "My own thread")
    for n in range(TIMES):
        match n % 5:
            case 0:
                await scene.post(name, "Stop!", topic=running.topic_id)
            case 1:
                await scene.post(name, f"@{ROBOT} stop it now", topic=shared.topic_id)
            case 2:
                talk = await scene.post(name, "Nice weather", topic=shared.topic_id)
                await forum.edit(talk.id, f"@{ROBOT} 停下")
            case 3:
                await scene.post(name, f"@{ROBOT} freeze!", topic=own.topic_id)
            case 4:
                await forum.press_stop(ROBOT)
        await asyncio.sleep(0)
    return TIMES


async def test_law_15_ten_accounts_that_shout_stop_end_it_once_and_delay_nobody(scene: Scene) -> None:
    scene.person("eve")
    client = LoggingClient(scene.driver)
    async with scene.agent(driver=client):
        shared = await scene.post("bob", "Let us talk")
        running = await scene.post("alice", COMMAND)
        await scene.state(running, "running")
        await until_it_walks(scene.driver)
        before, began_s = len(scene.world.events), time.monotonic()
        await scene.post("bob", "stop", topic=running.topic_id)
        shouted = await asyncio.gather(
            *(post_every_stop(scene, f"shouter{n}", running, shared) for n in range(SHOUTERS))
        )
        assert sum(shouted) >= 200
        # Without waiting: the eleventh account posts while most of the stops are not read yet.
        later = await scene.post("eve", LATER)
        done = await scene.until(lambda: [p for p in scene.replies(later) if p.card and p.card.state in FINAL])
        assert [reply.card.state for reply in done] == ["done"]
        ended = await scene.final(running)
    assert ended.card.state == "stopped"
    assert "**Stopped** by `bob`" in ended.raw  # by the first stop, at once
    ours = [e.post for e in scene.world.events[before:] if e.post is not None and e.post.author.name == ROBOT]
    robots = [p for p in scene.world.posts.values() if p.author.name == ROBOT]
    written = Counter(p.topic_id for p in robots if NOTICE not in p.raw)
    assert sum(NOTICE in p.raw for p in robots) == 1
    threads = set(written) - {running.topic_id, later.topic_id}
    assert written[running.topic_id] <= 2  # the command's own reply, and one for all stops
    assert all(written[topic] == 1 for topic in threads)
    assert len(threads) == SHOUTERS + 1
    # However many stops there are, a reply is updated at most once a second.
    most = 2 + (time.monotonic() - began_s) / FOLD_S
    assert all(count <= most for count in Counter(post.id for post in ours if post.card is None).values())
    assert client.log[0] == "move"
    assert client.log[-1] == "turn"
    assert set(client.log[1:-1]) == {"stop"}


# ---------------------------------------------------------------------- the real board
def post_every_stop_to_board(board: RunningBoard, name: str, running: str) -> list[httpx2.Response]:
    """The same over HTTP; returns every response."""
    client, got = board.client(name), list[httpx2.Response]()

    def send(method: str, path: str, **body: Any) -> dict[str, Any]:
        got.append(client.request(method, path, json=body or None))
        answer: dict[str, Any] = got[-1].json()
        return answer

    topic = send("POST", "/topics", board_id="robots", title="Mine", body="My own thread")["topic"]["id"]
    for n in range(TIMES):
        match n % 4:
            case 0:
                send("POST", f"/topics/{running}/posts", body="Stop!")
            case 1:
                send("POST", f"/topics/{topic}/posts", body=f"@{ROBOT} stop")
            case 2:
                post = send("POST", f"/topics/{topic}/posts", body="Nice weather")["post"]["id"]
                send("PATCH", f"/posts/{post}", body=f"@{ROBOT} stop")
            case 3:
                send("POST", f"/robots/{ROBOT}/stop")
    return got


async def board_answer(client: httpx2.Client, topic: str, states: set[str]) -> dict[str, Any]:
    async with asyncio.timeout(60):
        while True:
            posts = (await asyncio.to_thread(client.get, f"/topics/{topic}/posts")).json()["items"]
            for post in posts:
                if post["author"]["name"] == ROBOT and post["card"] and post["card"]["state"] in states:
                    found: dict[str, Any] = post
                    return found
            await asyncio.sleep(0.05)


async def test_law_15_the_board_takes_every_stop_of_ten_accounts_and_the_next_command(
    driver: Driver, tmp_path: Path
) -> None:
    with running_board(tmp_path / "board") as board:
        names = [f"shouter{n}" for n in range(SHOUTERS)]
        for name in names:
            board.add(name)
        client = LoggingClient(driver)
        forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
        async with serving(RobotAgent(ROBOT, robot_settings(), forum, client, RulesMind(), tmp_path)):
            op = board.client("op")
            running = op.post("/topics", json={"board_id": "robots", "title": "Walk", "body": COMMAND}).json()["topic"][
                "id"
            ]
            await board_answer(op, running, {"running"})
            await until_it_walks(driver)
            answers = await asyncio.gather(
                *(asyncio.to_thread(post_every_stop_to_board, board, name, running) for name in names)
            )
            refused = [answer.text for got in answers for answer in got if answer.status_code not in (200, 201)]
            assert refused == []
            body = {"board_id": "robots", "title": "Turn", "body": LATER}
            later = op.post("/topics", json=body).json()["topic"]["id"]
            assert (await board_answer(op, later, FINAL))["card"]["state"] == "done"
            assert (await board_answer(op, running, FINAL))["card"]["state"] == "stopped"
            topics = op.get("/boards/robots/topics").json()["items"]
            for topic in topics:
                posts = op.get(f"/topics/{topic['id']}/posts", params={"limit": 100}).json()["items"]
                ours = [post for post in posts if post["author"]["name"] == ROBOT and NOTICE not in post["raw"]]
                assert len(ours) <= (2 if topic["id"] == running else 1), topic
    assert client.log[0] == "move"
    assert client.log[-1] == "turn"
    assert set(client.log[1:-1]) == {"stop"}


async def test_law_15_a_board_that_refuses_posts_since_too_many_wait_still_takes_a_stop(tmp_path: Path) -> None:
    with running_board(tmp_path) as board:
        client, begun, free = board.client("member"), threading.Event(), threading.Event()
        writer = board.services.store.writer
        talk = client.post("/topics", json={"board_id": "robots", "title": "Talk", "body": "Nice weather"}).json()
        topic, own = talk["topic"]["id"], talk["post"]["id"]

        async def fill() -> None:
            waiting.append(asyncio.ensure_future(writer.do(lambda _: begun.set() or free.wait(LIMIT_S))))
            await asyncio.to_thread(begun.wait, LIMIT_S)
            for _ in range(MAX_WAITING + 1):
                waiting.append(asyncio.ensure_future(writer.do(lambda _: True)))
            await asyncio.sleep(0)

        def queued() -> int:
            return len(writer._first) + len(writer._rest)

        waiting: list[asyncio.Future[Any]] = []
        await asyncio.to_thread(board.run, fill())
        assert begun.is_set()
        full = queued()
        refused = await asyncio.to_thread(client.post, f"/topics/{topic}/posts", json={"body": "Hello again"})
        assert refused.status_code == 503
        assert refused.json()["code"] == "overloaded"
        stop = {"body": f"@{ROBOT} stop"}
        sent = [
            asyncio.create_task(asyncio.to_thread(board.client("op").request, method, path, json=body))
            for method, path, body in (
                ("POST", f"/topics/{topic}/posts", {"body": "停"}),
                ("POST", "/topics", {"board_id": "robots", "title": "Stop", **stop}),
            )
        ]
        sent.append(asyncio.create_task(asyncio.to_thread(client.patch, f"/posts/{own}", json=stop)))
        pressed = await asyncio.to_thread(board.client("admin").post, f"/robots/{ROBOT}/stop")
        assert pressed.status_code in (200, 201, 202)  # and at once, without waiting for any write
        await until(lambda: queued() >= full + len(sent) or any(task.done() for task in sent), limit_s=LIMIT_S)
        free.set()
        assert {answer.status_code for answer in await asyncio.gather(*sent)} <= {200, 201}
