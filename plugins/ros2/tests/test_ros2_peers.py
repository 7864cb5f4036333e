"""Against real ROS 2: an rclpy node over Fast DDS (peer_base.py), in a process with packages of its own."""

from __future__ import annotations

import io
import itertools
import math
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from agentrob_ros2.base import Ros2Base
from PIL import Image
from ros2_peer import Peer

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Direction, Op, Outcome, Primitive, RobotState
from agentrob.robots.contract import RobotContract, go_on
from agentrob.robots.protocol import Robot
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt

pytestmark = [pytest.mark.slow, pytest.mark.sim]
LIMIT_S = 60.0
#: How a step ends when nothing came for too long.
BUSY = ("stale_state", "ranges_unknown")
FORWARD = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.5)


@pytest.fixture
def start() -> Iterator[Callable[..., Peer]]:
    running: list[Peer] = []

    def begin(*arguments: str) -> Peer:
        running.append(Peer(*arguments))
        return running[-1]

    yield begin
    for peer in running:
        peer.close()


@pytest.fixture
def drive() -> Iterator[Callable[[RobotConfig], Ros2Base]]:
    made: list[Ros2Base] = []

    def begin(settings: RobotConfig) -> Ros2Base:
        made.append(Ros2Base(settings))
        return made[-1]

    yield begin
    for robot in made:
        robot.close()


def until(condition: Callable[[], Any], what: str) -> None:
    end_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < end_s, f"not within {LIMIT_S:.0f} s: {what}"
        time.sleep(0.01)


def ready(robot: Ros2Base | Guard) -> None:
    until(lambda: robot.state().age_s < 0.2 and None not in robot.state().ranges_m, "state and ranges")


class TestContract(RobotContract):
    """The contract of every robot, against rclpy; commands stamped, best-effort sensors."""

    @pytest.fixture(scope="class")
    @classmethod
    def peer(cls) -> Iterator[Peer]:
        running = Peer("--stamped", "--odom-qos", "best_effort", "--scan-qos", "best_effort")
        running.ask(clear=True)
        yield running
        running.close()

    @pytest.fixture
    def robot(self, peer: Peer) -> Iterator[Robot]:
        peer.ask(pose=[0.0, 0.0, 0.0])
        base = Ros2Base(peer.settings(cmd_vel={"stamped": True}))
        ready(base)
        until(lambda: not base.silence(), "all topics")
        yield base
        base.close()


def test_a_picture_is_a_jpeg_raw_or_compressed(start: Callable[..., Peer], drive: Callable[..., Ros2Base]) -> None:
    peer = start("--image")
    raw = drive(peer.settings(image={"topic": "image_raw"})).step(Primitive(Op.GET_FRONT_IMAGE), go_on)
    assert raw.image is not None, raw.message
    with Image.open(io.BytesIO(raw.image)) as picture:
        assert (picture.format, picture.size) == ("JPEG", (64, 48))
        red, _, blue = picture.getpixel((60, 20))
    assert (red > 200, blue < 60) == (True, True)
    robot = drive(peer.settings(image={"topic": "image_raw/compressed", "compressed": True}))
    result = robot.step(Primitive(Op.GET_FRONT_IMAGE), go_on)
    assert result.image is not None
    assert result.image.startswith(b"\xff\xd8\xff\xe0")


def test_a_namespace_and_the_time_of_a_simulation_at_half_speed(
    start: Callable[..., Peer], drive: Callable[..., Ros2Base]
) -> None:
    peer = start("--namespace", "tb4", "--clock", "--speed", "0.5")
    robot = drive(peer.settings(namespace="tb4", use_sim_time=True))
    ready(robot)
    began_s, sim_s = time.monotonic(), peer.ask()["now_s"]
    result = robot.step(Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.8), go_on)
    truth = peer.ask()
    assert result.outcome is Outcome.DONE, result.message
    assert abs(truth["x_m"] - 0.8) < 0.05
    assert truth["now_s"] - sim_s < 0.75 * (time.monotonic() - began_s)


@pytest.mark.parametrize(
    ("arguments", "options", "words"),
    [
        (
            ["--odom-qos", "best_effort"],
            {"pose": {"reliability": "reliable"}},
            "The QoS of /odom does not match: it is",
        ),
        (
            ["--scan-qos", "best_effort"],
            {"scan": {"reliability": "reliable"}},
            "The QoS of /scan does not match: it is",
        ),
    ],
)
def test_a_qos_that_does_not_match_is_told(
    start: Callable[..., Peer],
    drive: Callable[..., Ros2Base],
    arguments: list[str],
    options: dict[str, Any],
    words: str,
) -> None:
    peer = start(*arguments)
    options.setdefault("scan", {}).setdefault("mount_m", [0.0, 0.0])
    robot = drive(peer.settings(**options))
    until(lambda: words in robot.silence(), words)
    assert "offered as best_effort and wanted as reliable; set reliability" in robot.silence()


