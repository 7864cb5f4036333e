"""Law 6 when the robot itself disappears: the simulated Go2's world is killed, and its driver while the Go2 walks."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.kill.kill_house import DRIVER_DIED, PHOTO, WALK
from tests.kill.kill_world import WorldHouse

pytestmark = [pytest.mark.sim, pytest.mark.slow]
MOVE, TICK = "agentrob.sim.services.go2_sport:Sport._move", "agentrob.sim.services.unitree:RobotServices.after_tick"
RENDER, COMMAND = "agentrob.sim.rendering.cameras:Cameras._fresh", "agentrob.robots.unitree.go2:Go2.command"
TARGETS = (MOVE, TICK, RENDER, COMMAND)


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WorldHouse]:
    made = WorldHouse(tmp_path_factory.mktemp("kill-world"))
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
def test_law_6_a_robot_that_vanished_is_told_and_does_nothing_when_it_is_back(
    house: WorldHouse, target: str, when: str, nth: int, containing: str, text: str
) -> None:
    house.arm("world", {"target": target, "when": when, "nth": nth, "containing": containing})
    asked = house.ask(text)
    house.died("world")
    house.start("world")
    final = house.final(asked)
    assert final["card"]["state"] in ("failed", "refused", "interrupted"), final["raw"]
    assert len(house.answers(asked)) == 1
    assert house.ends_told(final) == 1
    assert house.begun(house.born) == 0, "the robot that came back was moved by a command of before"
    house.running["driver"].kill()  # the owner restarts the driver: the robot has a new position and home
    house.start("driver")
    house.release()


@pytest.mark.parametrize(("when", "nth"), [("before", 1), ("after", 6)])
def test_law_6_a_go2_whose_driver_dies_stands_still_and_the_motion_is_not_repeated(
    house: WorldHouse, when: str, nth: int
) -> None:
    house.arm("driver", {"target": COMMAND, "when": when, "nth": nth})
    asked = house.ask(WALK)
    house.died("driver")
    at_death = len(house.ledger())
    house.start("driver")
    final = house.final(asked)
    house.release()
    assert final["card"]["state"] in DRIVER_DIED, final["raw"]
    assert len(house.answers(asked)) == 1
    assert house.ends_told(final) == 1
    assert house.begun(at_death) == 0
    assert not house.moves(asked.began)
