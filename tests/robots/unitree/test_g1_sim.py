"""The G1 on real DDS: the contract, and what only a real network shows, against the simulated world's process."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.config.robots import FenceConfig, RobotConfig
from agentrob.model import ActionResult, Direction, Op, Outcome, Pose, Primitive, RobotState
from agentrob.robots.contract import RobotContract, apart_m, fresh, go_on
from agentrob.robots.control.controller import STOPPED_WINDOW_S, RestDetector, Velocity
from agentrob.robots.protocol import Robot
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from agentrob.robots.unitree.g1 import G1
from tests.host_numbers import dds_number
from tests.waiting import wait_for

#: The domain of the Go2's tests: the SDK joins one DDS domain per process, and their world has ended before.
DOMAIN = 171 + dds_number()
SETTINGS = RobotConfig(model="g1", domain=DOMAIN, simulated=True, home_on_start=True)
#: The speed of its world relative to real time.
PACE = 4
#: Longer than the latency of a message, and than the window that a stop examines.
THERE_S = 0.6
NEAR = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.3)

pytestmark = pytest.mark.sim


@pytest.fixture(scope="module")
def room() -> Iterator[str]:
    """Start the simulated world in its own process; return the address of the room."""
    command = [sys.executable, "-m", "agentrob.sim.server", "--domain", f"g1={DOMAIN}", "--pace", str(PACE)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield json.loads(process.stdout.readline())["http"]
    process.send_signal(signal.SIGTERM)
    process.wait(60)


@pytest.fixture(scope="module")
def connected(room: str) -> Iterator[G1]:
    """One per module: the SDK joins one DDS domain per process."""
    robot = G1(SETTINGS)
    yield robot
    robot.close()


@pytest.fixture
def g1(connected: G1, room: str) -> G1:
    """Wait until it is at its start: a reset sets the odometry to zero, and older messages may arrive later."""
    httpx2.post(room + "/reset", timeout=100).raise_for_status()
    since_s = math.inf

    def ready() -> bool:
        nonlocal since_s
        state, now_s = connected.state(), time.monotonic()
        pose = state.pose or Pose(math.inf, 0.0, 0.0)
        there = math.hypot(pose.x_m, pose.y_m) < 0.05 and abs(pose.yaw_rad) < 0.05
        since_s = min(since_s, now_s) if there and state.mode == "idle" and state.age_s < 0.2 else math.inf
        return now_s - since_s > THERE_S

    wait_for(ready)
    return connected


class TestG1OnTheSimulatedWorld(RobotContract):
    @pytest.fixture
    def robot(self, g1: G1) -> Robot:
        return g1


@pytest.mark.parametrize(
    "op", [Op.HEART, pytest.param(Op.CLAP, marks=pytest.mark.slow), pytest.param(Op.SHAKE, marks=pytest.mark.slow)]
)
def test_a_gesture_is_done_and_leaves_the_arms_free(g1: G1, op: Op) -> None:
    result = g1.step(Primitive(op), go_on)
    assert result.outcome is Outcome.DONE, result.message
    assert g1._arm.ExecuteAction(26) == 0, "an arm that still held would answer 7401"


def test_a_picture_shows_the_room(g1: G1) -> None:
    result = g1.step(Primitive(Op.GET_FRONT_IMAGE), go_on)
    assert result.ok, result.message
    assert result.image is not None
    assert len(result.image) > 5000


def begun(g1: G1, op: Op, looks: int) -> tuple[threading.Thread, list[ActionResult]]:
    """Run a gesture in its own thread until the watch has seen it this often (20 times per real second)."""
    results, running, seen = list[ActionResult](), threading.Event(), list[RobotState]()

    def watch(state: RobotState) -> str | None:
        if state.mode == "gesture":
            seen.append(state)
        if len(seen) >= looks:
            running.set()
        return None

    thread = threading.Thread(target=lambda: results.append(g1.step(Primitive(op), watch)))
    thread.start()
    assert running.wait(60)
    return thread, results


MORE = ((Op.HELLO, 30), (Op.CLAP, 50), (Op.HEART, 90))


@pytest.mark.parametrize(
    ("op", "looks"), [(Op.HEART, 40), *(pytest.param(*case, marks=pytest.mark.slow) for case in MORE)]
)
def test_law_14_a_stop_ends_a_gesture_and_the_arms_come_down(g1: G1, op: Op, looks: int) -> None:
    thread, results = begun(g1, op, looks // PACE)
    asked_s = time.monotonic()
    stopped = g1.stop()
    thread.join(60)
    assert (results[0].outcome, results[0].reason) == (Outcome.STOPPED, "stop")
    assert stopped.was_moving
    assert stopped.confirmed, stopped.message
    assert time.monotonic() - asked_s < 4.0
    assert g1.step(Primitive(Op.HELLO), go_on).ok


def test_law_12_and_14_it_is_not_unlocked_after_an_objection_and_never_got_up_from_damping(g1: G1, room: str) -> None:
    assert fsm(g1, 4) == 0  # like an operator's remote control
    wait_for(lambda: g1.state().mode == "locked")
    stopped = g1.step(NEAR, lambda _: "lease_lapsed")
    assert (stopped.outcome, stopped.reason) == (Outcome.STOPPED, "lease_lapsed")
    assert json.loads(g1._sport._Call(7001, "{}")[1])["data"] == 4
    assert g1.step(NEAR, go_on).ok, "without an objection it is unlocked and walks"
    assert fsm(g1, 1) == 0
    wait_for(lambda: g1.state().mode in ("damping", "fallen"))
    refused = g1.step(NEAR, go_on)
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "posture")
    assert json.loads(g1._sport._Call(7001, "{}")[1])["data"] == 1


def fsm(g1: G1, state: int) -> Any:
    return g1._sport._Call(7101, json.dumps({"data": state}))[0]


def test_a_driver_that_falls_silent_leaves_it_walking_no_longer_than_half_a_second(g1: G1) -> None:
    start, rest = fresh(g1), RestDetector(STOPPED_WINDOW_S)

    def walks() -> bool:
        g1.command(Velocity(0.2))
        return apart_m(start, g1.state()) > 0.3

    def rests() -> bool:
        pose = g1.state().pose
        return pose is not None and rest.update(time.monotonic(), pose)

    wait_for(walks)
    silent = g1.state()
    wait_for(rests)
    assert apart_m(silent, g1.state()) < 0.3


@pytest.mark.parametrize(("consent", "reason"), [(False, "ranges_unknown"), (True, "")])
def test_law_8_it_walks_blind_only_with_the_owners_consent(g1: G1, tmp_path: Path, consent: bool, reason: str) -> None:
    fence = FenceConfig(x_min_m=-1, x_max_m=1, y_min_m=-1, y_max_m=1)
    settings = SETTINGS.model_copy(update={"allow_unknown_ranges": consent, "fence": fence})
    guard = Guard(g1, settings, Halt(tmp_path / "halt"))
    try:
        result = guard.step(NEAR, go_on)
        assert result.reason == reason, result.message
        assert result.ok is consent
        turned = guard.step(Primitive(Op.TURN, Direction.LEFT, degrees=30.0), go_on)
        assert turned.ok is consent
        if consent:
            assert "range readings are unknown" in turned.message
            seconds, degrees = turned.path[-1][0], abs(math.degrees(turned.path[-1][3] - turned.path[0][3]))
            assert degrees / seconds < 30
            outside = guard.step(Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0), go_on)
            assert (outside.outcome, outside.reason) == (Outcome.REFUSED, "fence")
            fast = guard.step(Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.3, speed_mps=0.4), go_on)
            assert (fast.outcome, fast.reason) == (Outcome.REFUSED, "limit_speed_mps")
    finally:
        guard._closed.set()
