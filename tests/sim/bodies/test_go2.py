"""The Go2 in physics, in simulated time: it stands, walks, turns, and never falls on a floor."""

import math

import numpy as np
import pytest

from agentrob.errors import SimError
from agentrob.sim.bodies.go2 import VELOCITY_BOUND
from agentrob.sim.bodies.sensors import wrap
from agentrob.sim.services.go2_sport import MOVE, STOP_MOVE
from agentrob.sim.world.world import World


def test_it_stands_still_without_drifting(bench):
    at, yaw = bench.body.xy_m, bench.body.yaw_rad
    bench.run(20.0)
    assert np.hypot(*(bench.body.xy_m - at)) < 0.01
    assert abs(math.degrees(wrap(bench.body.yaw_rad - yaw))) < 1.5
    assert bench.body.standing


def test_half_a_metre_a_second_for_two_seconds_is_about_a_metre(bench):
    at = bench.body.xy_m
    bench.walk(2.0, x=0.5)
    bench.run(2.0)
    ahead, aside = bench.body.xy_m - at
    assert 0.9 < ahead < 1.3
    assert abs(aside) < 0.1
    assert bench.body.standing


@pytest.mark.parametrize("direction", [1, -1])
def test_it_turns_both_ways(bench, direction):
    yaw = bench.body.yaw_rad
    bench.walk(1.5, z=direction * 1.0)
    bench.run(2.0)
    turned = math.degrees(wrap(bench.body.yaw_rad - yaw)) * direction
    assert 60 < turned < 110


@pytest.mark.parametrize("velocity", [{"x": -0.4}, {"y": 0.3}, {"y": -0.3}, {"x": 0.6, "z": 0.8}])
def test_it_goes_every_way_without_falling(bench, velocity):
    at = bench.body.xy_m
    bench.walk(2.0, **velocity)
    bench.run(2.0)
    assert np.hypot(*(bench.body.xy_m - at)) > 0.3
    assert bench.body.upright > 0.99
    assert bench.body.standing


def test_a_velocity_beyond_what_the_policy_follows_is_clipped(bench):
    bench.walk(3.0, x=50.0, y=-50.0, z=50.0)
    assert bench.body.upright > 0.9
    assert np.all(np.abs(bench.body.heading_velocity()) < 1.6 * VELOCITY_BOUND)


def test_walking_into_a_wall_is_a_contact_not_a_fall(room_bench):
    room_bench.walk(1.0, z=1.2)
    for _ in range(8):
        room_bench.walk(1.0, x=0.5)
    room_bench.run(2.0)
    assert room_bench.body.upright > 0.9
    assert (np.abs(room_bench.body.xy_m) < np.array(room_bench.world.scene.room.size_m) / 2).all()


def test_reset_puts_it_back_and_time_goes_on(bench):
    bench.walk(1.0, x=0.5)
    time_s = bench.world.time_s
    bench.reset()
    assert np.allclose(bench.body.xy_m, bench.body.start[:2], atol=0.05)
    assert bench.body.standing
    assert bench.world.time_s > time_s


def test_a_world_without_robots_is_refused():
    with pytest.raises(SimError, match="1 to 3 robots"):
        World([])


@pytest.mark.parametrize("seed", range(25))
def test_stopped_at_any_moment_of_any_walk_it_comes_to_rest_on_its_feet(bench, seed):
    rng = np.random.default_rng(seed)
    for _ in range(3):
        x, y, z = rng.uniform([-0.6, -0.4, -1.4], [1.0, 0.4, 1.4])
        for _ in range(rng.integers(2, 15)):
            bench.sport.call(MOVE, {"x": x, "y": y, "z": z}, lambda code: None)
            bench.run(0.1)
    bench.call(STOP_MOVE)
    assert bench.run(6.0, lambda: bench.body.settled) < 5.0
    bench.run(3.0)
    assert bench.body.standing
    assert bench.body.upright > 0.985
