"""Against Reachy Mini's own daemon in its `--mockup-sim` mode, in a process with packages of its own."""

from __future__ import annotations

import json
import math
import os
import signal
import socket
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import httpx2
import pytest
from agentrob_reachy_mini.daemon import Daemon
from agentrob_reachy_mini.pose import BodyPose, apart_rad
from agentrob_reachy_mini.robot import ReachyMini
from agentrob_reachy_mini.simulator import IN_CHECKOUT, VARIABLE, running_daemon
from reachy_scene import LIMIT_S, act, disturbed, ready, turn, until

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Direction, Outcome, RobotState
from agentrob.robots.contract import RobotContract, go_on
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt

pytestmark = pytest.mark.slow
INSTALLED = Path(__file__).parents[3] / IN_CHECKOUT
CHEER = {"dataset": "someone/moves", "words": {"en": "cheer"}, "seconds": 5}


def recorded_move(seconds: float) -> dict[str, object]:
    """A move of a library: the head turns to the left and back, 50 times a second."""
    count = int(seconds * 50)
    frames = []
    for i in range(count):
        yaw = math.radians(20) * math.sin(math.pi * i / count)
        c, s = math.cos(yaw), math.sin(yaw)
        head = [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        frames.append({"head": head, "antennas": [0.0, 0.0], "body_yaw": 0.0, "check_collision": False})
    return {"description": "a look", "time": [i / 50 for i in range(count)], "set_target_data": frames}


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A library of moves as the daemon keeps it once it was downloaded."""
    home = tmp_path_factory.mktemp("moves")
    library = home / "hub/datasets--someone--moves"
    (library / "refs").mkdir(parents=True)
    (library / "refs/main").write_text("0123456789abcdef0123456789abcdef01234567")
    snapshot = library / "snapshots/0123456789abcdef0123456789abcdef01234567"
    snapshot.mkdir(parents=True)
    (snapshot / "cheer_1.json").write_text(json.dumps(recorded_move(2.0)))
    return home


Start = Callable[[], tuple[str, subprocess.Popen[bytes]]]


@pytest.fixture(scope="module")
def start(cache: Path) -> Iterator[Start]:
    running: list[AbstractContextManager[subprocess.Popen[bytes]]] = []
    assert (INSTALLED.parents[1] / ".stamp").exists(), "it is not installed; scripts/reachy-mini-daemon does"

    def begin() -> tuple[str, subprocess.Popen[bytes]]:
        listening = socket.create_server(("127.0.0.1", 0))
        url = f"http://127.0.0.1:{listening.getsockname()[1]}"
        context = running_daemon(listening, url, cache)
        process = context.__enter__()
        running.append(context)
        return url, process

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(INSTALLED))
        yield begin
    for context in running:
        context.__exit__(None, None, None)


@pytest.fixture(scope="module")
def url(start: Start) -> str:
    """A daemon that the tests share."""
    return start()[0]


@pytest.fixture
def robot(url: str) -> Iterator[ReachyMini]:
    straight(url)
    reachy = ReachyMini(RobotConfig(model="reachy-mini", simulated=True, options={"url": url}))
    ready(reachy)
    yield reachy
    reachy.close()


def straight(url: str) -> None:
    daemon = Daemon(url)
    until(lambda: not daemon.running(), "it is at rest")
    daemon.goto(BodyPose(), 0.5)
    until(lambda: not daemon.running() and apart_rad(daemon.state().pose, BodyPose()) < 0.01, "it is straight")
    daemon.close()


class TestContract(RobotContract):
    """The contract of every robot, against the real daemon."""


def test_a_turn_takes_the_head_along_beyond_the_reach_of_its_neck(robot: ReachyMini, url: str) -> None:
    assert robot.step(turn(120), go_on).outcome is Outcome.DONE
    daemon = Daemon(url)
    pose = daemon.state().pose
    daemon.close()
    assert math.degrees(pose.body_yaw) == pytest.approx(120, abs=2)
    assert math.degrees(pose.head_yaw) == pytest.approx(120, abs=2)


def test_angles_are_what_was_asked(robot: ReachyMini, url: str) -> None:
    daemon = Daemon(url)
    for step, axis, degrees in (
        (act("look_up", angle_deg=25.0), "pitch", -25),
        (act("glance", side="right", angle_deg=50.0), "neck_yaw", -50),
        (act("tilt_head", side="left", angle_deg=20.0), "roll", -20),
        (turn(40, Direction.RIGHT), "body_yaw", -40),
    ):
        result = robot.step(step, go_on)
        assert result.outcome is Outcome.DONE, result.message
        assert math.degrees(getattr(daemon.state().pose, axis)) == pytest.approx(degrees, abs=2)
    daemon.close()


def test_law_17_nothing_moves_after_a_stop(robot: ReachyMini, url: str) -> None:
    turning, results = threading.Event(), list[ActionResult]()

    def notice(state: RobotState) -> str | None:
        if state.yaw_rate_rps is not None and state.yaw_rate_rps > 0.3:
            turning.set()
        return None

    step = threading.Thread(target=lambda: results.append(robot.step(turn(120), notice)))
    step.start()
    assert turning.wait(LIMIT_S)
    stopped = robot.stop()
    daemon = Daemon(url)
    held = daemon.state().pose
    step.join(LIMIT_S)
    assert stopped.confirmed, stopped.message
    assert results[0].reason == "stop"
    assert daemon.running() == frozenset()
    assert math.degrees(abs(daemon.state().pose.body_yaw - held.body_yaw)) < 0.5
    daemon.close()


def test_a_recorded_move_of_its_library_is_played_and_stopped(url: str, robot: ReachyMini) -> None:
    moves = {"cheer": {**CHEER, "move": "cheer_1"}, "lost": {**CHEER, "move": "nosuch", "words": {"en": "gloat"}}}
    player = ReachyMini(RobotConfig(model="reachy-mini", simulated=True, options={"url": url, "moves": moves}))
    try:
        ready(player)
        played = player.step(act("play_cheer"), go_on)
        assert played.outcome is Outcome.DONE, played.message
        assert 15 < played.measured["head_deg"] < 25
        missing = player.step(act("play_lost"), go_on)
        assert (missing.outcome, missing.reason) == (Outcome.FAILED, "rejected")
        assert "Move nosuch not found" in missing.message
    finally:
        player.close()


def test_wrong_units_are_what_the_daemon_accepts_and_this_refuses(url: str, robot: ReachyMini) -> None:
    """The daemon answers 200 to a pitch of 30 rad and goes somewhere else: the bounds must be ours."""
    daemon = Daemon(url)
    with pytest.raises(ValueError, match="pitch of its head would be"):
        daemon.goto(BodyPose(pitch=30.0), 1.0)
    assert daemon.running() == frozenset()
    daemon.close()
    accepted = httpx2.post(f"{url}/api/move/goto", json={"head_pose": {"pitch": 2.0}, "duration": 0.3}, trust_env=False)
    assert accepted.status_code == 200


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL], ids=["frozen", "killed"])
def test_law_8_a_daemon_that_is_killed_or_frozen_ends_the_step(
    start: Start, tmp_path: Path, number: signal.Signals
) -> None:
    url, process = start()
    settings = RobotConfig(model="reachy-mini", simulated=True, home_on_start=True, options={"url": url})
    guard = Guard(ReachyMini(settings), settings, Halt(tmp_path / "halt"))
    result = disturbed(guard, turn(120), lambda: os.killpg(process.pid, number))
    assert result.reason in ("stale_state", "no_answer")
    assert not result.ok
    refused = guard.step(turn(10), go_on)
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "stale_state")
    assert "does not answer" in refused.message
    guard.close()
    os.killpg(process.pid, signal.SIGKILL)


def test_it_reaches_no_network(start: Start) -> None:
    """Its mDNS announcements, usage figures and downloads end in its own namespace."""
    _, process = start()
    inside = os.readlink(f"/proc/{process.pid}/ns/net")
    assert inside != os.readlink("/proc/self/ns/net")
