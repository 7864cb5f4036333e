"""Previews of the simulated Go2: its world notes every motion, and notes none."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.forums.memory.forum import MemoryForum
from agentrob.model import AccountKind, Role
from agentrob.wiring.app import simulated_robot
from tests.agent.agent_scene import ROBOT, Driver, Scene
from tests.sim.served_world import ServedWorld, start_world

DRAWS = True
pytestmark = [pytest.mark.sim, pytest.mark.slow]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedWorld]:
    made = start_world(tmp_path_factory.mktemp("world"))
    yield made
    made.end()


@pytest.fixture
def scene(world: ServedWorld, tmp_path: Path) -> Iterator[Scene]:
    settings = simulated_robot("go2", world.domain)
    driver = Driver(tmp_path, settings)
    made = Scene(MemoryForum.world(), driver, tmp_path, settings)
    made.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)
    made.person("alice")
    yield made
    driver.end()


def motions(world: ServedWorld) -> list[str]:
    lines = [json.loads(line) for line in world.event_log.read_text().splitlines()]
    return [line["event"] for line in lines if line["event"] in ("move_begin", "action_begin", "stop_move")]


async def test_the_world_notes_no_motion_during_a_preview_and_each_of_the_walk(
    world: ServedWorld, scene: Scene
) -> None:
    async with scene.agent():
        before = motions(world)
        asked = await scene.post("alice", f"@{ROBOT} preview walk forward 1.5 m, turn left and wave")
        preview = await scene.final(asked, 150)
        assert preview.card.state == "answered", preview.raw
        assert "runs did every step." in preview.raw
        assert motions(world) == before
        post = await scene.post("alice", f"@{ROBOT} walk forward 1.5 m, turn left and wave")
        walked = await scene.final(post, 150)
        assert walked.card.state == "done", walked.raw
        assert "move_begin" in motions(world)[len(before) :]
        assert "action_begin" in motions(world)[len(before) :]
