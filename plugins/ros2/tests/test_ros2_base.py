"""The base on its simulated robot, over DDS: what it tells, where it ends, and how it stops."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

import pytest
from agentrob_ros2.base import Ros2Base, Ros2Sim, steered
from agentrob_ros2.simulator import Simulator

from agentrob.config.robots import RobotConfig
from agentrob.model import Direction, Op, Outcome, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.control.controller import Velocity

pytestmark = pytest.mark.sim
LIMIT_S = 60.0
FORWARD = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)


def until(condition: Callable[[], bool], what: str) -> None:
    end_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < end_s, f"{what} within {LIMIT_S:.0f} s"
        time.sleep(0.02)


def ready(robot: Ros2Base) -> RobotState:
    until(lambda: robot.state().age_s < 0.5 and robot.state().ranges_m[0] is not None, "a state with ranges")
    until(lambda: robot.state().battery_percent is not None, "a charge")
    return robot.state()


def test_its_state_has_position_ranges_attitude_and_charge(robot: Ros2Sim, simulator: Simulator) -> None:
    state = ready(robot)
    assert state.pose is not None
    assert (state.upright, state.mode, state.velocity_mps) == (True, "idle", (0.0, 0.0))
    assert all(r is not None and 3.0 < r < 4.1 for r in state.ranges_m)  # walls of the room of 8 m
    assert state.battery_percent == pytest.approx(93.0, abs=1.0)
    assert robot.silence() == ""


def test_it_goes_where_it_was_asked_to_by_the_truth_of_its_world(robot: Ros2Sim, simulator: Simulator) -> None:
    ready(robot)
    assert robot.step(FORWARD, go_on).outcome is Outcome.DONE
    assert robot.step(Primitive(Op.TURN, Direction.LEFT, degrees=90), go_on).outcome is Outcome.DONE
    truth = simulator.apply({})
    assert math.hypot(truth["x_m"] - 1.0, truth["y_m"]) < 0.05
    assert abs(math.degrees(truth["yaw_rad"]) - 90) < 4


def test_its_last_command_is_zero_and_nothing_follows_a_stop(robot: Ros2Sim, simulator: Simulator) -> None:
    ready(robot)
    moving = threading.Event()

    def notice(state: RobotState) -> str | None:
        if state.velocity_mps and state.velocity_mps[0] > 0.2:
            moving.set()
        return None

    step = threading.Thread(target=lambda: robot.step(FORWARD, notice))
    step.start()
    assert moving.wait(LIMIT_S)
    asked_s = time.monotonic()
    stopped = robot.stop()
    step.join(LIMIT_S)
    after = [c for c in simulator.apply({"commands": True})["commands"] if c[0] > asked_s]
    assert stopped.confirmed
    assert stopped.was_moving
    zero_s = next(at_s for at_s, forward, turn in after if forward == turn == 0.0)
    assert all(forward == turn == 0.0 for at_s, forward, turn in after if at_s >= zero_s)


def test_its_position_and_speed_come_from_tf_as_well(simulator: Simulator, domain: int) -> None:
    robot = Ros2Base(RobotConfig(model="ros2", domain=domain, options={"pose": {"source": "tf"}}))
    try:
        ready(robot)
        fastest = 0.0

        def notice(state: RobotState) -> str | None:
            nonlocal fastest
            fastest = max(fastest, state.velocity_mps[0] if state.velocity_mps else 0.0)
            return None

        result = robot.step(FORWARD, notice)
        assert result.outcome is Outcome.DONE, result.message
        assert abs(simulator.apply({})["x_m"] - 1.0) < 0.05
        assert 0.3 < fastest < 0.7
        other = Ros2Base(
            RobotConfig(model="ros2", domain=domain, options={"pose": {"source": "tf", "base_frame": "b"}})
        )
        until(lambda: "has no transform from odom to b" in other.silence(), "it is told")
        other.close()
    finally:
        robot.close()


def test_a_base_that_can_go_sideways_is_sent_so_and_another_is_steered_back() -> None:
    assert steered(Velocity(0.3, 0.1, 0.0)) == Velocity(0.3, 0.0, pytest.approx(0.2))
    assert steered(Velocity(-0.3, 0.1, 0.0)) == Velocity(-0.3, 0.0, pytest.approx(-0.2))
    assert steered(Velocity(0.0, 0.1, 0.5)) == Velocity(0.0, 0.0, 0.5)
