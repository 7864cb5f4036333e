"""A closed loop: the simulated Go2 walks to the red ball, steered by a model over HTTP that gets its camera
pictures."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.config.robots import RobotConfig
from agentrob.forums.memory.forum import MemoryForum
from agentrob.model import AccountKind, Role
from tests.agent.agent_scene import Driver, Scene
from tests.agent.execution.visual_model import find_red, running_loop_model
from tests.sim.served_world import ServedWorld, start_world

DRAWS = True

pytestmark = [pytest.mark.sim, pytest.mark.slow, pytest.mark.usefixtures("model_libraries")]
ROBOT = "quadruped"
#: Half of the camera's field of view, the width of the ball, and the distance from the camera that counts as reached.
HALF_DEG, BALL_M, NEAR_M = 37.6, 0.30, 0.9


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedWorld]:
    made = start_world(tmp_path_factory.mktemp("world"))
    yield made
    made.end()


@pytest.fixture
def scene(world: ServedWorld, tmp_path: Path) -> Iterator[Scene]:
    settings = RobotConfig(
        model="go2", domain=world.domain, simulated=True, home_on_start=True, look={"allowed": True}
    )  # fmt: skip
    driver = Driver(tmp_path, settings)
    made = Scene(MemoryForum.world(), driver, tmp_path, settings)
    made.person(ROBOT, Role.MEMBER, AccountKind.ROBOT_AGENT)
    made.person("alice")
    yield made
    driver.end()


def approach_red(shown: list[Any]) -> tuple[str, Any]:
    """Return the next call of a very simple vision model that uses only the newest picture."""
    if (red := find_red(shown[-1])) is None:
        return "act_turn", {"direction": "left", "degrees": 40, "look": True}
    aside, share = red
    degrees = math.degrees(math.atan(abs(aside) * math.tan(math.radians(HALF_DEG))))
    away_m = BALL_M / (2 * share * math.tan(math.radians(HALF_DEG)))
    if degrees > (8 if away_m > NEAR_M + 0.2 else 20):  # far from the ball the heading need not be exact
        return "act_turn", {"direction": "left" if aside < 0 else "right", "degrees": round(degrees, 1), "look": True}
    if away_m > NEAR_M:
        way_m = min(1.0, away_m - NEAR_M + 0.1)
        return "act_move", {"direction": "forward", "distance_m": round(max(0.1, way_m), 2), "look": True}
    return "finish", {"outcome": "done", "saw": ["a red ball before me"], "did": "I walked up to it."}


async def test_a_model_walks_to_the_red_ball_by_what_the_robot_s_camera_shows(world: ServedWorld, scene: Scene) -> None:
    async with httpx2.AsyncClient(base_url=world.url, timeout=100, trust_env=False) as room:
        ball = (2.7, 0.75)

        async def away_m() -> float:
            robot = (await room.get("/truth")).json()["robots"]["go2"]
            return math.dist(ball, (robot["x_m"], robot["y_m"]))

        began_m = await away_m()
        with running_loop_model() as scripted_model:
            scripted_model.loop_answers = approach_red
            async with scene.agent(mind=scripted_model.mind(scene.folder)):
                post = await scene.post("alice", f"@{ROBOT} walk to the red ball")
                reply = await scene.until(lambda: _final(scene, post), limit_s=100)
        record = json.loads((scene.folder / f"agents/{ROBOT}/records/{post.id}.json").read_text())
        reported = (reply.raw, record["steps"], record["looked"]["turns"])
        assert began_m > 2.5
        assert reply.card.state == "done", reported
        assert await away_m() < 1.5, reported
        assert "Contradicted by measurement" not in reply.raw
        robot = (await room.get("/truth")).json()["robots"]["go2"]
        assert "red_ball" not in str(robot["contacts"]), reported


def _final(scene: Scene, post: Any) -> Any:
    states = ("done", "failed", "refused", "asks_back", "stopped", "interrupted")
    return next((p for p in scene.replies(post) if p.card and p.card.state in states), None)
