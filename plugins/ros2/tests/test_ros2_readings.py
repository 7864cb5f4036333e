"""Readings of messages: ranges of a scan, attitude, charge, transforms. Implausible values are unknown."""

from __future__ import annotations

import math

import pytest
from agentrob_ros2.messages import BatteryState, LaserScan, Quaternion, Transform, Vector3
from agentrob_ros2.options import BodyOptions
from agentrob_ros2.readings import UNKNOWN, Mount, StaticTransforms, percent_of, pose_of, ranges_of, upright_of
from hypothesis import given
from hypothesis import strategies as st

SMALL = BodyOptions(length_m=0.3, width_m=0.3)
BEAMS = 360


def scan(default: float = 5.0, **at_degrees: float) -> LaserScan:
    """A full turn of beams; `d90=1.0` is the range at 90°."""
    ranges = [default] * BEAMS
    for name, value in at_degrees.items():
        ranges[int(name[1:])] = value
    step = 2 * math.pi / BEAMS
    return LaserScan(angle_increment=step, range_min=0.1, range_max=12.0, ranges=ranges)


def test_each_side_is_the_nearest_thing_in_the_strip_of_the_body() -> None:
    found, wrong = ranges_of(scan(d0=1.5, d90=2.5, d180=0.9, d270=1.1), Mount(), SMALL)
    assert wrong == ""
    assert found == pytest.approx((1.5, 2.5, 0.9, 1.1), abs=1e-3)


def test_a_thing_beside_the_way_does_not_count_and_half_in_it_does() -> None:
    beside, _ = ranges_of(scan(d30=1.0), Mount(), SMALL)  # 0.50 m aside
    assert beside[0] == pytest.approx(5.0, abs=0.01)
    half, _ = ranges_of(scan(d9=1.0), Mount(), SMALL)  # 0.16 m aside
    assert half[0] == pytest.approx(math.cos(math.radians(9)), abs=1e-3)


def test_a_turned_or_hanging_scanner_is_read_as_it_is_mounted() -> None:
    turned, _ = ranges_of(scan(d0=1.0), Mount(0.1, 0.0, math.pi / 2), SMALL)
    assert turned[1] == pytest.approx(1.0, abs=1e-3)
    hanging, _ = ranges_of(scan(d90=1.0), Mount(upside_down=True), SMALL)
    assert hanging[3] == pytest.approx(1.0, abs=1e-3)


def test_parts_of_the_base_itself_are_no_obstacle() -> None:
    found, _ = ranges_of(scan(d0=0.12), Mount(), SMALL)
    assert found[0] is not None
    assert found[0] > 4.0


def test_a_side_that_nothing_answers_from_is_unknown() -> None:
    assert ranges_of(scan(math.inf), Mount(), SMALL)[0] == UNKNOWN
    assert ranges_of(scan(0.0), Mount(), SMALL)[0] == UNKNOWN
    assert ranges_of(scan(math.nan), Mount(), SMALL)[0] == UNKNOWN


def test_a_half_blind_side_is_unknown_although_one_beam_answers() -> None:
    blind = scan(0.0, d0=4.0)
    assert ranges_of(blind, Mount(), SMALL)[0] == UNKNOWN


def test_a_thing_too_near_to_be_measured_is_near() -> None:
    found, _ = ranges_of(scan(d90=-math.inf, d89=0.3), Mount(), BodyOptions(length_m=0.3, width_m=0.1))
    assert found[1] == pytest.approx(0.1, abs=0.02)


@given(st.floats(0.1, 2.0), st.floats(0.1, 2.0), st.floats(0.3, 4.0))
def test_law_8_the_readings_of_a_large_base_leave_the_guards_margin_from_its_own_outline(
    length_m: float, width_m: float, distance_m: float
) -> None:
    """The guard wants 0.50 m from the middle of a body that reaches 0.35 m: at least 0.15 m from any outline."""
    body = BodyOptions(length_m=length_m, width_m=width_m)
    found, _ = ranges_of(scan(distance_m + length_m / 2), Mount(), body)
    if found[0] is not None and found[0] >= 0.50:
        assert distance_m >= 0.15 - 0.02


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (LaserScan(angle_increment=1.0, range_min=0.1, range_max=12.0, ranges=[1.0] * 360), "degrees"),
        (LaserScan(angle_increment=0.01, range_min=100, range_max=12000.0, ranges=[1000.0] * 360), "millimetres"),
        (LaserScan(angle_increment=0.01, range_min=0.1, range_max=12.0, ranges=[1500.0] * 360), "millimetres"),
        (LaserScan(angle_increment=0.01, range_min=0.1, range_max=12.0, ranges=[]), "no beams"),
        (LaserScan(angle_increment=math.nan, range_min=0.1, range_max=12.0, ranges=[1.0] * 3), "not numbers"),
    ],
)
def test_wrong_units_are_told_and_the_ranges_are_unknown(wrong: LaserScan, words: str) -> None:
    found, why = ranges_of(wrong, Mount(), SMALL)
    assert found == UNKNOWN
    assert words in why


@given(st.lists(st.floats(width=32), min_size=2, max_size=40), st.floats(-7, 7), st.floats(-1, 1))
def test_no_scan_makes_a_free_side_out_of_nothing(ranges: list[float], start: float, step: float) -> None:
    message = LaserScan(angle_min=start, angle_increment=step, range_min=0.1, range_max=12.0, ranges=ranges)
    found, _ = ranges_of(message, Mount(), SMALL)
    assert all(one is None or 0.0 < one <= 12.1 for one in found)


def test_the_charge_is_a_share_and_percent_are_not_believed() -> None:
    assert percent_of(BatteryState(percentage=0.5)) == (50.0, "")
    assert percent_of(BatteryState(percentage=math.nan)) == (None, "")
    assert percent_of(BatteryState(percentage=0.5, present=False)) == (None, "")
    percent, why = percent_of(BatteryState(percentage=93.0))
    assert percent is None
    assert "0 to 1" in why


def test_attitude_and_position_that_are_none_are_unknown() -> None:
    assert upright_of(Quaternion()) is True
    assert upright_of(Quaternion(1.0, 0.0, 0.0, 0.0)) is False
    assert upright_of(Quaternion(0.0, 0.0, 0.0, 0.0)) is None
    assert pose_of(math.nan, 0.0, Quaternion())[0] is None
    assert pose_of(0.0, 0.0, Quaternion(0.0, 0.0, 0.0, 5.0))[0] is None


def test_the_mount_of_a_sensor_comes_from_the_chain_of_static_transforms() -> None:
    tree, half = StaticTransforms(), math.sin(math.pi / 4)
    tree.add("base_footprint", "base_link", Transform(Vector3(0.0, 0.0, 0.1), Quaternion()))
    tree.add("base_link", "mast", Transform(Vector3(0.1, 0.0, 0.3), Quaternion(0.0, 0.0, half, half)))
    tree.add("mast", "laser", Transform(Vector3(0.05, 0.0, 0.0), Quaternion(1.0, 0.0, 0.0, 0.0)))
    mount = tree.mount("base_link", "laser")
    assert mount is not None
    assert mount[:3] == pytest.approx((0.1, 0.05, math.pi / 2))
    assert mount.upside_down
    assert tree.mount("base_footprint", "laser") is not None
    assert tree.mount("base_link", "camera") is None
    tree.add("base_link", "tilted", Transform(Vector3(), Quaternion(0.0, 0.38268, 0.0, 0.92388)))
    assert tree.mount("base_link", "tilted") is None
