"""Law 6 when the robot itself disappears: the simulated Go2's world is killed, and its driver while the Go2 walks."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.kill.kill_scene import DRIVER_DIED, PHOTO, WALK
from tests.kill.kill_sim_scene import SimScene

pytestmark = [pytest.mark.sim, pytest.mark.slow]
MOVE, TICK = "agentrob.sim.services.go2_sport:Sport._move", "agentrob.sim.services.unitree:RobotServices.after_tick"
RENDER, COMMAND = "agentrob.sim.rendering.cameras:Cameras._fresh", "agentrob.robots.unitree.go2:Go2.command"
TARGETS = (MOVE, TICK, RENDER, COMMAND)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimScene]:
    made = SimScene(tmp_path_factory.mktemp("kill-world"))
    yield made
    made.close()


@pytest.mark.parametrize(
    ("target", "when", "nth", "containing", "text"),
    [
        pytest.param(MOVE, "before", 1, "", WALK, id="first Move received"),
        pytest.param(MOVE, "after", 6, "", WALK, id="walking"),
        pytest.param(TICK, "after", 60, "", WALK, id="state published"),
        pytest.param(RENDER, "after", 1, "/front", PHOTO, id="image rendered"),
    ],
)
def test_law_6_a_robot_that_vanished_is_reported_and_does_nothing_when_it_is_back(
    scene: SimScene, target: str, when: str, nth: int, containing: str, text: str
) -> None:
    scene.arm("world", {"target": target, "when": when, "nth": nth, "containing": containing})
    command = scene.ask(text)
    scene.wait_for_kill("world")
    scene.start("world")
    final = scene.final(command)
    assert final["card"]["state"] in ("failed", "refused", "interrupted"), final["raw"]
    assert len(scene.answers(command)) == 1
    assert len(scene.final_versions(final)) == 1
    assert scene.begun(scene.born) == 0, "the robot that came back was moved by a command of before"
    scene.running["driver"].kill()  # the owner restarts the driver: the robot has a new position and home
    scene.start("driver")
    scene.release()


@pytest.mark.parametrize(("when", "nth"), [("before", 1), ("after", 6)])
def test_law_6_a_go2_whose_driver_dies_stands_still_and_the_motion_is_not_repeated(
    scene: SimScene, when: str, nth: int
) -> None:
    scene.arm("driver", {"target": COMMAND, "when": when, "nth": nth})
    command = scene.ask(WALK)
    scene.wait_for_kill("driver")
    at_death = len(scene.ledger())
    scene.start("driver")
    final = scene.final(command)
    scene.release()
    assert final["card"]["state"] in DRIVER_DIED, final["raw"]
    assert len(scene.answers(command)) == 1
    assert len(scene.final_versions(final)) == 1
    assert scene.begun(at_death) == 0
    assert not scene.moves(command.began)
