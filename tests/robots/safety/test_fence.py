"""Law 9: how far a point is outside the fence, and which steps may begin."""

from __future__ import annotations

import math

import pytest

from agentrob.config.robots import FenceConfig
from agentrob.model import Op, Pose, Primitive
from agentrob.robots.control.controller import rotate
from agentrob.robots.safety.fence import Fence
from tests.robots.guard_scene import B, F, L, R, move, turn

CONFIG = FenceConfig(x_min_m=-1.0, x_max_m=2.0, y_min_m=-1.5, y_max_m=1.2)
AT_ORIGIN = Fence(CONFIG, Pose(0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("x_m", "y_m", "outside_m"),
    [(0, 0, -1.0), (1.5, 0, -0.5), (2.5, 0, 0.5), (-1.3, 0, 0.3), (0, 1.5, 0.3), (0, -2, 0.5), (0.5, -1.4, -0.1)],
)
@pytest.mark.parametrize("home", [Pose(0.0, 0.0, 0.0), Pose(10.0, 20.0, 2.0), Pose(-3.0, 1.0, -math.pi / 2)])
def test_a_point_is_as_far_outside_as_beyond_the_nearest_side(
    home: Pose, x_m: float, y_m: float, outside_m: float
) -> None:
    x, y = rotate(x_m, y_m, home.yaw_rad)
    assert Fence(CONFIG, home).outside_m(home.x_m + x, home.y_m + y) == pytest.approx(outside_m)


def test_law_9_a_robot_on_the_fence_may_turn_and_one_outside_may_not() -> None:
    assert AT_ORIGIN.refusal(Pose(2.0, 0.0, 0.0), turn(90)) is None
    assert "stands 0.01 m outside" in (AT_ORIGIN.refusal(Pose(2.01, 0.0, 0.0), turn(90)) or "")
    assert "stands" in (AT_ORIGIN.refusal(Pose(2.01, 0.0, 0.0), Primitive(Op.HELLO)) or "")
    assert "stands" in (AT_ORIGIN.refusal(Pose(2.01, 0.0, 0.0), move(1.0, B)) or ""), "its owner must bring it back"


@pytest.mark.parametrize(
    ("pose", "direction", "farthest_m"),
    [
        (Pose(0.0, 0.0, 0.0), F, 1.9),
        (Pose(0.5, 0.0, 0.0), F, 1.4),
        (Pose(0.0, 0.0, 0.0), B, 0.9),
        (Pose(0.0, 0.2, 0.0), L, 0.9),
        (Pose(0.0, 0.0, 0.0), R, 1.4),
        (Pose(0.0, 0.0, math.pi / 2), F, 1.1),
        (Pose(0.0, 0.0, math.pi), F, 0.9),
    ],
)
def test_law_9_a_walk_ends_ten_centimetres_inside_the_fence(pose: Pose, direction: object, farthest_m: float) -> None:
    assert AT_ORIGIN.refusal(pose, move(farthest_m - 0.001, direction)) is None  # type: ignore[arg-type]
    assert "The way ends" in (AT_ORIGIN.refusal(pose, move(farthest_m + 0.001, direction)) or "")  # type: ignore[arg-type]


def test_law_9_a_walk_may_end_at_the_margin_itself() -> None:
    narrow = Fence(FenceConfig(x_min_m=-2.0, x_max_m=0.1), Pose(0.0, 0.0, 0.0))
    assert narrow.refusal(Pose(-1.0, 0.0, 0.0), move(1.0)) is None
