"""The control loop of one step."""

from __future__ import annotations

import math

from agentrob.config.robots import RobotConfig
from agentrob.model import Direction, Op, Outcome, Primitive, RobotState
from agentrob.robots.control.controller import Gait
from agentrob.robots.control.step_runner import run_step
from agentrob.robots.fake import FakeRobot

GAIT = Gait(gain_speed=3.0, gain_turn=4.0, coast_s=0.15, coast_turn_s=0.15, settle_s=0.4)


def test_a_control_loop_that_rests_for_a_moment_sees_no_jump_of_the_odometry() -> None:
    robot = FakeRobot(RobotConfig(model="fake", simulated=True, options={"time_scale": math.inf}))
    looks = 0

    def busy_machine(_: RobotState) -> str | None:
        """Take 0.9 s between reading the state and the time, once while the robot turns."""
        nonlocal looks
        looks += 1
        if looks == 20:
            robot.wait_until(robot.now_s() + 0.9)
        return None

    turn = Primitive(Op.TURN, Direction.LEFT, degrees=120)
    result = run_step(robot, turn, GAIT.at_most(0.5, 0.785), busy_machine)
    assert looks > 20
    assert result.unmeasured == ""
    assert (result.outcome, result.reason) == (Outcome.DONE, "")
