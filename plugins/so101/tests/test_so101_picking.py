"""Picking up the red cube: where the camera sees it, what is within reach, and what is told when it fails."""

from __future__ import annotations

import io
import math
import threading
import time
from pathlib import Path

import pytest
from agentrob_so101 import picking
from agentrob_so101.arm import So101
from agentrob_so101.keep_out import KeepOut
from agentrob_so101.kinematics import HAND, so101
from agentrob_so101.operations import HOME_POSE
from agentrob_so101.options import So101Options
from conftest import PatientArm
from PIL import Image
from so101_world import LIMIT_S, WorldProcess, until

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Outcome, Primitive
from agentrob.robots.contract import go_on

PLACES = [(0.24, -0.10, 0.0), (0.19, 0.12, 0.6), (0.28, 0.02, -0.3), (0.17, -0.15, 0.2)]


def pick_up(robot: So101) -> Primitive:
    return Primitive("pick_up_cube", declared=robot.capabilities.operation("pick_up_cube"))


@pytest.mark.parametrize("distance_m", [0.13, 0.17, 0.21, 0.25, 0.28])
@pytest.mark.parametrize("aside_deg", [-50, 0, 50])
def test_a_grasp_leads_around_the_place_from_above_and_past_the_table(distance_m: float, aside_deg: int) -> None:
    x = picking.AXIS_M + distance_m * math.cos(math.radians(aside_deg))
    y = distance_m * math.sin(math.radians(aside_deg))
    grasp = picking.grasp(x, y)
    assert grasp is not None
    for pose, high_m in ((grasp.above, picking.HIGH_M), (grasp.around, picking.LOW_M)):
        between = (so101().frames(pose)[HAND] @ (*picking.GRASP_M, 1.0))[:3]
        assert between == pytest.approx((x, y, high_m), abs=0.001)
    closed = grasp.around._replace(gripper=0.0)
    way = (HOME_POSE, grasp.above, grasp.around, closed, grasp.above, HOME_POSE)
    assert KeepOut(So101Options(), so101()).on_the_way(way) is None


@pytest.mark.parametrize(("x", "y"), [(0.10, 0.0), (0.45, 0.0), (0.1, 0.4)])
def test_a_place_out_of_reach_has_no_grasp(x: float, y: float) -> None:
    assert picking.grasp(x, y) is None


def test_single_red_pixels_elsewhere_do_not_move_the_cube() -> None:
    def located(*spots: tuple[int, int, int, int]) -> tuple[float, float] | None:
        picture = Image.new("RGB", picking.PICTURE_PX, (180, 130, 90))
        for spot in spots:
            picture.paste((210, 20, 20), spot)
        jpeg = io.BytesIO()
        picture.save(jpeg, "JPEG", quality=95)
        return picking.locate(jpeg.getvalue())

    alone = located((400, 300, 424, 324))
    assert alone is not None
    assert located((400, 300, 424, 324), (340, 280, 344, 284)) == pytest.approx(alone, abs=0.001)
    assert located((340, 280, 344, 284)) is None


def test_a_real_arm_does_not_offer_it() -> None:
    assert "pick_up_cube" not in So101.describe(RobotConfig(model="so101")).ops


def new_picture(robot: So101, last: bytes) -> bytes:
    """Return the next picture that differs from `last`: the simulated camera repeats a picture for 70 ms."""
    end_s = time.monotonic() + LIMIT_S
    while (picture := robot.look()) == last:
        assert time.monotonic() < end_s, f"no new picture within {LIMIT_S:.0f} s"
    return picture


@pytest.mark.sim
@pytest.mark.parametrize("gl", ["", "off"])
def test_the_cube_is_located_within_half_a_centimetre_with_and_without_gl(tmp_path: Path, gl: str) -> None:
    world = WorldProcess(tmp_path, **({"MUJOCO_GL": gl} if gl else {}))
    robot, picture = So101(world.settings()), b""
    try:
        for place in PLACES:
            world.apply(cube=list(place))
            picture = new_picture(robot, picture)
            found = picking.locate(picture)
            assert found is not None
            assert math.dist(found, place[:2]) < 0.005
        world.apply(cube=[1.5, -1.2, 0.0])
        assert picking.locate(new_picture(robot, picture)) is None
    finally:
        robot.close()
        world.close()


@pytest.mark.sim
def test_it_picks_up_the_cube_by_the_truth_of_its_world(patient: PatientArm, world: WorldProcess) -> None:
    for place in PLACES[:2]:
        world.apply(cube=list(place))
        result = patient.step(pick_up(patient), go_on)
        assert result.outcome is Outcome.DONE, result.message
        assert 10.0 < result.measured["opening"] < 30.0
        assert world.apply()["cube"][2] > 0.05


@pytest.mark.sim
def test_what_keeps_it_from_picking_up_is_told(patient: PatientArm, world: WorldProcess) -> None:
    for place, reason, words in (
        ([0.48, 0.0, 0.0], "out_of_reach", "The red cube is out of reach: 0.48 m ahead"),
        ([1.5, -1.2, 0.0], "not_seen", "The camera does not show the red cube."),
    ):
        world.apply(cube=place)
        result = patient.step(pick_up(patient), go_on)
        assert (result.outcome, result.reason) == (Outcome.FAILED, reason)
        assert words in result.message


@pytest.mark.sim
def test_a_cube_that_is_taken_away_is_not_reported_as_picked_up(patient: PatientArm, world: WorldProcess) -> None:
    results: list[ActionResult] = []
    running = threading.Thread(target=lambda: results.append(patient.step(pick_up(patient), go_on)))
    running.start()
    until(lambda: results or world.pose().shoulder_pan > 10.0, "it goes to the cube")
    world.apply(cube=[1.5, -1.2, 0.0])
    running.join(LIMIT_S)
    assert (results[0].outcome, results[0].reason) == (Outcome.FAILED, "missed")
    assert "The gripper holds nothing." in results[0].message


@pytest.mark.sim
def test_a_stop_does_not_let_go_of_what_it_holds(patient: PatientArm, world: WorldProcess) -> None:
    assert patient.step(pick_up(patient), go_on).outcome is Outcome.DONE
    assert patient.stop().confirmed
    assert world.apply()["cube"][2] > 0.05
