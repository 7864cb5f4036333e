"""Faults that a user can inject: which are valid, their effect on the sensors, and that a reset clears them."""

from __future__ import annotations

import math

import httpx2
import numpy as np
import pytest

from agentrob.errors import SimError
from agentrob.sim.bodies import sensors
from agentrob.sim.faults import Faults, FaultState, read
from agentrob.sim.services.go2_sport import MOVE
from agentrob.sim.world.legged import PERIOD_S

ROOM_M = (8.0, 6.0)


def test_faults_are_read_and_what_is_left_out_is_well() -> None:
    assert read({}, ["g1", "go2"], ROOM_M) == Faults("go2")
    assert read({}, ["g1"], ROOM_M) == Faults("g1")
    asked = {"robot": "go2", "ranges": "zero", "silent": True, "jump_m": [1, -0.5], "box_m": [0.5, 0]}
    assert read(asked, ["go2"], ROOM_M) == Faults("go2", "zero", True, (1.0, -0.5), (0.5, 0.0))
    assert read({"box_m": None}, ["go2"], ROOM_M).box_m is None
    more = {"lost": True, "drops": 1, "unplugged": True, "camera": "black", "battery_percent": 9, "clock_s": -60}
    found = read({**more, "push_mps": [0, 1], "tip": True}, ["go2"], ROOM_M)
    assert (found.lost, found.drops, found.unplugged, found.tip) == (True, 1.0, True, True)
    assert (found.camera, found.battery_percent, found.clock_s, found.push_mps) == ("black", 9.0, -60.0, (0.0, 1.0))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ([], "JSON object"),
        ({"smell": True}, "valid: robot, ranges"),
        ({"robot": "g7"}, "robots in this world: go2"),
        ({"ranges": "strange"}, "good, missing, zero, constant"),
        ({"silent": 1}, "true or false"),
        ({"jump_m": 1.0}, "two numbers"),
        ({"jump_m": [1.0, "nan"]}, "two numbers"),
        ({"jump_m": [1.0, 1e9]}, "two numbers"),
        ({"box_m": [9, 0]}, "in the room"),
        ({"camera": "blue"}, "good, dead, black"),
        ({"tip": "yes"}, "true or false"),
        ({"drops": 1.5}, "from 0 to 1"),
        ({"drops": True}, "from 0 to 1"),
        ({"battery_percent": float("nan")}, "from 0 to 100"),
        ({"push_mps": [3, 3]}, "at most 3 m/s"),
    ],
)
def test_what_cannot_be_is_refused_with_what_would_be_valid(asked, said) -> None:
    with pytest.raises(SimError, match=said):
        read(asked, ["go2"], ROOM_M)


def test_an_odometry_jumps_along_the_robots_own_axes(room_bench) -> None:
    odometry = sensors.Odometry(room_bench.body, np.random.default_rng(0), noisy=False)
    odometry._yaw = math.pi / 2
    odometry.jump(1.0, 0.5)
    assert odometry.read() == pytest.approx((-0.5, 1.0, math.pi / 2))


def test_a_box_stands_where_it_is_put_and_is_seen_and_touched_by_nobody_before(room_bench) -> None:
    ranges = sensors.Ranges(room_bench.body, np.random.default_rng(0), noisy=False)
    x, y = room_bench.body.xy_m
    free_m = ranges.read()[0]
    assert room_bench.world.put_box((x + 1.5, y))
    room_bench.run(0.1)
    assert ranges.read()[0] == pytest.approx(1.5 - 0.2 - sensors.NOSE_M, abs=0.05)
    assert not room_bench.world.put_box((x + 0.3, y)), "a robot stands there"
    room_bench.world.put_box(None)
    room_bench.run(0.1)
    assert ranges.read()[0] == pytest.approx(free_m, abs=0.05)
    assert room_bench.body.touching() == []


def test_a_body_is_shoved_and_tipped_over(room_bench) -> None:
    trouble = FaultState(room_bench.body)
    trouble.make(Faults("go2", push_mps=(0.0, 1.0)))
    assert room_bench.body.heading_velocity()[1] > 0.8
    trouble.make(Faults("go2", tip=True))
    for _ in range(100):
        trouble.tick(0.02)
        room_bench.run(0.02)
    assert room_bench.body.upright < 0.3


def test_a_robot_that_is_tipped_over_stays_down_wherever_its_legs_are_in_their_stride(bench) -> None:
    for step in range(12):
        trouble = FaultState(bench.reset().body)
        bench.sport.call(MOVE, {"x": 0.3, "y": 0.0, "z": 0.0}, lambda _: None)
        bench.run(0.5 + 0.04 * step)
        trouble.make(Faults("go2", tip=True))
        tilts = []
        for _ in range(150):
            trouble.tick(PERIOD_S)
            bench.run(PERIOD_S)
            tilts.append(bench.body.upright)
        assert max(tilts[50:]) < 0, f"{step}: upright again"


def test_calls_are_lost_as_often_as_was_asked(room_bench) -> None:
    trouble = FaultState(room_bench.body)
    for asked, least, most in ((0.0, 0, 0), (0.5, 70, 130), (1.0, 200, 200)):
        trouble.make(Faults("go2", drops=asked))
        assert least <= sum(trouble.swallows() for _ in range(200)) <= most
    trouble.make(Faults("go2", unplugged=True))
    assert trouble.swallows()
    assert trouble.mute


def test_an_empty_battery_is_exchanged_in_a_world_that_runs_for_days() -> None:
    battery, seen = sensors.Battery(), []
    for _ in range(24 * 60):
        battery.drain(0.0, 60.0)
        battery.exchange()
        seen.append(battery.percent)
    assert min(seen) >= 25


def test_a_reset_takes_the_box_away(room_bench) -> None:
    ranges = sensors.Ranges(room_bench.body, np.random.default_rng(0), noisy=False)
    free_m = ranges.read()[0]
    x, y = room_bench.body.xy_m
    assert room_bench.world.put_box((x + 1.5, y))
    room_bench.reset()
    assert ranges.read()[0] == pytest.approx(free_m, abs=0.05)


@pytest.mark.sim
def test_the_room_makes_faults_on_request_and_says_what_would_be_valid(served) -> None:
    with httpx2.Client(base_url=served.url, timeout=100) as room:
        assert room.post("/faults", json={"ranges": "missing"}).json() == {"faults": True}
        assert room.post("/faults", content=b"").json() == {"faults": True}
        refused = room.post("/faults", json={"ranges": "strange"})
        assert (refused.status_code, "constant" in refused.json()["error"]) == (422, True)
        assert room.post("/faults", content=b"{nonsense").status_code == 422
        robot = room.get("/truth").json()["robots"]["go2"]
        inside = room.post("/faults", json={"box_m": [robot["x_m"], robot["y_m"]]})
        assert (inside.status_code, "nothing was changed" in inside.json()["error"]) == (422, True)
        assert room.post("/faults", json={}, headers={"Origin": "https://evil.example"}).status_code == 403
        assert room.post("/reset").json() == {"reset": True}
