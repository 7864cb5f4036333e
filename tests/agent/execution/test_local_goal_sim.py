"""Goals without a model with the simulated Go2: it walks home by its odometry and turns to the red ball by its
camera."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest

from agentrob.config.robots import RobotConfig
from agentrob.forums.memory.forum import MemoryForum
from agentrob.model import AccountKind, Role
from tests.agent.agent_scene import ROBOT, Driver, Scene
from tests.sim.served_world import ServedWorld, start_world

DRAWS = True
BALL_M = (2.7, 0.75)

pytestmark = [pytest.mark.sim, pytest.mark.slow]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedWorld]:
    made = start_world(tmp_path_factory.mktemp("world"))
    yield made
    made.end()


@pytest.fixture
def scene(world: ServedWorld, tmp_path: Path) -> Iterator[Scene]:
    settings = RobotConfig(model="go2", domain=world.domain, simulated=True, home_on_start=True)
    driver = Driver(tmp_path, settings)
    made = Scene(MemoryForum.world(), driver, tmp_path, settings)
    made.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)
    made.person("alice")
    yield made
    driver.end()


async def test_it_turns_to_the_red_ball_walks_away_and_comes_home(world: ServedWorld, scene: Scene) -> None:
    async with httpx2.AsyncClient(base_url=world.url, timeout=100, trust_env=False) as room, scene.agent():

        async def place() -> tuple[float, float, float]:
            robot = (await room.get("/truth")).json()["robots"]["go2"]
            return robot["x_m"], robot["y_m"], math.radians(robot["yaw_deg"])

        start = await place()
        turned = await scene.final(await scene.post("alice", f"@{ROBOT} turn to the red ball"), 100)
        x_m, y_m, yaw_rad = await place()
        aside_deg = math.degrees(math.atan2(BALL_M[1] - y_m, BALL_M[0] - x_m) - yaw_rad)
        assert turned.card.state == "done", turned.raw
        assert "I turned to a red ball: measured " in turned.raw
        assert abs(aside_deg) < 8, turned.raw
        walked = await scene.final(await scene.post("alice", f"@{ROBOT} walk forward 1 m, turn left 100 degrees"), 100)
        assert walked.card.state == "done", walked.raw
        home = await scene.final(await scene.post("alice", f"@{ROBOT} come home"), 100)
        end = await place()
        assert home.card.state == "done", home.raw
        assert "m from home by my odometry" in home.raw
        assert math.dist(start[:2], end[:2]) < 0.4, home.raw
        assert abs(math.degrees(math.remainder(end[2] - start[2], math.tau))) < 20, home.raw
