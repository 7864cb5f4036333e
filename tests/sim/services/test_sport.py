"""The sport service in simulated time: holds, actions, stops, and accurate return codes."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agentrob.sim.services import go2_sport
from agentrob.sim.services.go2_sport import Posture

GESTURES = (go2_sport.HELLO, go2_sport.HEART, go2_sport.STRETCH, go2_sport.SIT)


def test_move_is_held_one_second_and_then_it_stops(bench):
    bench.run(0.5)
    assert bench.call(go2_sport.MOVE, {"x": 0.5, "y": 0.0, "z": 0.0}) == 0
    bench.run(0.9)
    assert bench.body.heading_velocity()[0] > 0.3
    at = bench.body.xy_m
    bench.run(3.0)
    assert bench.body.standing
    assert np.hypot(*(bench.body.xy_m - at)) < 0.3


def test_the_code_says_walking_until_it_stands(bench):
    assert bench.sport.codes == (1013, 1)
    bench.call(go2_sport.MOVE, {"x": 0.5, "y": 0.0, "z": 0.0})
    bench.run(0.5)
    assert bench.sport.codes[0] == 1015
    bench.call(go2_sport.STOP_MOVE)
    assert bench.sport.codes[0] == 1015
    bench.run(3.0, lambda: bench.body.standing)
    assert bench.sport.codes[0] == 1013


def test_stop_move_stops_within_two_seconds(bench):
    bench.walk(3.0, x=1.0)
    assert bench.run(4.0, lambda: bench.body.standing) < 2.0


@pytest.mark.parametrize("gesture", [go2_sport.HELLO, go2_sport.HEART, go2_sport.STRETCH])
def test_a_gesture_is_answered_when_it_has_ended_standing(bench, gesture):
    at, began = bench.body.xy_m, bench.world.time_s
    assert bench.call(gesture) == go2_sport.OK
    assert bench.world.time_s - began > 4.0
    bench.run(2.0)
    assert bench.body.standing
    assert bench.body.upright > 0.99
    assert np.hypot(*(bench.body.xy_m - at)) < 0.25


def test_hello_lifts_and_waves_the_right_fore_paw(bench):
    geom = bench.world.model.geom("go2/FR").id
    answers: list[int] = []
    bench.sport.call(go2_sport.HELLO, {}, answers.append)
    heights, sides = [], []
    while not answers:
        bench.run(0.02)
        _, y, z = bench.world.data.geom_xpos[geom]
        heights.append(z)
        if z > 0.2:
            sides.append(y)
    assert max(heights) > 0.3
    swings = np.diff(np.sign(np.diff(np.array(sides)))).nonzero()[0]
    assert len(swings) >= 4


def test_a_second_gesture_while_one_runs_is_refused(bench):
    first: list[int] = []
    bench.sport.call(go2_sport.HELLO, {}, first.append)
    bench.run(1.0)
    assert bench.call(go2_sport.HEART) == go2_sport.BUSY
    assert bench.call(go2_sport.MOVE, {"x": 0.3, "y": 0, "z": 0}) == go2_sport.BUSY
    bench.run(10.0, lambda: bool(first))
    assert first == [go2_sport.OK]


@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(gesture=st.sampled_from(GESTURES), after_s=st.floats(0.0, 8.0), walked_s=st.floats(0.0, 1.0))
def test_a_stop_at_any_moment_of_a_gesture_ends_standing(bench, gesture, after_s, walked_s):
    bench.reset()
    bench.walk(walked_s, x=0.5, z=0.4)
    answers: list[int] = []
    bench.sport.call(gesture, {}, answers.append)
    bench.run(after_s)
    ended_before = bool(answers)
    sitting = bench.sport.posture is Posture.SITTING
    assert bench.call(go2_sport.STOP_MOVE) == go2_sport.OK
    waited = bench.run(4.0, lambda: bool(answers))
    assert waited < 2.5
    assert answers == ([go2_sport.OK] if ended_before else [go2_sport.BROKEN_OFF])
    bench.run(2.0)
    assert bench.body.upright > (0.6 if sitting else 0.99)
    assert bench.sport.posture is (Posture.SITTING if sitting else Posture.BALANCE)


def test_it_sits_until_it_is_reported_to_rise(bench):
    assert bench.call(go2_sport.SIT) == go2_sport.OK
    bench.run(3.0)
    assert bench.sport.posture is Posture.SITTING
    assert bench.body.rotation[2, 0] > 0.4  # nose up
    for unsuitable in (go2_sport.SIT, go2_sport.HELLO, go2_sport.BALANCE_STAND):
        assert bench.call(unsuitable) == go2_sport.UNSUITABLE
    assert bench.call(go2_sport.MOVE, {"x": 0.3, "y": 0, "z": 0}) == go2_sport.UNSUITABLE
    assert bench.call(go2_sport.RISE_SIT) == go2_sport.OK
    assert bench.call(go2_sport.RISE_SIT) == go2_sport.UNSUITABLE
    bench.run(2.0)
    assert bench.body.standing


def test_standing_up_locks_the_joints_until_balance_stand(bench):
    assert bench.call(go2_sport.STAND_DOWN) == go2_sport.OK
    assert bench.body.z_m < 0.15
    assert bench.call(go2_sport.BALANCE_STAND) == go2_sport.UNSUITABLE
    assert bench.call(go2_sport.STAND_UP) == go2_sport.OK
    assert bench.sport.codes == (1002, 6)
    at = bench.body.xy_m
    assert bench.call(go2_sport.MOVE, {"x": 0.5, "y": 0, "z": 0}) == go2_sport.UNSUITABLE
    bench.run(1.0)
    assert np.hypot(*(bench.body.xy_m - at)) < 0.02
    assert bench.call(go2_sport.BALANCE_STAND) == go2_sport.OK
    bench.walk(1.0, x=0.5)
    assert np.hypot(*(bench.body.xy_m - at)) > 0.3


def test_damp_goes_limp_at_once_and_recovery_stand_rises(bench):
    bench.walk(1.0, x=0.5)
    assert bench.call(go2_sport.DAMP) == go2_sport.OK
    assert bench.sport.codes[0] == 1001
    bench.run(3.0)
    assert bench.body.z_m < 0.2
    assert bench.call(go2_sport.MOVE, {"x": 0.5, "y": 0, "z": 0}) == go2_sport.UNSUITABLE
    assert bench.call(go2_sport.RECOVERY_STAND) == go2_sport.OK
    bench.run(2.0)
    assert bench.body.standing
    assert bench.body.z_m > 0.28


def test_on_its_back_it_is_limp_and_does_not_pretend_to_rise(bench):
    bench.world.data.qpos[bench.body.root_q + 3 : bench.body.root_q + 7] = [0.0, 1.0, 0.0, 0.0]
    bench.run(1.0)
    assert bench.sport.posture is Posture.LIMP
    assert bench.call(go2_sport.RECOVERY_STAND) == go2_sport.UNSUITABLE


@pytest.mark.parametrize("api_id", [2041, 1007, 1015, 1061, 9999, 0])
def test_what_is_not_there_is_said_to_be_not_there(bench, api_id):
    assert bench.call(api_id) == go2_sport.NOT_IMPLEMENTED


@pytest.mark.parametrize(
    "parameter",
    [{}, {"x": 0.5}, {"x": "fast", "y": 0, "z": 0}, {"x": math.nan, "y": 0, "z": 0}, {"x": math.inf, "y": 0, "z": 0}],
)
def test_a_move_that_makes_no_sense_moves_nothing(bench, parameter):
    assert bench.call(go2_sport.MOVE, parameter) == go2_sport.BAD_PARAMETER
    bench.run(1.0)
    assert bench.body.standing


def test_a_reset_breaks_off_what_runs(bench):
    answers: list[int] = []
    bench.sport.call(go2_sport.HELLO, {}, answers.append)
    bench.run(3.0)
    bench.reset()
    assert answers == [go2_sport.BROKEN_OFF]
    assert bench.sport.posture is Posture.BALANCE
    assert bench.call(go2_sport.BALANCE_STAND) == go2_sport.OK
