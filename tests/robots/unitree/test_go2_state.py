"""How the Go2's messages and codes are decoded, on the SDK's own types, without a network."""

from __future__ import annotations

import math

import pytest
from unitree_sdk2py.idl.default import unitree_go_msg_dds__SportModeState_

import agentrob.process.dds  # noqa: F401  before any type of the SDK
from agentrob.robots.unitree.go2 import read
from agentrob.robots.unitree.robot import posture_of
from agentrob.robots.unitree.sdk import CODES, explain


def message(roll_rad: float = 0.0, **fields: object) -> object:
    """Return a state message, tilted to the side by `roll_rad`."""
    state = unitree_go_msg_dds__SportModeState_()
    state.imu_state.quaternion = [math.cos(roll_rad / 2), math.sin(roll_rad / 2), 0.0, 0.0]
    for name, value in fields.items():
        setattr(state, name, value)
    return state


@pytest.mark.parametrize(("roll_deg", "upright"), [(0, True), (20, True), (-45, True), (75, False), (180, False)])
def test_a_fall_is_read_from_the_robots_own_tilt(roll_deg: float, upright: bool) -> None:
    state = read(message(math.radians(roll_deg)))
    assert state.upright is upright
    assert (state.mode == "fallen") is not upright


def test_a_robot_that_gives_no_attitude_is_not_known_to_stand() -> None:
    state = message()
    state.imu_state.quaternion = [0.0, 0.0, 0.0, 0.0]  # type: ignore[attr-defined]
    assert read(state).upright is None


@pytest.mark.parametrize(
    ("code", "mode", "word"),
    [
        (1013, 0, "idle"),
        (100, 0, "idle"),
        (1015, 0, "walking"),
        (1002, 0, "locked"),
        (1001, 0, "damping"),
        (1006, 0, "gesture"),
        (1007, 0, "sitting"),
        (4711, 1, "unknown"),
        (0, 3, "walking"),
        (0, 6, "locked"),
        (0, 99, "unknown"),
    ],
)
def test_modes_are_read_from_the_code_and_in_older_firmware_from_the_mode(code: int, mode: int, word: str) -> None:
    assert read(message(error_code=code, mode=mode)).mode == word


def test_pose_ranges_and_speed_are_read() -> None:
    state = message(
        position=[1.0, 2.0, 0.3], velocity=[0.1, -0.2, 0.0], yaw_speed=0.5, range_obstacle=[1, 2, 3, math.inf]
    )
    state.imu_state.quaternion = [math.cos(0.75), 0.0, 0.0, math.sin(0.75)]  # type: ignore[attr-defined]
    found = read(state)
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.y_m, found.pose.yaw_rad) == (1.0, 2.0, pytest.approx(1.5))
    assert found.velocity_mps == (0.1, -0.2)
    assert found.ranges_m == (1.0, 2.0, 3.0, None)


def test_the_heading_is_that_of_the_quaternion_and_without_one_that_of_the_angles() -> None:
    state = message()
    state.imu_state.quaternion = [math.cos(-1.0), 0.0, 0.0, math.sin(-1.0)]  # type: ignore[attr-defined]
    state.imu_state.rpy = [0.0, 0.0, 0.0]  # type: ignore[attr-defined]
    assert (found := read(state).pose) is not None
    assert found.yaw_rad == pytest.approx(-2.0)
    state.imu_state.quaternion = [0.0] * 4  # type: ignore[attr-defined]
    state.imu_state.rpy = [0.0, 0.0, 0.7]  # type: ignore[attr-defined]
    assert (found := read(state).pose) is not None
    assert found.yaw_rad == pytest.approx(0.7)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_law_9_odometry_that_is_no_number_is_unknown(bad: float) -> None:
    for position in ([bad, 0.0, 0.3], [0.0, bad, 0.3]):
        assert read(message(position=position)).pose is None
    turned = message(velocity=[0.1, bad, 0.0], yaw_speed=bad)
    turned.imu_state.rpy = [0.0, 0.0, bad]  # type: ignore[attr-defined]
    assert (read(turned).pose, read(turned).velocity_mps, read(turned).yaw_rate_rps) == (None, None, None)


@pytest.mark.parametrize("code", [*CODES, 9999])
def test_every_code_reads_as_a_sentence_with_its_number(code: int) -> None:
    assert str(code) in explain(code)
    assert " " in explain(code).split("(")[0].strip()


@pytest.mark.parametrize("yaw_deg", [0, 90, -170])
@pytest.mark.parametrize("roll_deg", [0, 20, 170])
def test_the_posture_tells_the_tilt_apart_from_the_heading(yaw_deg: float, roll_deg: float) -> None:
    yaw, roll = math.radians(yaw_deg) / 2, math.radians(roll_deg) / 2
    state = message(position=[1.0, 2.0, 0.31])
    turned = [math.cos(yaw) * math.cos(roll), math.cos(yaw) * math.sin(roll)]
    turned += [math.sin(yaw) * math.sin(roll), math.sin(yaw) * math.cos(roll)]
    state.imu_state.quaternion = turned  # type: ignore[attr-defined]
    seen = posture_of((0.0, state), (0.1, 0.2))
    assert seen.height_m == pytest.approx(0.31)
    assert seen.joints_rad == (0.1, 0.2)
    assert seen.tilt is not None
    assert seen.pose is not None
    half, (w, x, y, z) = seen.pose.yaw_rad / 2, seen.tilt
    again = [math.cos(half) * w - math.sin(half) * z, math.cos(half) * x - math.sin(half) * y]
    again += [math.cos(half) * y + math.sin(half) * x, math.cos(half) * z + math.sin(half) * w]
    assert abs(sum(a * b for a, b in zip(again, turned, strict=True))) == pytest.approx(1), "heading after tilt"
    assert z == pytest.approx(0, abs=1e-6), "the tilt has no heading"


def test_a_robot_that_sent_nothing_has_no_posture() -> None:
    assert posture_of(None, ()).pose is None
