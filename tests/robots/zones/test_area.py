"""The floor that steps need, and the distance between two such areas."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.model import Direction, Op, Pose, Primitive
from agentrob.robots.protocol import BODY_RADIUS_M
from agentrob.robots.zones.area import MARGIN_M, Capsule, body, conflict, covers, gap_m, swept

METRES = st.floats(-5, 5)
CAPSULES = st.builds(Capsule, METRES, METRES, METRES, METRES, st.floats(0, 1))
POSES = st.builds(Pose, METRES, METRES, st.floats(-3.1, 3.1))
STEPS = st.lists(
    st.one_of(
        st.builds(Primitive, st.just(Op.MOVE), st.sampled_from(Direction), distance_m=st.floats(0.05, 3)),
        st.builds(
            Primitive, st.just(Op.TURN), st.sampled_from([Direction.LEFT, Direction.RIGHT]), degrees=st.floats(1, 360)
        ),
        st.builds(Primitive, st.sampled_from([Op.HELLO, Op.SIT, Op.STAND])),
    ),
    max_size=5,
)


def move(distance_m: float, direction: Direction = Direction.FORWARD) -> Primitive:
    return Primitive(Op.MOVE, direction, distance_m=distance_m)


@given(CAPSULES, CAPSULES)
def test_the_distance_is_never_more_than_between_any_two_points(a: Capsule, b: Capsule) -> None:
    gap = gap_m([a], [b])
    assert math.isclose(gap, gap_m([b], [a]), abs_tol=1e-9)
    shares = [k / 40 for k in range(41)]
    points = [
        math.hypot(
            a.x0_m + s * (a.x1_m - a.x0_m) - b.x0_m - t * (b.x1_m - b.x0_m),
            a.y0_m + s * (a.y1_m - a.y0_m) - b.y0_m - t * (b.y1_m - b.y0_m),
        )
        for s in shares
        for t in shares
    ]
    sampled = min(points) - a.radius_m - b.radius_m
    assert sampled - 0.36 <= gap <= sampled + 1e-6, "within what the samples may miss"


def test_crossing_paths_conflict_and_parallel_ones_do_not() -> None:
    ahead = swept(Pose(0, 0, 0), [move(3)], 0.1)
    across = swept(Pose(1.5, -2, math.pi / 2), [move(4)], 0.1)
    beside = swept(Pose(0, 2, 0), [move(3)], 0.1)
    assert conflict(ahead, across)
    assert not conflict(ahead, beside)
    assert gap_m(ahead, beside) >= MARGIN_M


@given(POSES, STEPS, st.floats(0, 0.5))
def test_the_area_contains_each_predicted_pose_and_covers_itself_and_its_parts(
    pose: Pose, steps: list[Primitive], error_m: float
) -> None:
    area = swept(pose, steps, error_m)
    assert covers(area, area)
    assert covers(None, area)
    assert not covers(area, None)
    assert covers(area, (body(pose, error_m),)), "where it stands"
    if steps:
        assert covers(area, swept(pose, steps[:1], error_m)), "the next step needs no other lease"


@given(CAPSULES)
def test_the_whole_room_conflicts_with_everything(capsule: Capsule) -> None:
    assert conflict(None, (capsule,))
    assert conflict((capsule,), None)
    assert conflict(None, None)


def test_what_lies_behind_a_step_is_wider() -> None:
    turn = Primitive(Op.TURN, Direction.LEFT, degrees=90)
    straight, bent = swept(Pose(0, 0, 0), [move(2)], 0.1), swept(Pose(0, 0, 0), [turn, move(2)], 0.1)
    assert bent[-1].radius_m > straight[-1].radius_m
    assert (bent[-1].x1_m, bent[-1].y1_m) == pytest.approx((0, 2))


def test_a_gesture_needs_the_robots_own_place_only() -> None:
    (wave,) = swept(Pose(1, 2, 0.3), [Primitive(Op.HELLO)], 0.1)
    assert wave[:2] == wave[2:4] == (1, 2)
    (turn,) = swept(Pose(1, 2, 0.3), [Primitive(Op.TURN, Direction.LEFT, degrees=90)], 0.0)
    assert turn.radius_m < wave.radius_m < 2 * BODY_RADIUS_M + 0.2
