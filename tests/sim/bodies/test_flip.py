"""The Go2's backflip: an animation where there is room, refused where there is none, and physics again after it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from agentrob.sim.bodies import flip
from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.bodies.sensors import Odometry
from agentrob.sim.event_log import EventLog
from agentrob.sim.services import go2_sport
from agentrob.sim.world.scene import OPEN_FLOOR, Start
from agentrob.sim.world.world import World


def test_it_goes_over_its_back_and_stands_and_walks_on(bench: Any) -> None:
    body, at = bench.body, bench.body.xy_m
    odometry = Odometry(body, np.random.default_rng(0), noisy=False)
    answers: list[int] = []
    heights, uprights, believed = list[float](), list[float](), list[tuple[float, float, float]]()
    bench.sport.call(go2_sport.BACK_FLIP, {}, answers.append)
    while not answers:
        bench.run(0.02)
        odometry.update()
        heights.append(body.z_m)
        uprights.append(body.upright)
        believed.append(odometry.read())
    assert answers == [go2_sport.OK]
    assert max(heights) > 0.6
    assert min(uprights) < -0.95
    assert np.abs(np.diff(believed, axis=0)).max() < 0.05, "nothing jumps that the robot believes of its place"
    bench.run(1.5)
    assert body.standing
    assert body.upright > 0.99
    assert np.hypot(*(body.xy_m - at)) < 0.05
    bench.walk(1.0, x=0.5)
    assert np.hypot(*(body.xy_m - at)) > 0.3


@pytest.mark.parametrize("away_m", [(0.75, 0.0), (0.0, 0.9), (-0.6, -0.6)])
def test_near_a_thing_it_is_refused_and_does_nothing(room_bench: Any, away_m: tuple[float, float]) -> None:
    x, y = room_bench.body.xy_m + away_m
    assert room_bench.world.put_box((x, y))
    assert room_bench.call(go2_sport.BACK_FLIP) == go2_sport.UNSUITABLE, "at once"
    assert room_bench.body.standing
    room_bench.world.put_box(None)
    assert room_bench.call(go2_sport.BACK_FLIP) == go2_sport.OK


def test_near_another_robot_it_is_refused() -> None:
    go2, g1 = Go2(start=Start(0, 0, 0)), G1(start=Start(0, 0.8, math.pi))
    world = World([go2, g1], OPEN_FLOOR)
    service, codes = go2_sport.Sport(go2, lambda: world.time_s, EventLog()), list[int]()
    service.call(go2_sport.BACK_FLIP, {}, codes.append)
    assert codes == [go2_sport.UNSUITABLE]
    g1.start = Start(0, 1.6, math.pi)
    world.reset()
    service.call(go2_sport.BACK_FLIP, {}, codes.append)
    assert codes == [go2_sport.UNSUITABLE], "it is under way"


def test_sitting_or_lying_it_does_not_flip(bench: Any) -> None:
    for call in (go2_sport.SIT, go2_sport.STAND_DOWN):
        assert bench.call(call) == go2_sport.OK
        assert bench.call(go2_sport.BACK_FLIP) == go2_sport.UNSUITABLE


def test_law_14_a_stop_before_the_take_off_ends_it_on_the_ground(bench: Any) -> None:
    answers: list[int] = []
    bench.sport.call(go2_sport.BACK_FLIP, {}, answers.append)
    bench.run(2.0, lambda: bench.body.led is not None)
    bench.run(0.2)
    assert bench.call(go2_sport.STOP_MOVE) == go2_sport.OK
    highest = max(_heights(bench, answers))
    assert answers == [go2_sport.BROKEN_OFF]
    assert highest < 0.36
    bench.run(1.5)
    assert bench.body.upright > 0.99


def test_law_14_a_stop_in_the_air_ends_with_the_landing(bench: Any) -> None:
    answers: list[int] = []
    bench.sport.call(go2_sport.BACK_FLIP, {}, answers.append)
    bench.run(2.0, lambda: bench.body.airborne)
    bench.run(0.3)
    assert bench.call(go2_sport.STOP_MOVE) == go2_sport.OK
    assert bench.call(go2_sport.MOVE, {"x": 0.5, "y": 0, "z": 0}) == go2_sport.BUSY
    assert len(_heights(bench, answers)) * 0.02 < flip.SECONDS
    assert answers == [go2_sport.BROKEN_OFF]
    bench.run(1.5)
    assert bench.body.standing
    assert bench.body.upright > 0.99


def _heights(bench: Any, answers: list[int]) -> list[float]:
    """Return the body's heights until the request is answered."""
    heights = [bench.body.z_m]
    while not answers and len(heights) < 300:
        bench.run(0.02)
        heights.append(bench.body.z_m)
    return heights
