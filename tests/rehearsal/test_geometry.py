"""Previews without a simulation: the exact path, the fence, the limits and the owner's map."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.config.map import MapConfig, MapThing
from agentrob.config.robots import FenceConfig
from agentrob.model import Outcome, Pose
from agentrob.rehearsal.geometry import geometry_preview, in_frame, planned_path, seen_from
from agentrob.rehearsal.preview import Basis, Missing, OtherRobot, PreviewRequest, read_preview, write_preview
from agentrob.robots.unitree.go2 import Go2
from tests.rehearsal.rehearsed import L, request, turn, walk

metres = st.floats(-50, 50)
poses = st.builds(Pose, metres, metres, st.floats(-3, 3))


def preview_of(asked: PreviewRequest, missing: Missing = Missing.NO_WORLD):
    return geometry_preview(asked, Go2.describe(asked.settings), missing)


@given(poses, poses)
def test_frames_are_inverse(frame: Pose, pose: Pose) -> None:
    back = seen_from(frame, in_frame(frame, pose))
    assert (back.x_m, back.y_m, back.yaw_rad) == pytest.approx((pose.x_m, pose.y_m, pose.yaw_rad), abs=1e-6)


def test_the_exact_path_turns_and_walks() -> None:
    path = planned_path(Pose(1.0, 1.0, math.pi / 2), request(walk(2.0), turn(90), walk(1.0, L)).plan)
    assert [(round(x, 3), round(y, 3)) for x, y, _ in path] == [(1, 1), (1, 3), (1, 3), (1, 2)]


def test_what_the_fence_and_the_limits_refuse_is_said_with_its_step_and_place() -> None:
    fence = FenceConfig(x_min_m=-1, x_max_m=2, y_min_m=-1, y_max_m=1)
    asked = request(walk(1.5), turn(180), walk(4.0), settings={"fence": fence})
    found = preview_of(replace(asked, home=Pose(0, 0, 0), start=Pose(0, 0, 0)))
    (ending,) = found.endings
    assert (ending.number, ending.step.reason, ending.runs) == (3, "fence", 1)
    assert ending.step.at == pytest.approx((1.5, 0.0, math.pi), abs=1e-6)
    assert found.done == 0
    too_far = preview_of(request(walk(9.0)))
    assert [e.step.reason for e in too_far.endings] == ["limit_step_m"]


def test_distances_count_from_the_outline_of_the_body() -> None:
    things = (MapThing(name="post", at_m=(2.0, 0.5), radius_m=0.1),)
    asked = request(walk(2.0), settings={"map": MapConfig(things=things)})
    others = (OtherRobot("humanoid", "g1", Pose(2.0, -1.0, 0.0)),)
    found = preview_of(replace(asked, start=Pose(0, 0, 0), home=Pose(0, 0, 0), others=others))
    assert found.distances_m == pytest.approx({"post": 0.5 - 0.1 - 0.16, "@humanoid": 1.0 - 0.25 - 0.16}, abs=1e-6)
    assert found.basis is Basis.GEOMETRY
    assert found.missing is Missing.NO_WORLD


def test_a_robot_without_a_home_and_one_that_is_locked_move_nothing() -> None:
    nowhere = preview_of(request(walk(1.0), start=None), Missing.NO_PLACE)
    locked = preview_of(request(walk(1.0), halted="an emergency stop"))
    assert [e.step.reason for e in nowhere.endings] == ["not_homed"]
    assert [e.step.reason for e in locked.endings] == ["halted"]
    assert nowhere.distances_m == {}


def test_a_preview_is_the_same_after_it_was_sent() -> None:
    found = preview_of(request(walk(1.0), turn(90)))
    again = read_preview(write_preview(found))
    assert again == found
    assert again.hash == found.hash
    assert replace(found, start=Pose(0.5, 0.0, 0.0)).hash != found.hash
    assert all(step.outcome is Outcome.DONE for step in found.runs[0].steps)
