"""From a post to its report, in both languages: a forum, an agent, a driver process, and the simulated arm's world."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.process.child import Child, terminate_all
from agentrob.sim.domains import PrivateDomain
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings

MODEL = "so101"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    folder, domain = tmp_path_factory.mktemp("driver"), PrivateDomain()
    simulator = Child("simulator", ["simulator", MODEL, "--domain", str(domain.number)], folder / "simulator.log")
    simulator.wait_ready()
    settings = robot_settings(model=MODEL).model_copy(update={"options": {}, "domain": domain.number})
    driver = Driver(folder, settings)
    yield driver
    driver.end()
    terminate_all([simulator])
    domain.close()


@pytest.fixture
def scene(driver: Driver, tmp_path: Path) -> Scene:
    return make_scene(driver, tmp_path, model=MODEL)


@pytest.mark.sim
@pytest.mark.parametrize(
    ("post", "did", "row"),
    [
        ("wave", "waved", r"\| wave \| –"),
        ("挥挥手", "挥了手", r"\| 挥手 \| –"),
        ("point left 40 degrees", "pointed left", r"\| point left 40 degrees \| (39|40)\.\d° "),
        ("指向右边", "指了右边", r"\| 指向右边 60 度 \| (59|60)\.\d° "),
        ("open the gripper to 50 percent", "opened the gripper", r"\| open the gripper 50 percent \| (49|50|51) % "),
        ("归位", "回到了初始位置", r"\| 归位 \| [012]\.\d° "),
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


@pytest.mark.sim
@pytest.mark.parametrize(
    ("post", "words"),
    [
        ("walk 1 m", "This robot cannot do this: walk forward 1 m. It can: wave"),
        ("前进1米", "这台机器人不会：向前走1米"),
    ],
)
async def test_it_does_not_walk_and_says_what_it_can_do(scene: Scene, post: str, words: str) -> None:
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} {post}"))
    assert reply.card is not None
    assert reply.card.state == "refused"
    assert words in reply.raw
