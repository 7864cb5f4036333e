"""Previews in the simulated room: with the driver's guard, noise, things and other robots."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import count

import pytest

from agentrob.errors import SimError
from agentrob.model import Op, Outcome, Pose, Primitive
from agentrob.rehearsal.preview import Basis, OtherRobot
from agentrob.rehearsal.runs import simulate
from tests.rehearsal.rehearsed import R, request, turn, walk


def clock(step_s: float) -> Iterator[float]:
    return (step_s * n for n in count())


@pytest.mark.parametrize("model", ["go2", "g1"])
def test_runs_do_the_steps_with_noise_and_end_near_the_exact_path(model: str) -> None:
    asked = request(walk(1.0), turn(90), Primitive(Op.HELLO), Primitive(Op.GET_FRONT_IMAGE), model=model)
    found = simulate(asked)
    assert found.basis is Basis.SIMULATION
    assert (found.done, len(found.runs)) == (2, 2)
    x, y, yaw = found.planned[-1]
    for run in found.runs:
        assert math.dist(run.path[-1][:2], (x, y)) < 0.3
        assert abs(math.remainder(run.path[-1][2] - yaw, math.tau)) < math.radians(15)
        assert not run.touched
        assert not run.fell
    assert found.runs[0].path != found.runs[1].path
    assert 3.0 < found.median_s <= found.worst_s < 40.0
    assert len(found.frames) == len(found.runs[0].path)
    assert len(found.step_times_s) == 4
    assert found.world.startswith("room ")


def test_the_first_run_of_the_same_request_is_the_same() -> None:
    one, two = (simulate(request(walk(0.5), seed=5, least_runs=1, most_runs=1)) for _ in range(2))
    assert one == two
    assert simulate(request(walk(0.5), seed=6, least_runs=1, most_runs=1)) != one


def test_law_8_the_guard_ends_a_run_before_a_wall_and_says_where() -> None:
    found = simulate(request(turn(60, R), walk(4.5)))
    (ending,) = found.endings
    assert (ending.number, ending.runs, ending.step.reason) == (2, 2, "obstacle")
    assert "Something is" in ending.step.message
    assert ending.step.at is not None
    assert math.dist(ending.step.at[:2], found.start and (found.start.x_m, found.start.y_m)) > 0.5
    assert found.done == 0
    assert min(found.distances_m.values()) > 0.1
    assert found.touched == ()


def test_law_9_the_fence_refuses_before_anything_moves() -> None:
    asked = request(walk(2.0), model="g1")
    fence = asked.settings.fence.model_copy(update={"x_max_m": 1.0})
    found = simulate(replace(asked, settings=asked.settings.model_copy(update={"fence": fence})))
    assert [(e.number, e.step.reason, e.step.outcome) for e in found.endings] == [(1, "fence", Outcome.REFUSED)]
    start = found.start
    assert start is not None
    assert math.dist(found.runs[0].path[-1][:2], (start.x_m, start.y_m)) < 0.1


def test_a_locked_robot_and_an_empty_battery_are_refused() -> None:
    locked = simulate(request(walk(1.0), halted="an emergency stop"))
    empty = simulate(request(walk(1.0), battery_percent=3.0))
    assert [e.step.reason for e in locked.endings] == ["halted"]
    assert [e.step.reason for e in empty.endings] == ["low_battery"]


def test_another_robot_in_the_way_is_an_obstacle_and_has_a_distance() -> None:
    asked = request(walk(2.0))
    start = asked.start
    assert start is not None
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    other = OtherRobot("humanoid", "g1", Pose(start.x_m + 1.2 * c, start.y_m + 1.2 * s, 0.0))
    found = simulate(replace(asked, others=(other,)))
    assert [(e.number, e.step.reason) for e in found.endings] == [(1, "obstacle")]
    assert found.distances_m["@humanoid"] == pytest.approx(1.2 - 0.35 - 0.20, abs=0.05)


def test_a_blind_robot_that_walks_into_another_touches_it() -> None:
    asked = request(walk(1.0), model="g1")
    start = asked.start
    assert start is not None
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    other = OtherRobot("quadruped", "go2", Pose(start.x_m + 0.75 * c, start.y_m + 0.75 * s, 0.0))
    found = simulate(replace(asked, others=(other,)))
    assert found.touched == ("@quadruped",)
    assert found.distances_m["@quadruped"] == 0.0


def test_a_slow_machine_makes_fewer_runs_but_never_less_than_the_least() -> None:
    slow, fast = clock(10.0), clock(0.1)
    asked = request(walk(0.3), least_runs=2, most_runs=4, budget_s=3.0)
    assert len(simulate(asked, lambda: next(slow)).runs) == 2
    assert len(simulate(asked, lambda: next(fast)).runs) == 4


def test_an_unknown_world_is_named() -> None:
    asked = request(walk(0.3))
    rehearsal = asked.settings.rehearsal.model_copy(update={"world": "nowhere"})
    with pytest.raises(SimError, match="no world named 'nowhere'; valid: "):
        simulate(replace(asked, settings=asked.settings.model_copy(update={"rehearsal": rehearsal})))
