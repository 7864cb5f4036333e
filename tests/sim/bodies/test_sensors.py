"""The sensors of the simulated Go2 are plausible: ranges, odometry, IMU, battery, feet."""

import math

import numpy as np
import pytest

from agentrob.sim.bodies import sensors
from agentrob.sim.services.go2 import FEET
from agentrob.sim.world.scene import load

LENGTH_M, WIDTH_M = load("room").room.size_m


def ranges(bench):
    return sensors.Ranges(bench.body, np.random.default_rng(1), noisy=False).read()


def test_ranges_at_the_start_are_the_distances_to_what_is_there(room_bench):
    front, left, back, right = ranges(room_bench)
    x, y = room_bench.body.xy_m
    box, ball = 3.2 - 0.25 - x - sensors.NOSE_M, 2.7 - 0.15 - x - sensors.NOSE_M
    assert ball - 0.05 < front < box + 0.05
    assert back == pytest.approx(x + LENGTH_M / 2 - sensors.NOSE_M, abs=0.1)
    assert 1.5 < left < WIDTH_M / 2 - y
    assert 1.5 < right < WIDTH_M / 2 + y


def test_near_a_wall_the_front_range_is_short_and_exact(room_bench):
    data, body = room_bench.world.data, room_bench.body
    data.qpos[body.root_q : body.root_q + 2] = [-1.4, 2.2]
    data.qpos[body.root_q + 3 : body.root_q + 7] = [math.cos(math.pi / 4), 0, 0, math.sin(math.pi / 4)]
    room_bench.run(0.02)
    front, *_ = ranges(room_bench)
    assert front == pytest.approx(WIDTH_M / 2 - 2.2 - sensors.NOSE_M, abs=0.05)


def test_on_an_endless_floor_nothing_is_in_range(bench):
    assert ranges(bench) == pytest.approx([sensors.RANGE_LIMIT_M] * 4)


def test_readings_are_never_constant(bench):
    sensor = sensors.Ranges(bench.body, np.random.default_rng(1), noisy=True)
    readings = np.array([sensor.read() for _ in range(20)])
    assert (readings.std(axis=0) > 0).all()
    assert (readings > 0).all()
    assert (readings < sensors.RANGE_LIMIT_M + 0.05).all()


def walked(bench, odometry):
    for _ in range(20):
        bench.call(1008, {"x": 0.5, "y": 0.0, "z": 0.6})
        for _ in range(5):
            bench.run(0.02)
            odometry.update()


def test_odometry_without_noise_is_the_way_from_where_it_was_reset(bench):
    bench.walk(1.0, z=1.0)
    bench.run(1.5)
    odometry = sensors.Odometry(bench.body, np.random.default_rng(1), noisy=False)
    at, yaw = bench.body.xy_m, bench.body.yaw_rad
    walked(bench, odometry)
    x, y, turned = odometry.read()
    dx, dy = bench.body.xy_m - at
    c, s = math.cos(yaw), math.sin(yaw)
    assert (x, y) == pytest.approx((c * dx + s * dy, -s * dx + c * dy), abs=1e-6)
    assert turned == pytest.approx(sensors.wrap(bench.body.yaw_rad - yaw), abs=1e-6)


def test_odometry_noise_is_millimetres_and_its_drift_a_few_thousandths(bench):
    odometry = sensors.Odometry(bench.body, np.random.default_rng(5), noisy=True)
    at = bench.body.xy_m
    still = np.array([odometry.read() for _ in range(400)])
    assert still[:, 0].std() == pytest.approx(0.002, rel=0.2)
    assert math.degrees(still[:, 2].std()) == pytest.approx(0.2, rel=0.2)
    walked(bench, odometry)
    read = np.mean([odometry.read() for _ in range(100)], axis=0)
    path = np.hypot(*(bench.body.xy_m - at))
    error = np.hypot(*(read[:2] - (bench.body.xy_m - at)))
    assert 0 < error < 0.02 * path + 0.01


def test_standing_the_inertial_unit_feels_gravity_only(bench):
    bench.run(1.0)
    unit = sensors.Inertia(bench.body, np.random.default_rng(1), noisy=True)
    felt = np.mean([unit.acceleration_mps2() for _ in range(50)], axis=0)
    assert felt == pytest.approx([0, 0, 9.81], abs=0.3)
    assert unit.tilt_rad() == pytest.approx((0, 0), abs=0.1)


def test_the_feet_carry_the_robot(bench):
    bench.run(1.0)
    model = bench.world.model
    weight = 9.81 * float(np.sum(model.body_mass[model.body_mocapid < 0]))  # without the boxes that nothing carries
    forces = sensors.foot_forces_n(bench.body, FEET)
    assert all(f > 5 for f in forces)
    assert sum(forces) == pytest.approx(weight, rel=0.15)


def test_the_battery_drains_faster_when_it_works():
    idle, busy = sensors.Battery(80.0), sensors.Battery(80.0)
    idle.drain(0.0, 600.0)
    busy.drain(60.0, 600.0)
    assert 55 < busy.percent < idle.percent < 80
    assert 26 < busy.volts < idle.volts < 32
    busy.drain(1e6, 3600.0)
    assert busy.percent == 0.0
