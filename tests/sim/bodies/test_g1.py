"""The G1 in physics, in simulated time: it stands, walks, turns and gestures, and its services tell the truth."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pytest

from agentrob.sim.bodies.g1 import G1, VELOCITY_BOUND
from agentrob.sim.bodies.g1_gestures import GESTURES, RELEASE
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.bodies.sensors import Ranges, wrap
from agentrob.sim.event_log import EventLog
from agentrob.sim.rendering.view import front_view
from agentrob.sim.services import g1_sport
from agentrob.sim.services.g1_sport import G1Sport
from agentrob.sim.world.legged import PERIOD_S
from agentrob.sim.world.scene import OPEN_FLOOR
from agentrob.sim.world.world import World

CLAP, HEART, WAVE, SHAKE = 17, 20, 26, 27


@dataclass
class G1Bench:
    """A G1 with its services in simulated time."""

    world: World
    body: G1
    sport: G1Sport

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> float:
        """Let simulated time pass; return how much did."""
        for tick in range(round(seconds / PERIOD_S)):
            if until():
                return tick * PERIOD_S
            self.sport.tick()
            self.world.tick()
        return seconds

    def call(self, api_id: int, parameter: Mapping[str, Any] | None = None, limit_s: float = 20.0) -> tuple[int, Any]:
        """Call `sport` and let time pass until it is answered; return code and data."""
        return self.answered(lambda answer: self.sport.call(api_id, parameter or {}, answer), limit_s)

    def arm(self, action: Any, limit_s: float = 20.0) -> int:
        """Call `arm` and let time pass until it is answered."""
        return self.answered(lambda answer: self.begin(action, answer), limit_s)[0]

    def begin(self, action: Any, answer: Callable[..., None]) -> None:
        self.sport.call_arm(g1_sport.EXECUTE_ACTION, {"data": action}, answer)

    def answered(self, call: Callable[[Callable[..., None]], None], limit_s: float) -> tuple[int, Any]:
        answers: list[tuple[int, Any]] = []
        call(lambda code, data="": answers.append((code, json.loads(data)["data"] if data else None)))
        self.run(limit_s, lambda: bool(answers))
        assert len(answers) == 1
        return answers[0]

    def go(self, x: float = 0.0, y: float = 0.0, w: float = 0.0, duration: float = 1.0) -> int:
        return self.call(g1_sport.SET_VELOCITY, {"velocity": [x, y, w], "duration": duration})[0]

    def walk(self, seconds: float, x: float = 0.0, y: float = 0.0, w: float = 0.0) -> None:
        """Send a velocity at 10 Hz, then zero."""
        for _ in range(round(seconds / 0.1)):
            assert self.go(x, y, w) == g1_sport.OK
            self.run(0.1)
        assert self.go() == g1_sport.OK
        self.run(4.0, lambda: self.body.standing)

    def height_m(self, part: str) -> float:
        return float(self.world.data.body(f"g1/{part}").xpos[2])

    def hand(self, side: str) -> Any:
        """Return the position of the palm."""
        wrist = self.world.data.body(f"g1/{side}_wrist_yaw_link")
        return wrist.xpos + wrist.xmat.reshape(3, 3) @ [0.09, 0.0, 0.0]

    def reset(self) -> G1Bench:
        self.world.reset()
        self.sport.reset()
        return self


@pytest.fixture(scope="module")
def open_floor() -> G1Bench:
    body = G1()
    world = World([body], OPEN_FLOOR)
    return G1Bench(world, body, G1Sport(body, lambda: world.time_s, EventLog()))


@pytest.fixture
def bench(open_floor: G1Bench) -> G1Bench:
    """A G1 at its start on an endless floor, looking along -x."""
    return open_floor.reset()


@pytest.fixture(scope="module")
def both() -> World:
    """A Go2 and a G1 in the furnished room."""
    return World([Go2(), G1()])


# ------------------------------------------------------------------ the body
def test_it_stands_without_falling_and_keeps_its_place(bench: G1Bench) -> None:
    at, yaw = bench.body.xy_m, bench.body.yaw_rad
    bench.run(20.0)
    assert np.hypot(*(bench.body.xy_m - at)) < 0.10
    assert abs(math.degrees(wrap(bench.body.yaw_rad - yaw))) < 8
    assert bench.body.upright > 0.99
    assert bench.body.standing


@pytest.mark.parametrize(("x", "y"), [(0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2), (0.5, 0.0)])
def test_it_walks_every_way_without_falling(bench: G1Bench, x: float, y: float) -> None:
    at = bench.body.xy_m
    bench.walk(5.0, x, y)
    dx, dy = bench.body.xy_m - at  # it looks along x
    asked = 5.0 * math.hypot(x, y)
    assert (dx * x + dy * y) / math.hypot(x, y) == pytest.approx(asked, rel=0.5)
    assert bench.body.upright > 0.99
    assert bench.body.standing


@pytest.mark.parametrize("way", [1, -1])
def test_it_turns_both_ways_on_the_spot(bench: G1Bench, way: int) -> None:
    at, yaw = bench.body.xy_m, bench.body.yaw_rad
    bench.walk(3.0, w=0.5 * way)
    assert 50 < way * math.degrees(wrap(bench.body.yaw_rad - yaw)) < 110
    assert np.hypot(*(bench.body.xy_m - at)) < 0.15
    assert bench.body.upright > 0.99


def test_a_velocity_beyond_what_the_policy_follows_is_clipped(bench: G1Bench) -> None:
    bench.walk(4.0, 50.0, -50.0, 50.0)
    assert bench.body.upright > 0.9
    assert np.all(np.abs(bench.body.heading_velocity()) < 1.6 * VELOCITY_BOUND)


@pytest.mark.parametrize("seed", range(8))
def test_stopped_at_any_moment_of_any_walk_it_comes_to_rest_on_its_feet(bench: G1Bench, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(3):
        x, y, w = rng.uniform([-0.3, -0.2, -0.6], [0.5, 0.2, 0.6])
        for _ in range(rng.integers(2, 15)):
            bench.go(x, y, w)
            bench.run(0.1)
    bench.go()
    assert bench.run(6.0, lambda: bench.body.standing) < 3.0
    bench.run(2.0)
    assert bench.body.upright > 0.99


def test_a_velocity_is_held_as_long_as_it_was_given_and_no_longer(bench: G1Bench) -> None:
    assert bench.go(0.4, duration=0.5) == g1_sport.OK
    assert bench.run(3.0, lambda: bench.call(g1_sport.GET_FSM_MODE)[1] == 0) < 2.5
    at = bench.body.xy_m
    bench.run(2.0)
    assert np.hypot(*(bench.body.xy_m - at)) < 0.05


def test_limp_it_falls_and_does_not_pretend_to_get_up(bench: G1Bench) -> None:
    assert bench.call(g1_sport.SET_FSM_ID, {"data": 1})[0] == g1_sport.OK
    bench.run(4.0)
    assert bench.body.upright < 0.7
    assert bench.body.z_m < 0.5
    assert bench.call(g1_sport.SET_FSM_ID, {"data": 500})[0] == g1_sport.UNSUITABLE
    assert bench.go(0.2) == g1_sport.UNSUITABLE
    assert bench.arm(WAVE) == g1_sport.ARM_WRONG_FSM
    assert bench.reset().call(g1_sport.GET_FSM_ID) == (g1_sport.OK, 500)
    assert bench.body.upright > 0.99


# ------------------------------------------------------------------ gestures
def test_a_wave_lifts_the_right_hand_and_swings_it(bench: G1Bench) -> None:
    answers: list[int] = []
    at = bench.body.xy_m
    bench.begin(WAVE, lambda code, *_: answers.append(code))
    heights, sides = [], []
    while not answers:
        bench.run(PERIOD_S)
        heights.append(bench.height_m("right_wrist_yaw_link"))
        if heights[-1] > bench.height_m("torso_link") + 0.35:
            sides.append(bench.world.data.body("g1/right_wrist_yaw_link").xpos[1])
    assert answers == [g1_sport.OK]
    assert max(heights) > 1.3
    assert len(np.diff(np.sign(np.diff(np.array(sides)))).nonzero()[0]) >= 5
    assert np.hypot(*(bench.body.xy_m - at)) < 0.10


def test_a_clap_brings_the_hands_together_and_apart(bench: G1Bench) -> None:
    answers: list[int] = []
    bench.begin(CLAP, lambda code, *_: answers.append(code))
    apart_m = []
    while not answers:
        bench.run(PERIOD_S)
        apart_m.append(float(np.linalg.norm(bench.hand("left") - bench.hand("right"))))
    assert answers == [g1_sport.OK]
    assert min(apart_m) < 0.10
    claps = np.diff(np.array(apart_m) < 0.14).nonzero()[0]
    assert len(claps) >= 6


@pytest.mark.parametrize("action", GESTURES)
def test_after_every_gesture_it_stands_where_it_stood(bench: G1Bench, action: int) -> None:
    at, yaw = bench.body.xy_m, bench.body.yaw_rad
    assert bench.arm(action) == g1_sport.OK
    if GESTURES[action].holds:
        bench.run(2.0)
        assert bench.arm(WAVE) == g1_sport.ARM_HOLDING
        assert bench.arm(RELEASE) == g1_sport.OK
    bench.run(2.0)
    assert bench.body.upright > 0.99
    assert np.hypot(*(bench.body.xy_m - at)) < 0.30
    assert abs(math.degrees(wrap(bench.body.yaw_rad - yaw))) < 20
    bench.walk(2.0, 0.3)
    assert np.hypot(*(bench.body.xy_m - at)) > 0.3


def test_what_the_arm_cannot_do_is_reported_by_its_code(bench: G1Bench) -> None:
    for unknown in (4711, "wave", None, [17], 17.5):
        assert bench.arm(unknown) == g1_sport.ARM_BAD_ID
    assert bench.arm(RELEASE) == g1_sport.OK
    answers: list[int] = []
    bench.begin(CLAP, lambda code, *_: answers.append(code))
    bench.run(1.0)
    assert bench.arm(WAVE) == g1_sport.ARM_BUSY
    assert bench.go(0.2) == g1_sport.BUSY
    assert bench.go() == g1_sport.OK
    bench.run(10.0, lambda: bool(answers))
    assert answers == [g1_sport.OK]
    assert bench.call(g1_sport.SET_FSM_ID, {"data": 4})[0] == g1_sport.OK
    assert bench.arm(WAVE) == g1_sport.ARM_WRONG_FSM


@pytest.mark.parametrize("after_s", [0.0, 0.5, 1.5, 3.0, 4.5])
@pytest.mark.parametrize("action", GESTURES)
def test_law_14_a_release_at_any_moment_ends_the_gesture_with_the_arms_down(
    bench: G1Bench, action: int, after_s: float
) -> None:
    answers: list[int] = []
    bench.begin(action, lambda code, *_: answers.append(code))
    bench.run(after_s)
    before = list(answers)
    assert bench.arm(RELEASE, limit_s=6.0) == g1_sport.OK
    assert answers == (before or [g1_sport.BROKEN_OFF])
    bench.run(1.0)
    assert bench.height_m("right_wrist_yaw_link") < bench.height_m("torso_link") + 0.15
    bench.run(1.0)
    assert bench.body.upright > 0.99
    assert bench.arm(WAVE) == g1_sport.OK


def test_the_arm_tasks_of_the_sport_service_wave_and_shake(bench: G1Bench) -> None:
    assert bench.call(g1_sport.SET_ARM_TASK, {"data": g1_sport.WAVE})[0] == g1_sport.OK
    assert bench.call(g1_sport.SET_ARM_TASK, {"data": g1_sport.SHAKE_BEGIN})[0] == g1_sport.OK
    assert bench.height_m("right_wrist_yaw_link") > bench.height_m("left_wrist_yaw_link") + 0.1
    assert bench.call(g1_sport.SET_ARM_TASK, {"data": g1_sport.SHAKE_END})[0] == g1_sport.OK
    assert bench.call(g1_sport.SET_ARM_TASK, {"data": g1_sport.WAVE_TURNING})[0] == g1_sport.NOT_IMPLEMENTED


# ------------------------------------------------------------------ the sport service
def test_its_state_is_reported_by_the_api_ids(bench: G1Bench) -> None:
    assert bench.call(g1_sport.GET_FSM_ID) == (g1_sport.OK, 500)
    assert bench.call(g1_sport.GET_FSM_MODE) == (g1_sport.OK, 0)
    assert bench.call(g1_sport.GET_BALANCE_MODE) == (g1_sport.OK, 0)
    assert bench.call(g1_sport.GET_STAND_HEIGHT)[1] == pytest.approx(0.77, abs=0.03)
    bench.go(0.3)
    bench.run(1.0)
    assert bench.call(g1_sport.GET_FSM_MODE) == (g1_sport.OK, 1)


def test_locked_it_stands_and_takes_no_velocity_until_it_is_unlocked(bench: G1Bench) -> None:
    assert bench.call(g1_sport.SET_FSM_ID, {"data": 4})[0] == g1_sport.OK
    at = bench.body.xy_m
    assert bench.go(0.3) == g1_sport.UNSUITABLE
    bench.run(2.0)
    assert np.hypot(*(bench.body.xy_m - at)) < 0.05
    assert bench.call(g1_sport.SET_FSM_ID, {"data": 500})[0] == g1_sport.OK
    bench.walk(2.0, 0.3)
    assert np.hypot(*(bench.body.xy_m - at)) > 0.3


@pytest.mark.parametrize("api_id", [7004, 7103, 7104, 1008, 9999])
def test_what_is_not_there_is_said_to_be_not_there(bench: G1Bench, api_id: int) -> None:
    assert bench.call(api_id, {"data": 0})[0] == g1_sport.NOT_IMPLEMENTED


@pytest.mark.parametrize(
    "parameter",
    [
        {},
        {"velocity": [0.2, 0.0]},
        {"velocity": ["fast", 0, 0]},
        {"velocity": 0.3},
        {"velocity": [math.nan, 0, 0]},
        {"velocity": [0.2, 0, math.inf]},
        {"velocity": [0.2, 0, 0], "duration": -1},
        {"velocity": [0.2, 0, 0], "duration": "long"},
    ],
)
def test_a_velocity_that_makes_no_sense_moves_nothing(bench: G1Bench, parameter: dict[str, Any]) -> None:
    assert bench.call(g1_sport.SET_VELOCITY, parameter)[0] == g1_sport.BAD_PARAMETER
    bench.run(1.0)
    assert bench.body.standing


@pytest.mark.parametrize("data", [200, 702, -1, "500", None, [500]])
def test_a_state_that_is_not_simulated_is_refused(bench: G1Bench, data: Any) -> None:
    assert bench.call(g1_sport.SET_FSM_ID, {"data": data})[0] == g1_sport.BAD_PARAMETER
    assert bench.call(g1_sport.GET_FSM_ID) == (g1_sport.OK, 500)


# ------------------------------------------------------------------ in one room
@pytest.mark.parametrize(("seer", "seen"), [("go2", "g1"), ("g1", "go2")])
def test_each_robot_sees_the_other_from_its_start(both: World, seer: str, seen: str) -> None:
    both.reset()
    view = front_view(both.model, seer)
    camera = both.data.cam(f"{seer}/front")
    axes = camera.xmat.reshape(3, 3)
    root = next(r for r in both.robots if r.name == seen)
    right, up, back = axes.T @ (both.data.xpos[root.body] - camera.xpos)
    half = math.tan(math.radians(both.model.cam(f"{seer}/front").fovy[0]) / 2)
    assert back < 0, "it is ahead of the camera"
    assert abs(up) < half * -back
    assert abs(right) < half * -back * view.width / view.height


def test_two_robots_side_by_side_stand_and_walk(both: World) -> None:
    both.reset()
    go2, g1 = both.robots
    assert isinstance(go2, Go2)
    assert isinstance(g1, G1)
    starts = [r.xy_m for r in both.robots]
    go2.walk(np.array([0.5, 0.0, 0.0]))
    g1.walk(np.array([0.2, 0.0, 0.0]))
    both.run(4.0)
    assert [np.hypot(*(r.xy_m - s)) > 0.4 for r, s in zip(both.robots, starts, strict=True)] == [True, True]
    assert min(r.upright for r in both.robots) > 0.97
    assert not any(r.touching() for r in both.robots)


def test_the_go2_feels_the_g1_by_its_ranges(both: World) -> None:
    both.reset()
    go2, g1 = both.robots
    ranges = Ranges(go2, np.random.default_rng(0), noisy=False)
    assert ranges.read()[0] > 3.0
    both.data.qpos[g1.root_q : g1.root_q + 2] = go2.xy_m + np.array([1.2, 0.0])
    mujoco.mj_forward(both.model, both.data)
    assert 0.5 < ranges.read()[0] < 1.0
