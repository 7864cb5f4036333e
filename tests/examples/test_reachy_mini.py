"""From a post to its report, in both languages: a forum, an agent, a driver process, and the simulated daemon."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from agentrob_reachy_mini.simulated_daemon import SimulatedDaemon

from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings

MODEL = "reachy-mini-sim"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    listening = socket.create_server(("127.0.0.1", 0))
    daemon = SimulatedDaemon(listening)
    settings = robot_settings(model=MODEL).model_copy(
        update={"options": {"url": f"http://127.0.0.1:{listening.getsockname()[1]}"}}
    )
    driver = Driver(tmp_path_factory.mktemp("driver"), settings)
    yield driver
    driver.end()
    daemon.close()
    listening.close()


@pytest.fixture
def scene(driver: Driver, tmp_path: Path) -> Scene:
    return make_scene(driver, tmp_path, model=MODEL)


@pytest.mark.parametrize(
    ("post", "did", "row"),
    [
        ("nod", "nodded", r"\| nod \| 1[345]\.\d° "),
        ("点点头", "点了头", r"\| 点点头 \| 1[345]\.\d° "),
        ("look up 15 degrees", "looked up", r"\| look up 15 degrees \| 1[45]"),
        ("抬头15度", "抬了头", r"\| 抬头 15 度 \| 1[45]"),
        ("turn left 20 degrees", "turned left", r"\| turn left 20° \| (19|20)"),
        ("身体右转20度", "右转", r"\| 右转 20° \| (19|20)"),
        ("sway for 3 seconds", "swayed", r"\| sway for 3 seconds \| [234]\.\d s"),
    ],
)
async def test_a_post_is_carried_out_and_reported_with_what_was_measured(
    scene: Scene, post: str, did: str, row: str
) -> None:
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} {post}"))
    assert reply.card is not None
    assert reply.card.state == "done", reply.raw
    assert did in reply.raw
    (line,) = [line for line in reply.raw.splitlines() if line.startswith("| 1 |")]
    assert re.search(row, line), line


@pytest.mark.parametrize(
    ("post", "state", "said"),
    [
        ("walk 1 m", "refused", "walk"),
        ("走1米", "refused", "走"),
        ("look up 80 degrees", "refused", "80° is beyond what “look up” allows: 5 to 35°."),
        ("take a photo", "refused", "photo"),
    ],
)
async def test_what_it_cannot_do_is_said_with_what_it_can(scene: Scene, post: str, state: str, said: str) -> None:
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} {post}"))
    assert reply.card is not None
    assert reply.card.state == state, reply.raw
    assert said in reply.raw
    assert "nod" in reply.raw or "点点头" in reply.raw or "look up" in reply.raw


async def test_a_stop_ends_it(scene: Scene) -> None:
    async with scene.agent():
        asked = await scene.post("alice", f"@{ROBOT} sway for 20 seconds")
        await scene.state(asked, "running")
        await scene.post("bob", "stop", topic=asked.topic_id)
        reply = await scene.final(asked)
    assert reply.card is not None
    assert reply.card.state == "stopped", reply.raw
