"""Where the arm is by its own kinematics, against MuJoCo; keep-out boxes, options, and the units of LeRobot."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from agentrob_so101.arm import So101, pointed_deg
from agentrob_so101.keep_out import KeepOut
from agentrob_so101.kinematics import so101
from agentrob_so101.moving import eased
from agentrob_so101.operations import HOME_POSE, WAVE_POSE, way_of
from agentrob_so101.options import So101Options
from agentrob_so101.pose import JOINTS, NAMES, ArmPose, action_of, pose_of
from agentrob_so101.world import World
from hypothesis import given
from hypothesis import strategies as st

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError
from agentrob.model import Op, Primitive

ARM = so101()
poses = st.tuples(*(st.floats(low, high) for low, high in zip(ARM.lowest, ARM.highest, strict=True))).map(ArmPose._make)


@pytest.fixture(scope="module")
def bench() -> World:
    return World()


def test_the_parts_of_the_arm_are_where_mujoco_has_them(bench: World) -> None:
    chosen = np.random.default_rng(7)
    for _ in range(50):
        pose = ArmPose._make(chosen.uniform(ARM.lowest, ARM.highest))
        bench.place(pose)
        for name, frame in ARM.frames(pose).items():
            assert np.allclose(bench.data.body(name).xpos, frame[:3, 3], atol=1e-6), name
            assert np.allclose(bench.data.body(name).xmat.reshape(3, 3), frame[:3, :3], atol=1e-6), name
        assert np.allclose(bench.pose(), pose, atol=1e-3)


def test_every_part_that_moves_is_within_the_bars_that_stand_for_it(bench: World) -> None:
    """Each vertex of a mesh is at most 3 cm outside the bars, as the margins of boxes assume."""
    for pose in (HOME_POSE, WAVE_POSE, ArmPose(gripper=100.0)):
        bench.place(pose)
        places, radii = ARM.points(pose)
        for geom in range(bench.model.ngeom):
            body = bench.model.body(bench.model.geom_bodyid[geom]).name
            mesh = bench.model.geom_dataid[geom]
            if mesh < 0 or body not in ("lower_arm", "wrist", "gripper", "moving_jaw_so101_v1"):
                continue
            first, count = bench.model.mesh_vertadr[mesh], bench.model.mesh_vertnum[mesh]
            vertices = bench.model.mesh_vert[first : first + count]
            seen = vertices @ bench.data.geom_xmat[geom].reshape(3, 3).T + bench.data.geom_xpos[geom]
            gaps = np.linalg.norm(seen[:, None] - places[None], axis=2) - radii
            assert gaps.min(axis=1).max() < 0.03, bench.model.mesh(mesh).name


@given(poses)
def test_an_action_of_lerobot_is_read_back_as_the_same_pose(pose: ArmPose) -> None:
    assert np.allclose(pose_of(action_of(pose)), pose, atol=1e-4)
    assert set(action_of(pose)) == {f"{name}.pos" for name in NAMES}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"elbow_flex.pos": None}, "does not tell elbow_flex.pos"),
        ({"elbow_flex.pos": float("nan")}, "elbow_flex.pos as nan, which is not a number"),
        ({"elbow_flex.pos": "far"}, "elbow_flex.pos as 'far', which is not a number"),
    ],
)
def test_an_observation_that_is_no_pose_is_told(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match="The arm") as error:
        pose_of({**action_of(HOME_POSE), **change})
    assert words in str(error.value)


@given(seconds=st.floats(0.31, 20.0))
def test_a_way_speeds_up_and_slows_down_and_is_never_faster_than_planned(seconds: float) -> None:
    shares = [eased(step / 200, seconds) for step in range(201)]
    assert shares[0] == 0.0
    assert shares[-1] == pytest.approx(1.0)
    fastest = max(b - a for a, b in itertools.pairwise(shares)) * 200 / seconds
    assert fastest <= 1.0 / (seconds - 0.3) + 1e-6


@pytest.mark.parametrize("way", ["left", "right", "up"])
@pytest.mark.parametrize("angle", [5.0, 60.0, 90.0])
def test_it_points_as_far_as_it_is_asked_to_by_its_kinematics(way: str, angle: float) -> None:
    operation = next(one for one in So101.describe(RobotConfig(model="so101")).declared if one.name == "point")
    step = Primitive("point", arguments=operation.complete({"way": way, "angle": angle}), declared=operation)
    (pose,) = way_of(step, HOME_POSE)
    assert pointed_deg(way, pose) == pytest.approx(angle, abs=0.6)


def test_all_that_it_offers_stays_off_the_table_and_within_the_limits() -> None:
    keep_out = KeepOut(So101Options(), ARM)
    for operation in So101.describe(RobotConfig(model="so101", simulated=True)).declared:
        for way in ("left", "right", "up"):
            said = {"way": way} if operation.argument("way") else {}
            step = Primitive(operation.name, arguments=operation.complete(said), declared=operation)
            for start in (HOME_POSE, WAVE_POSE):
                assert keep_out.on_the_way((start, *way_of(step, start))) is None, operation.name


def test_a_way_into_the_table_is_refused() -> None:
    keep_out = KeepOut(So101Options(), ARM)
    down = ArmPose(shoulder_lift=40.0, elbow_flex=60.0)
    assert keep_out.on_the_way((HOME_POSE, down)) == (
        "keep_out",
        "The arm would come too near to the table on its way.",
    )
    assert KeepOut(So101Options(table_m=-0.5), ARM).on_the_way((HOME_POSE, down)) is None


def test_an_arm_that_is_too_near_to_something_may_leave_and_not_come_nearer() -> None:
    low = ArmPose(shoulder_lift=-20.0, elbow_flex=50.0, wrist_flex=60.0)  # its tips touch a table that is this high
    keep_out = KeepOut(So101Options(table_m=0.06), ARM)
    assert keep_out.on_the_way((HOME_POSE, low)) is not None
    assert keep_out.on_the_way((low, low._replace(shoulder_lift=-45.0))) is None
    lower = keep_out.on_the_way((low, low._replace(shoulder_lift=-10.0)))
    assert lower == ("keep_out", "The arm would come too near to the table on its way.")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"prot": "/dev/ttyACM0"}, "prot is not a setting; valid here: calibration, calibration_folder, camera"),
        ({"joints": {"elbow": [0, 1]}}, f"there is no joint 'elbow'; joints: {', '.join(NAMES)}"),
        (
            {"joints": {"elbow_flex": [20, -20]}},
            "elbow_flex must be from a smaller to a larger number within -97 to 97",
        ),
        ({"keep_out": [{"from_m": [0, 0, 0], "to_m": [1, 0, 1]}]}, "from_m must be the smaller corner"),
        ({"camera": {"fps": 0}}, "camera.fps: Input should be greater than or equal to 1"),
    ],
)
def test_a_wrong_option_is_told_with_what_is_valid(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match="options of an SO-101 arm") as error:
        So101.describe(RobotConfig(model="so101", options=options))
    assert words in str(error.value)


def test_a_port_and_a_simulation_exclude_each_other() -> None:
    with pytest.raises(ConfigError, match="port is that of a real arm; remove it, or simulated = true"):
        So101.describe(RobotConfig(model="so101", simulated=True, options={"port": "/dev/ttyACM0"}))


def test_it_offers_a_photo_only_with_a_camera() -> None:
    assert Op.GET_FRONT_IMAGE not in So101.describe(RobotConfig(model="so101")).ops
    with_camera = RobotConfig(model="so101", options={"camera": {"source": 0}})
    assert Op.GET_FRONT_IMAGE in So101.describe(with_camera).ops
    assert len(JOINTS) == 5
