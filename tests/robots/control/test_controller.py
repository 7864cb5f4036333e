"""The closed loop in isolation: with an ideal body, a sluggish one, and one that does not move."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.model import Direction, Op, Outcome, Pose, Primitive
from agentrob.robots.control.controller import RATE_HZ, REST, Gait, MotionController, Velocity, rotate, wrap
from agentrob.robots.control.step_runner import classify_outcome, gait_for

GAIT = Gait()


class Plant:
    """A body that follows commands with a time constant."""

    def __init__(self, lag_s: float = 0.15, yaw_rad: float = 0.0) -> None:
        self.lag_s, self.pose, self.velocity, self.commands = lag_s, Pose(0.0, 0.0, yaw_rad), REST, list[Velocity]()

    def run(self, motion: MotionController, limit_s: float = 200.0) -> float:
        """Return the seconds until the motion ended."""
        dt, t = 0.01, 0.0
        per_command = round(1 / RATE_HZ / dt)
        for k in range(int(limit_s / dt)):
            if k % per_command == 0:
                command = motion.step(t, self.pose)
                if command is None:
                    return t
                self.commands.append(command)
            a = 1 - math.exp(-dt / self.lag_s) if self.lag_s else 1.0
            self.velocity = Velocity(*(v + a * (c - v) for v, c in zip(self.velocity, command, strict=True)))
            dx, dy = rotate(self.velocity.forward_mps * dt, self.velocity.left_mps * dt, self.pose.yaw_rad)
            yaw = wrap(self.pose.yaw_rad + self.velocity.turn_rps * dt)
            self.pose = Pose(self.pose.x_m + dx, self.pose.y_m + dy, yaw)
            t += dt
        raise AssertionError("the motion never ended")


@given(
    forward_m=st.floats(-5, 5),
    left_m=st.floats(-2, 2),
    yaw_rad=st.floats(-math.pi, math.pi),
    speed_mps=st.floats(0.1, 0.5),
)
def test_a_move_arrives_within_limits(forward_m: float, left_m: float, yaw_rad: float, speed_mps: float) -> None:
    if math.hypot(forward_m, left_m) < 0.05:
        return
    plant, gait = Plant(yaw_rad=yaw_rad), GAIT.at_most(speed_mps, math.radians(45))
    motion = MotionController(gait, forward_m=forward_m, left_m=left_m)
    plant.run(motion)
    assert motion.ended == "arrived"
    x, y = rotate(forward_m, left_m, yaw_rad)
    assert math.hypot(plant.pose.x_m - x, plant.pose.y_m - y) < 0.04
    assert abs(wrap(plant.pose.yaw_rad - yaw_rad)) < math.radians(4)
    for command in plant.commands:
        assert math.hypot(command.forward_mps, command.left_mps) <= speed_mps + 1e-9
        assert abs(command.left_mps) <= gait.side_mps + 1e-9
        assert abs(command.turn_rps) <= math.radians(45) + 1e-9


@given(degrees=st.floats(5, 720), left=st.booleans(), yaw_rad=st.floats(-math.pi, math.pi))
def test_a_turn_arrives_also_beyond_a_full_one(degrees: float, left: bool, yaw_rad: float) -> None:
    plant, turn_rad = Plant(yaw_rad=yaw_rad), math.radians(degrees if left else -degrees)
    motion = MotionController(GAIT, turn_rad=turn_rad)
    seconds = plant.run(motion)
    assert motion.ended == "arrived"
    assert abs(wrap(plant.pose.yaw_rad - yaw_rad - turn_rad)) < math.radians(3.5)
    assert seconds >= abs(turn_rad) / math.radians(45)  # a full turn is a rotation by 360°
    assert all(abs(command.turn_rps) <= math.radians(45) + 1e-9 for command in plant.commands)


def test_a_metre_and_a_quarter_turn_take_less_than_six_seconds() -> None:
    assert Plant().run(MotionController(GAIT, forward_m=1.0)) < 6
    assert Plant().run(MotionController(GAIT, turn_rad=math.pi / 2)) < 6


def test_a_body_that_does_not_move_is_stalled_soon() -> None:
    motion = MotionController(GAIT, forward_m=1.0)
    seconds = Plant(lag_s=1e9).run(motion)
    assert motion.ended == "stalled"
    assert seconds <= GAIT.start_s + 0.2


def test_a_body_that_is_pushed_on_and_on_times_out() -> None:
    motion, t = MotionController(GAIT, forward_m=0.5), 0.0
    while motion.step(t, Pose(-0.02 * t if t < 1 else 3 * math.sin(t), 0.0, 0.0)) is not None:
        t += 0.05
        assert t < 60
    assert motion.ended in ("timeout", "stalled", "inaccurate")


@pytest.mark.parametrize("speed_mps", [0.05, 0.2, 0.4])
def test_a_slower_turn_bounds_the_speed_of_the_corners(speed_mps: float) -> None:
    gait = gait_for(Primitive(Op.TURN, Direction.LEFT, degrees=90, speed_mps=speed_mps), GAIT)
    assert gait.turn_rps == pytest.approx(min(speed_mps / 0.4, math.radians(45)))


# ------------------------------------------------------------------ truth (law 18)
MOVE = Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0)
STRAIGHT = {"sideways_m": 0.0, "heading_deg": 0.0}


@pytest.mark.parametrize(
    ("distance_m", "outcome"),
    [
        (2.0, Outcome.DONE),
        (1.95, Outcome.DONE),
        (1.9, Outcome.INACCURATE),
        (1.3, Outcome.FAILED),
        (0.4, Outcome.FAILED),
    ],
)
def test_the_outcome_is_decided_by_what_was_measured(distance_m: float, outcome: Outcome) -> None:
    found, _, message = classify_outcome(MOVE, {"distance_m": distance_m, **STRAIGHT}, "arrived", stopped=False)
    assert found is outcome
    assert "Asked 2 m" in message
    assert f"{distance_m:.2f} m" in message


@pytest.mark.parametrize("off", [{"sideways_m": 0.2}, {"sideways_m": -0.2}, {"heading_deg": 12.0}])
def test_a_way_that_went_askew_is_not_done(off: dict[str, float]) -> None:
    outcome, word, _ = classify_outcome(MOVE, {"distance_m": 2.0, **STRAIGHT, **off}, "arrived", stopped=False)
    assert (outcome, word) == (Outcome.INACCURATE, "inaccurate")


@pytest.mark.parametrize("degrees", [15.0, 90.0, 360.0])
def test_a_turn_that_left_its_place_by_more_than_5_cm_is_not_done_however_far_it_turned(degrees: float) -> None:
    turn = Primitive(Op.TURN, Direction.LEFT, degrees=degrees)
    outcomes = [
        classify_outcome(turn, {"degrees": degrees, "drift_m": drift_m}, "arrived", stopped=False)[0]
        for drift_m in (0.049, 0.051)
    ]
    assert outcomes == [Outcome.DONE, Outcome.INACCURATE]


@given(asked=st.floats(1, 360), got=st.floats(-400, 400))
def test_a_turn_is_done_only_within_four_degrees_and_a_little(asked: float, got: float) -> None:
    primitive = Primitive(Op.TURN, Direction.LEFT, degrees=asked)
    outcome, _, _ = classify_outcome(primitive, {"degrees": got, "drift_m": 0.01}, "arrived", stopped=False)
    assert (outcome is Outcome.DONE) == (abs(got - asked) <= 4.0 + 0.005 * asked)


def test_no_zero_that_was_measured_has_a_sign() -> None:
    still = {"distance_m": -0.001, "degrees": -0.01, "drift_m": 0.0, **STRAIGHT}
    for primitive in (MOVE, Primitive(Op.TURN, Direction.LEFT, degrees=90)):
        assert "measured 0.0" in classify_outcome(primitive, still, "stop", stopped=True)[2]