def test_a_command_type_or_qos_that_does_not_match_is_told(
    start: Callable[..., Peer], drive: Callable[..., Ros2Base]
) -> None:
    peer = start()
    unheard = drive(peer.settings(cmd_vel={"reliability": "best_effort"}))
    until(lambda: "QoS of /cmd_vel" in unheard.step(FORWARD, go_on).message, "the QoS is told")
    assert "offered as best_effort and wanted as reliable" in unheard.step(FORWARD, go_on).message
    other = drive(peer.settings(cmd_vel={"stamped": True}))
    until(lambda: "subscribed as" in other.step(FORWARD, go_on).message, "the type is told")
    assert "/cmd_vel is subscribed as geometry_msgs/msg/Twist" in other.step(FORWARD, go_on).message
    assert peer.ask()["x_m"] == 0.0


def test_law_8_obstacle_lost_topic_and_a_dead_base_stop_it(
    start: Callable[..., Peer], drive: Callable[..., Ros2Base], tmp_path: Path
) -> None:
    for number, (fault, reason) in enumerate(
        [
            ({"box": [1.45, 0.1, 0.3, 0.3]}, "obstacle"),
            ({"muted": ["scan"]}, "ranges_unknown"),
            ({"muted": ["odom"]}, "stale_state"),
            ({}, "stale_state"),  # its process is killed
        ]
    ):
        peer = start()
        robot = drive(peer.settings())
        guard = Guard(robot, peer.settings(), Halt(tmp_path / f"halt{number}"))
        until(lambda: guard.state().homed, "home")  # noqa: B023
        ready(guard)
        result = disturbed(guard, peer, fault)
        assert (result.outcome, result.reason) == (Outcome.STOPPED, reason), result.message
        if fault:
            truth = peer.ask()
            assert truth["x_m"] < 1.2
            assert not truth["bumped"]
        guard.close()


def disturbed(guard: Guard, peer: Peer, fault: dict[str, Any]) -> ActionResult:
    """Run a step; the fault begins when the base has gone 0.3 m. On a busy machine nothing may come for half a second,
    which ends a step as it should: then it begins again."""
    results: list[ActionResult] = []
    while True:
        results.clear()
        peer.ask(pose=[0.0, 0.0, 0.0])
        running = threading.Thread(target=lambda: results.append(guard.step(FORWARD, go_on)))
        running.start()
        until(lambda: results or peer.ask()["x_m"] > 0.3, "motion")
        if not results or results[0].reason not in BUSY:
            break
    if fault:
        peer.ask(**fault)
    else:
        peer.kill()
    running.join(LIMIT_S)
    return results[0]


def test_law_14_after_a_stop_ros_hears_zero_and_nothing_else(
    start: Callable[..., Peer], drive: Callable[..., Ros2Base]
) -> None:
    peer = start()
    robot = drive(peer.settings())
    ready(robot)
    moving = threading.Event()

    def notice(state: RobotState) -> str | None:
        if state.velocity_mps and state.velocity_mps[0] > 0.2:
            moving.set()
        return None

    running = threading.Thread(target=lambda: robot.step(FORWARD, notice))
    running.start()
    assert moving.wait(LIMIT_S)
    asked_s = time.monotonic()
    stopped = robot.stop()
    running.join(LIMIT_S)
    heard = [command for command in peer.ask(commands=True)["commands"] if command[0] > asked_s]
    assert stopped.confirmed, stopped.message
    after = list(itertools.dropwhile(lambda command: command[1:] != [0.0, 0.0], heard))
    assert after
    assert all(command[1:] == [0.0, 0.0] for command in after)


def test_it_ends_where_it_says_by_the_truth_of_its_world(
    start: Callable[..., Peer], drive: Callable[..., Ros2Base]
) -> None:
    peer = start()
    peer.ask(clear=True)
    robot = drive(peer.settings())
    ready(robot)
    for step in (
        Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),
        Primitive(Op.TURN, Direction.LEFT, degrees=90),
        Primitive(Op.MOVE, Direction.BACKWARD, distance_m=0.5),
        Primitive(Op.TURN, Direction.RIGHT, degrees=180),
    ):
        result = robot.step(step, go_on)
        assert result.outcome is Outcome.DONE, result.message
    truth = peer.ask()
    assert math.hypot(truth["x_m"] - 1.0, truth["y_m"] + 0.5) < 0.08
    assert abs(math.degrees(truth["yaw_rad"]) + 90) < 6
