"""Faults of a ROS 2 base with its guard: lost link, frozen state, refused command, wrong
units, obstacles, another program that drives it. Its simulated world tells what really happened."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
from agentrob_ros2 import messages
from agentrob_ros2.base import Ros2Base, Ros2Sim
from agentrob_ros2.network import Node, qos_of
from agentrob_ros2.options import CommandOptions
from agentrob_ros2.simulator import Simulator

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Direction, Op, Outcome, Primitive
from agentrob.robots.contract import go_on
from agentrob.robots.safety.guard import Guard

pytestmark = pytest.mark.sim
LIMIT_S = 60.0
FORWARD = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.5)
#: How a step ends when nothing came for too long.
BUSY = ("stale_state", "ranges_unknown")
#: A base may coast this far after a stop: 0.5 m/s for the time of the limit and of its wheels.
COAST_M = 0.15


def until(condition: Callable[[], Any], what: str) -> None:
    end_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < end_s, f"not within {LIMIT_S:.0f} s: {what}"
        time.sleep(0.01)


def disturbed(guard: Guard, simulator: Simulator, fault: dict[str, Any], step: Primitive = FORWARD) -> ActionResult:
    """Run a step; the fault begins when the base has gone 0.3 m.

    On a busy machine nothing may come for half a second, which ends a step as it should: then it begins again.
    """
    until(lambda: guard.state().homed and guard.state().ranges_m[0], "home and ranges")
    results: list[ActionResult] = []
    while True:
        results.clear()
        simulator.apply({"pose": [0.0, 0.0, 0.0]})
        running = threading.Thread(target=lambda: results.append(guard.step(step, go_on)))
        running.start()
        until(lambda: results or simulator.apply({})["x_m"] > 0.3, "motion")
        if not results or results[0].reason not in BUSY:
            break
    simulator.apply(fault)
    running.join(LIMIT_S)
    return results[0]


# ------------------------------------------------------------------ lost link, frozen state
@pytest.mark.parametrize("fault", ["muted", "frozen"])
def test_law_8_a_lost_or_frozen_odometry_stops_it_within_the_age_of_a_state(
    guard: Guard, simulator: Simulator, fault: str
) -> None:
    result = disturbed(guard, simulator, {fault: ["odom"]})
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    assert result.measured == {}
    assert simulator.apply({})["x_m"] < 0.3 + 0.5 * 0.75 + COAST_M  # 0.5 m/s for 0.5 s and a control period
    again = guard.step(FORWARD, go_on)
    assert (again.outcome, again.reason) == (Outcome.REFUSED, "stale_state")
    why = "The last message of /odom is" if fault == "muted" else "/odom repeats an old message"
    assert why in again.message


@pytest.mark.parametrize("fault", [{"muted": ["scan"]}, {"frozen": ["scan"]}, {"dead_scan": True}])
def test_law_8_a_lost_frozen_or_dead_scan_ends_the_step(
    guard: Guard, simulator: Simulator, fault: dict[str, Any]
) -> None:
    result = disturbed(guard, simulator, fault)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "ranges_unknown")
    assert simulator.apply({})["x_m"] < 1.3


def test_a_topic_that_nobody_publishes_is_named_in_the_refusal(domain: int) -> None:
    robot = Ros2Base(RobotConfig(model="ros2", domain=domain))
    try:
        assert f"Nobody publishes /odom (nav_msgs/msg/Odometry) on ROS domain {domain}" in robot.silence()
        assert "Nobody publishes /scan (sensor_msgs/msg/LaserScan)" in robot.silence()
        refused = robot.step(FORWARD, go_on)
        assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "no_answer")
        assert "Nobody subscribes to /cmd_vel (geometry_msgs/msg/Twist)" in refused.message
        stopped = robot.stop()
        assert not stopped.confirmed
        assert "no state ever came" in stopped.message
    finally:
        robot.close()


# ------------------------------------------------------------------ wrong QoS, wrong type
def test_a_qos_or_type_that_does_not_match_is_told(domain: int, simulator: Simulator) -> None:
    wrong = {"pose": {"durability": "transient_local", "reliability": "reliable"}, "cmd_vel": {"stamped": True}}
    robot = Ros2Base(RobotConfig(model="ros2", domain=domain, options=wrong))
    try:
        until(lambda: "QoS of /odom" in robot.silence(), "the other endpoint is known")
        assert "offered as volatile and wanted as transient_local; set durability" in robot.silence()
        until(lambda: "subscribed as" in robot.step(FORWARD, go_on).message, "the other endpoint is known")
        told = robot.step(FORWARD, go_on).message
        assert (
            told
            == "/cmd_vel is subscribed as geometry_msgs/msg/Twist, and this publishes geometry_msgs/msg/TwistStamped."
        )
    finally:
        robot.close()


# ------------------------------------------------------------------ refused command
def test_a_base_that_hears_and_does_not_move_has_failed(guard: Guard, simulator: Simulator) -> None:
    until(lambda: guard.state().homed, "home")
    simulator.apply({"braked": True})
    result = guard.step(Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5), go_on)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "stalled")
    assert result.measured["distance_m"] == 0.0
    assert "Asked 0.5 m, measured 0.00 m" in result.message


# ------------------------------------------------------------------ wrong units
def test_law_9_odometry_in_millimetres_is_a_jump_and_voids_the_home(guard: Guard, simulator: Simulator) -> None:
    result = disturbed(guard, simulator, {"units": "mm"})
    assert result.outcome is not Outcome.DONE
    assert result.measured == {}
    assert simulator.apply({})["x_m"] < 0.3 + 0.5 * 0.75 + COAST_M


@pytest.mark.parametrize(("units", "words"), [("mm", "millimetres"), ("degrees", "degrees")])
def test_a_scan_in_wrong_units_is_not_used_and_told(
    robot: Ros2Sim, simulator: Simulator, units: str, words: str
) -> None:
    simulator.apply({"units": units})
    until(lambda: "cannot be used" in robot.silence(), "it is noticed")
    assert robot.state().ranges_m == (None,) * 4
    assert words in robot.silence()


def test_a_battery_in_percent_counts_as_unknown(robot: Ros2Sim, simulator: Simulator) -> None:
    until(lambda: robot.state().battery_percent is not None, "a charge")
    simulator.apply({"units": "percent"})
    until(lambda: robot.state().battery_percent is None, "it is unknown")


# ------------------------------------------------------------------ obstacles, tipping, charge
def test_law_8_it_stops_before_a_thing_that_appears_in_its_way(guard: Guard, simulator: Simulator) -> None:
    result = disturbed(guard, simulator, {"box": [1.45, 0.1, 0.3, 0.3]})
    truth = simulator.apply({})
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "obstacle")
    assert truth["clearance_m"] > 0.05
    assert not truth["bumped"]
    again = guard.step(FORWARD, go_on)
    assert (again.outcome, again.reason) == (Outcome.REFUSED, "obstacle")


def test_law_8_a_base_that_lies_on_its_side_is_stopped_and_not_driven(guard: Guard, simulator: Simulator) -> None:
    result = disturbed(guard, simulator, {"tipped": True})
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "fallen")
    assert guard.step(FORWARD, go_on).reason == "fallen"


def test_law_8_a_low_battery_begins_no_step(guard: Guard, simulator: Simulator) -> None:
    until(lambda: guard.state().homed and guard.state().battery_percent, "home and charge")
    simulator.apply({"charge": 0.05})
    until(lambda: (guard.state().battery_percent or 100) < 10, "the charge is told")
    assert guard.step(FORWARD, go_on).reason == "low_battery"


# ------------------------------------------------------------------ another program
def test_law_12_another_program_that_drives_it_is_a_halt(guard: Guard, simulator: Simulator, domain: int) -> None:
    until(lambda: guard.state().homed, "home")
    other, ended = Node(domain, "lo"), threading.Event()
    writer = other.writer("/cmd_vel", messages.Twist, qos_of(CommandOptions()))

    def drive() -> None:
        while not ended.wait(0.05):
            writer.write(messages.Twist(messages.Vector3(0.3, 0.0, 0.0)))

    driving = threading.Thread(target=drive)
    driving.start()
    try:
        until(lambda: guard.state().halted, "the guard halts")
        refused = guard.step(FORWARD, go_on)
        assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "halted")
        assert "which we did not command" in refused.message
    finally:
        ended.set()
        driving.join(LIMIT_S)
        other.close()
