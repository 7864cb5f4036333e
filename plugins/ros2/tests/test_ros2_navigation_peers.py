"""Going to a place by a real rclpy action server, over Fast DDS: sent, followed, cancelled by a stop, given up.

PyPI has no nav2_msgs, so the peer's action is `test_msgs/action/Fibonacci` under Nav2's name: the services, the status
and the cancelling are those of every ROS 2 action. Only the goal's type differs.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from agentrob_ros2 import messages
from agentrob_ros2.base import Ros2Base
from agentrob_ros2.messages import Uuid
from agentrob_ros2.navigation import GO, Navigation
from agentrob_ros2.network import Node, qos_of
from agentrob_ros2.options import CommandOptions, PlaceOptions, Ros2Options
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import int32
from ros2_peer import Peer

from agentrob.model import ActionResult, Outcome, Primitive
from agentrob.robots.contract import go_on
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt

pytestmark = [pytest.mark.slow, pytest.mark.sim]
LIMIT_S = 60.0
#: How a step ends when nothing came for too long.
BUSY = ("stale_state", "ranges_unknown")
PLACES = {"kitchen": {"x_m": 1.5, "y_m": 0.0, "words": {"zh": "厨房"}}, "hall": {"x_m": -1.5, "y_m": 1.0}}
KITCHEN = Primitive(GO, arguments=(("place", "kitchen"),))


@dataclass
@final
class FibonacciGoal(IdlStruct, typename="test_msgs::action::dds_::Fibonacci_Goal_"):
    order: int32 = 0


@dataclass
@final
class FibonacciRequest(IdlStruct, typename="test_msgs::action::dds_::Fibonacci_SendGoal_Request_"):
    goal_id: Uuid = field(default_factory=Uuid)
    goal: FibonacciGoal = field(default_factory=FibonacciGoal)


class NumberedPlaces(Navigation):
    kind = FibonacciRequest

    def request(self, goal: messages.Uuid, place: PlaceOptions, facing_deg: float, now_s: float) -> Any:
        return FibonacciRequest(goal, FibonacciGoal(0 if place.x_m > 0 else 1))


class Base(Ros2Base):
    navigation_class = NumberedPlaces


def until(condition: Callable[[], Any], what: str) -> None:
    end_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < end_s, f"not within {LIMIT_S:.0f} s: {what}"
        time.sleep(0.01)


@pytest.fixture
def peer() -> Iterator[Peer]:
    running = Peer("--navigator")
    running.ask(clear=True)
    yield running
    running.close()


@pytest.fixture
def localised(peer: Peer) -> Iterator[None]:
    """Tell where the odometry frame is on the map, as AMCL does."""
    node, ended = Node(peer.domain.number, "lo"), threading.Event()
    writer = node.writer("/tf", messages.TFMessage, qos_of(CommandOptions()))
    one = messages.TransformStamped(messages.Header(messages.Time(1), "map"), "odom", messages.Transform())

    def tell() -> None:
        while not ended.wait(0.1):
            writer.write(messages.TFMessage([one]))

    telling = threading.Thread(target=tell)
    telling.start()
    yield
    ended.set()
    telling.join(LIMIT_S)
    node.close()


@pytest.fixture
def robot(peer: Peer) -> Iterator[Base]:
    base = Base(peer.settings(places=PLACES))
    until(lambda: base.state().age_s < 0.2 and None not in base.state().ranges_m, "state and ranges")
    until(lambda: base._navigation is not None and not base._navigation.absence(), "the action server")
    yield base
    base.close()


@pytest.fixture
def guard(robot: Base, peer: Peer, localised: None, tmp_path: Path) -> Iterator[Guard]:
    guarded = Guard(robot, peer.settings(places=PLACES), Halt(tmp_path / "halt"))
    until(lambda: guarded.state().homed, "home")
    state = robot.state()
    until(lambda: state.pose and robot._sensors.on_map(state.pose), "it is localised")
    yield guarded
    guarded.close()


def done(guard: Guard, step: Primitive) -> ActionResult:
    """Do a step; again if nothing came for half a second, as on a busy machine."""
    while (result := guard.step(step, go_on)).reason in BUSY:
        pass
    return result


def under_way(guard: Guard, peer: Peer, act: Callable[[], Any]) -> ActionResult:
    """Go to the kitchen; `act` is called when the base has gone 0.3 m."""
    results: list[ActionResult] = []
    while True:
        results.clear()
        peer.ask(pose=[0.0, 0.0, 0.0])
        running = threading.Thread(target=lambda: results.append(guard.step(KITCHEN, go_on)))
        running.start()
        until(lambda: results or peer.ask()["x_m"] > 0.3, "motion")
        if not results or results[0].reason not in BUSY:
            break
    act()
    running.join(LIMIT_S)
    return results[0]


def test_it_goes_to_a_place_and_measures_how_far_from_it_it_ended(guard: Guard, peer: Peer) -> None:
    result = done(guard, KITCHEN)
    truth = peer.ask()
    assert result.outcome is Outcome.DONE, result.message
    assert result.measured["missed_m"] < 0.2
    assert result.measured["driven_m"] < 1.6
    assert abs(result.measured["missed_m"] - math.hypot(truth["x_m"] - 1.5, truth["y_m"])) < 0.05
    again = done(guard, Primitive(GO, arguments=(("place", "hall"),)))
    assert again.outcome is Outcome.DONE, again.message


def test_law_14_a_stop_cancels_the_goal_and_the_last_command_is_zero(guard: Guard, peer: Peer) -> None:
    stopped: list[Any] = []
    result = under_way(guard, peer, lambda: stopped.append(guard.stop()))
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stop")
    assert stopped[0].confirmed, stopped[0].message
    assert stopped[0].was_moving
    at_rest_m = peer.ask()["x_m"]
    assert at_rest_m < 0.8
    commands = peer.ask(commands=True)["commands"]
    assert commands[-1][1:] == [0.0, 0.0]
    assert done(guard, KITCHEN).outcome is Outcome.DONE  # nothing is left of the first goal


def test_law_17_a_stop_whose_goal_is_not_cancelled_is_not_confirmed(guard: Guard, peer: Peer) -> None:
    stopped: list[Any] = []
    peer.ask(navigator="deaf")

    def stop() -> None:
        stopped.append(guard.stop())
        peer.ask(navigator="abort")

    under_way(guard, peer, stop)
    assert not stopped[0].confirmed
    assert "did not confirm" in stopped[0].message


def test_law_8_the_guard_and_the_speed_limit_end_it(guard: Guard, peer: Peer) -> None:
    blocked = under_way(guard, peer, lambda: peer.ask(box=[1.3, 0.0, 0.3, 0.3]))
    assert (blocked.outcome, blocked.reason) == (Outcome.STOPPED, "obstacle"), blocked.message
    assert not peer.ask(clear=True)["bumped"]
    until(lambda: (guard.state().ranges_m[0] or 0.0) > 2.0, "a scan without the box")
    lost = guard.step(KITCHEN, lambda state: "stale_state" if state.pose and state.pose.x_m > 0.9 else None)
    assert (lost.outcome, lost.reason) == (Outcome.STOPPED, "stale_state")


def test_law_10_a_navigation_that_drives_faster_than_the_limit_is_stopped(guard: Guard, peer: Peer) -> None:
    peer.ask(navigator="fast")
    result = done(guard, KITCHEN)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "limit_speed_mps")


@pytest.mark.parametrize(
    ("mode", "outcome", "reason"),
    [
        ("reject", Outcome.FAILED, "rejected"),
        ("abort", Outcome.FAILED, "navigation_failed"),
        ("lie", Outcome.INACCURATE, "inaccurate"),
    ],
)
def test_law_18_what_navigation_claims_is_held_against_where_it_ended(
    guard: Guard, peer: Peer, mode: str, outcome: Outcome, reason: str
) -> None:
    peer.ask(navigator=mode)
    result = done(guard, KITCHEN)
    assert (result.outcome, result.reason) == (outcome, reason), result.message
    assert "Asked to go to kitchen, it is 1.50 m from there" in result.message


def test_a_base_that_does_not_know_where_it_is_does_not_go(robot: Base, peer: Peer) -> None:
    result = robot.step(KITCHEN, go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "not_localised")
    assert "/tf has no transform from map to odom" in result.message


def test_a_pose_on_the_map_is_read_by_ros_as_it_was_written(peer: Peer) -> None:
    place = PlaceOptions(x_m=4.0, y_m=-2.0, facing_deg=90)
    node = Node(peer.domain.number, "lo")
    writer = node.writer("/pose_check", messages.PoseStamped, qos_of(CommandOptions()))
    until(writer.get_matched_subscriptions, "a subscriber")
    navigation = Navigation(node, Ros2Options(places={"somewhere": place}))
    writer.write(navigation.request(Uuid(), place, 90.0, 12.5).goal.pose)
    until(lambda: peer.ask(poses=True)["poses"], "the pose")
    frame, x, y, z, w = peer.ask(poses=True)["poses"][0]
    assert (frame, x, y) == ("map", 4.0, -2.0)
    assert (z, w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    node.close()


def test_places_are_declared_with_their_words(peer: Peer) -> None:
    capabilities = Ros2Base.describe(peer.settings(places=PLACES))
    operation = capabilities.operation(GO)
    assert operation is not None
    (argument,) = operation.arguments
    assert argument.range == "kitchen, hall"
    assert operation.moves
