"""How the G1's messages and states are decoded, and its description before it is connected, without a network."""

from __future__ import annotations

import math
import threading
import time

import pytest
from unitree_sdk2py.idl.default import unitree_go_msg_dds__SportModeState_

import agentrob.process.dds  # noqa: F401  before any type of the SDK
from agentrob.config.robots import LimitsConfig, RobotConfig
from agentrob.errors import RobotError
from agentrob.model import Op, RobotState
from agentrob.robots.unitree.g1 import G1, mode_of, read
from agentrob.robots.unitree.g1_fsm import FsmMonitor, parse

SIMULATED, REAL = RobotConfig(model="g1", simulated=True), RobotConfig(model="g1")


def message(roll_rad: float = 0.0, **fields: object) -> object:
    """Return an odometry message, tilted to the side by `roll_rad`."""
    state = unitree_go_msg_dds__SportModeState_()
    state.imu_state.quaternion = [math.cos(roll_rad / 2), math.sin(roll_rad / 2), 0.0, 0.0]
    for name, value in fields.items():
        setattr(state, name, value)
    return state


def test_what_it_can_do_is_known_before_it_is_connected() -> None:
    simulated, real = G1.describe(SIMULATED), G1.describe(REAL)
    assert {Op.MOVE, Op.TURN, Op.HELLO, Op.CLAP, Op.HEART, Op.SHAKE} <= simulated.ops
    assert not {Op.BACKFLIP, Op.SIT, Op.STAND, Op.STRETCH} & simulated.ops
    assert Op.GET_FRONT_IMAGE in simulated.ops
    assert Op.GET_FRONT_IMAGE not in real.ops, "a real G1 serves no pictures on DDS"
    bridged = RobotConfig(model="g1", options={"videohub": True})
    assert Op.GET_FRONT_IMAGE in G1.describe(bridged).ops
    assert (simulated.simulated, real.simulated) == (True, False)


def test_law_8_its_limits_are_those_of_a_robot_that_sees_nothing_around_it() -> None:
    limits = G1.describe(SIMULATED).limits
    assert limits.speed_mps == 0.2
    assert limits.turn_dps == pytest.approx(28.6, abs=0.1)
    slower = RobotConfig(model="g1", limits=LimitsConfig(speed_mps=0.15, turn_dps=10.0, command_s=20.0))
    found = G1.describe(slower).limits
    assert (found.speed_mps, found.turn_dps, found.command_s) == (0.15, 10.0, 20.0)


def test_an_option_it_does_not_have_is_refused() -> None:
    with pytest.raises(RobotError, match="no option height"):
        G1(RobotConfig(model="g1", options={"height": 2}))


@pytest.mark.parametrize(("roll_deg", "upright"), [(0, True), (20, True), (-45, True), (75, False), (180, False)])
def test_a_fall_is_read_from_the_robots_own_tilt(roll_deg: float, upright: bool) -> None:
    state = read(message(math.radians(roll_deg)))
    assert state.upright is upright
    assert (mode_of(state, 500, gesturing=False) == "fallen") is not upright


def test_a_robot_that_gives_no_attitude_is_not_known_to_stand() -> None:
    state = message()
    state.imu_state.quaternion = [0.0, 0.0, 0.0, 0.0]  # type: ignore[attr-defined]
    assert read(state).upright is None


@pytest.mark.parametrize(
    ("fsm", "mode"),
    [
        (500, "idle"),
        (501, "idle"),
        (200, "idle"),
        (0, "damping"),
        (1, "damping"),
        (3, "sitting"),
        (4, "locked"),
        (702, "lying"),
        (4711, "unknown"),
        (None, "unknown"),
    ],
)
def test_modes_are_read_from_the_state_of_its_motion_service(fsm: int | None, mode: str) -> None:
    standing = RobotState(0.0, upright=True, velocity_mps=(0.0, 0.0))
    assert mode_of(standing, fsm, gesturing=False) == mode


def test_walking_and_gestures_are_seen_only_where_it_can_do_them() -> None:
    walking = RobotState(0.0, upright=True, velocity_mps=(0.3, 0.0))
    turning = RobotState(0.0, upright=True, yaw_rate_rps=-0.5)
    assert [mode_of(s, 500, gesturing=False) for s in (walking, turning)] == ["walking", "walking"]
    assert mode_of(walking, 500, gesturing=True) == "gesture"
    assert mode_of(walking, 4, gesturing=True) == "locked"


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_law_9_odometry_that_is_no_number_is_unknown(bad: float) -> None:
    for position in ([bad, 0.0, 0.7], [0.0, bad, 0.7]):
        assert read(message(position=position)).pose is None
    turned = message(velocity=[0.1, bad, 0.0], yaw_speed=bad)
    turned.imu_state.rpy = [0.0, 0.0, bad]  # type: ignore[attr-defined]
    assert (read(turned).pose, read(turned).velocity_mps, read(turned).yaw_rate_rps) == (None, None, None)


def test_it_offers_no_ranges_and_no_battery() -> None:
    state = read(message(range_obstacle=[1, 2, 3, 4]))
    assert state.ranges_m == (None, None, None, None), "a G1 has no such sensors, whatever the message carries"
    assert state.battery_percent is None


@pytest.mark.parametrize(
    ("data", "found"), [('{"data": 500}', 500), ("{}", None), ("", None), (None, None), ("[1]", None), ("[", None)]
)
def test_an_answer_that_makes_no_sense_is_no_state(data: str | None, found: int | None) -> None:
    assert parse(data) == found


class Service:
    """Answers requests for the state of the motion service and counts them."""

    def __init__(self) -> None:
        self.asked, self.answer = threading.Event(), (0, '{"data": 500}')

    def _Call(self, api_id: int, parameter: str) -> tuple[int, str]:  # noqa: N802  the SDK's name
        assert (api_id, parameter) == (7001, "{}")
        self.asked.set()
        return self.answer


def test_a_robot_that_is_not_there_is_not_asked_for_its_state() -> None:
    service, there = Service(), threading.Event()
    watch = FsmMonitor(service, there.is_set)
    try:
        assert not service.asked.wait(0.5)
        assert watch.id is None
        there.set()
        assert watch.wait(60) == 500
        service.answer = (3104, "")
        until_s = time.monotonic() + 60
        while watch.id is not None:
            assert time.monotonic() < until_s, "an old answer must not count"
            service.asked.clear()
            service.asked.wait(1.0)
    finally:
        watch.close()
