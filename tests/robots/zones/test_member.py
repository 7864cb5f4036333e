"""A driver's part in a shared room: when it gives a lease back, and when its robot must stop."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from agentrob.errors import RobotUnreachable
from agentrob.model import Direction, Op, Pose, Primitive
from agentrob.robots.zones.area import Area
from agentrob.robots.zones.ledger import Answer, Ledger, Message, Other, Place
from agentrob.robots.zones.member import KEEP_S, LOST_S, RoomMember

AHEAD = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)
TURN = Primitive(Op.TURN, Direction.LEFT, degrees=90)
START = Pose(0, 0, 0)


class Link:
    """A keeper in memory whose answers, or requests, can be lost."""

    def __init__(self, ledger: Ledger, clock: Callable[[], float]) -> None:
        self.ledger, self.clock = ledger, clock
        self.down = self.deaf = False

    def _through(self) -> None:
        if self.down:
            raise RobotUnreachable("the room's file cannot be used")

    def _back(self) -> None:
        if self.deaf:
            raise RobotUnreachable("no answer")

    def hello(self, robot: str) -> int:
        self._through()
        return self.ledger.hello(robot, self.clock())

    def take(self, message: Message, place: Place, area: Area, doing: str) -> Answer:
        self._through()
        answer = self.ledger.take(message, place, area, doing, self.clock())
        self._back()
        return answer

    def report(self, message: Message, lease: int, place: Place, *, at_rest: bool) -> list[Other]:
        self._through()
        others = self.ledger.report(message, lease, place, at_rest=at_rest, now_s=self.clock())
        self._back()
        return others


class Room:
    """Members of one room in simulated time."""

    def __init__(self, **poses: Pose) -> None:
        self.now_s, self.ledger = 50.0, Ledger()
        self.poses, self.shaking = dict(poses), set[str]()
        self.links = {name: Link(self.ledger, lambda: self.now_s) for name in poses}
        self.members = {name: self.make(name) for name in poses}
        self.run(1.0)

    def make(self, name: str, error_m: float | None = 0.1) -> RoomMember:
        return RoomMember(name, "lab", self.links[name], error_m=error_m, clock=lambda: self.now_s)  # type: ignore[arg-type]

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 20)):
            self.now_s += 0.05
            for name, member in self.members.items():
                pose = self.poses[name]
                odometry = Pose(pose.x_m + math.sin(9 * self.now_s), 0, 0) if name in self.shaking else pose
                member.observe(odometry, 0.0, pose)
                member.exchange()

    def holds(self, name: str) -> bool:
        return self.ledger.members[name].lease is not None


def test_a_lease_is_given_back_a_moment_after_the_step_and_only_at_rest() -> None:
    room = Room(ann=START)
    ann = room.members["ann"]
    assert ann.admit([AHEAD]) is None
    ann.begin()
    room.shaking.add("ann")
    room.run(KEEP_S + 2)
    assert room.holds("ann")
    assert ann.violation(AHEAD, 0.0) is None
    ann.end()
    room.run(KEEP_S + 5)
    assert room.holds("ann"), "the step has ended, and it moves on"
    room.shaking.clear()
    room.run(1)
    assert not room.holds("ann")


def test_the_steps_of_a_command_share_one_lease() -> None:
    room = Room(ann=START, bob=Pose(0, 3, 0))
    ann = room.members["ann"]
    assert ann.admit([AHEAD, TURN]) is None
    number = room.ledger.counter
    ann.begin()
    ann.end()
    room.poses["ann"] = Pose(1, 0, 0)
    room.run(1)
    assert ann.admit([TURN]) is None
    assert room.ledger.counter == number, "the lease covers it"
    room.run(KEEP_S + 1)
    assert not room.holds("ann")
    assert room.members["bob"].admit([Primitive(Op.MOVE, Direction.RIGHT, distance_m=1.5)]) is None


def test_the_noise_of_the_odometry_costs_no_lease_that_another_robot_waits_for() -> None:
    room = Room(ann=START, bob=Pose(2, -2, math.pi / 2))
    ann, bob = room.members["ann"], room.members["bob"]
    assert ann.admit([AHEAD, AHEAD]) is None
    across = Primitive(Op.MOVE, Direction.FORWARD, distance_m=4.0)
    assert bob.admit([across]) is not None
    room.poses["ann"] = Pose(0.01, -0.01, 0.003)
    room.run(0.3)
    assert ann.admit([AHEAD]) is None, "the first step, asked for again by the guard"
    room.poses["ann"] = Pose(1.03, 0.02, 0.01)
    room.run(0.3)
    assert ann.admit([AHEAD]) is None, "the second one, from where the first one really ended"


def test_no_step_begins_or_goes_on_while_the_keeper_does_not_answer() -> None:
    room = Room(ann=START)
    ann, link = room.members["ann"], room.links["ann"]
    link.down = True
    hindrance = ann.admit([AHEAD])
    assert hindrance is not None
    assert hindrance.reason == "room_unreachable"
    assert "the room's file cannot be used" in hindrance.sentence
    link.down = False
    assert ann.admit([AHEAD]) is None
    ann.begin()
    room.run(1)
    link.down = True
    room.run(LOST_S - 0.5)
    assert ann.violation(AHEAD, 0.0) is None
    room.run(1)
    lost = ann.violation(AHEAD, 0.0)
    assert lost is not None
    assert lost.reason == "room_lost"


@pytest.mark.parametrize("lost", ["report", "take"])
def test_a_lost_answer_never_leaves_a_robot_with_a_right_that_it_does_not_have(lost: str) -> None:
    room = Room(ann=START, bob=Pose(2, -2, math.pi / 2))
    ann = room.members["ann"]
    if lost == "report":  # of rest: the ledger has taken the lease back
        assert ann.admit([AHEAD]) is None
        room.run(KEEP_S)
        room.links["ann"].deaf = True
        room.run(0.5)
        assert not room.holds("ann")
    else:
        room.links["ann"].deaf = True
        assert ann.admit([AHEAD]) is not None
    room.links["ann"].deaf = False
    ann.begin()
    violation = ann.violation(AHEAD, 0.0)
    assert violation is not None
    assert violation.reason == "room_lost"


def test_the_owners_release_stops_a_robot_whose_driver_comes_back() -> None:
    room = Room(ann=START)
    ann = room.members["ann"]
    assert ann.admit([AHEAD]) is None
    ann.begin()
    room.now_s += 3600
    assert ann.violation(AHEAD, 0.0) is not None, "its driver hung, and stops before its next command"
    room.ledger.release("ann", room.now_s)
    room.run(0.2)
    lost = ann.violation(AHEAD, 0.0)
    assert lost is not None
    assert "its owner released it" in lost.sentence


def test_a_second_driver_of_the_same_name_ends_the_first_ones_right() -> None:
    room = Room(ann=START)
    ann = room.members["ann"]
    assert ann.admit([AHEAD]) is None
    ann.begin()
    second = room.make("ann")
    second.observe(START, 0.0, START)
    second.exchange()
    room.run(0.2)
    lost = ann.violation(AHEAD, 0.0)
    assert lost is not None
    assert lost.reason == "room_lost"


def test_another_robot_is_an_obstacle_ahead_but_not_behind() -> None:
    room = Room(ann=START, bob=Pose(0, 3, 0))
    ann = room.members["ann"]
    assert ann.admit([AHEAD]) is None
    ann.begin()
    room.poses["bob"] = Pose(1.0, 0, 0)  # carried there
    room.run(1)
    near = ann.violation(AHEAD, 0.2)
    assert near is not None
    assert (near.reason, near.robot) == ("robot_near", "bob")
    assert ann.violation(Primitive(Op.MOVE, Direction.BACKWARD, distance_m=1.0), 0.2) is None


def test_a_robot_without_a_known_place_takes_the_whole_room() -> None:
    room = Room(ann=START, bob=Pose(0, 3, 0))
    ann, bob = room.members["ann"], room.members["bob"]
    ann.lose_frame("its odometry jumped")
    room.run(1)
    assert ann.admit([AHEAD]) is None
    waits = bob.admit([AHEAD])
    assert waits is not None
    assert (waits.reason, waits.robot, waits.doing) == ("room_busy", "ann", "move")
    room.run(KEEP_S + 1)
    ann.regain_frame()
    room.run(1)
    assert bob.admit([AHEAD]) is None
    assert ann.admit([AHEAD]) is None


def test_who_is_silent_is_said_and_how_its_owner_can_help() -> None:
    room = Room(ann=START, bob=Pose(0, 1.8, -math.pi / 2))
    assert room.members["ann"].admit([AHEAD]) is None
    silent = room.members.pop("ann")
    assert silent is not None
    room.run(40)
    waits = room.members["bob"].admit([AHEAD])
    assert waits is not None
    assert waits.silent_s >= 39
    assert "agentrob room lab --release ann" in waits.sentence


def test_a_photo_needs_no_room() -> None:
    room = Room(ann=START)
    room.links["ann"].down = True
    assert room.members["ann"].admit([Primitive(Op.GET_FRONT_IMAGE)]) is None


def test_an_orderly_end_gives_back_what_a_robot_at_rest_holds_and_nothing_else() -> None:
    room = Room(ann=START)
    ann = room.members["ann"]
    assert ann.admit([AHEAD]) is None
    room.shaking.add("ann")
    room.run(0.5)
    ann.close()
    assert room.holds("ann")
    room.shaking.clear()
    room.run(0.5)
    ann.close()
    assert not room.holds("ann")


def test_a_driver_that_hung_in_a_step_measures_rest_anew_before_the_next_one() -> None:
    room = Room(ann=START)
    ann = room.members["ann"]
    assert ann.admit([AHEAD]) is None
    number = room.ledger.counter
    ann.begin()
    room.now_s += LOST_S + 1  # it sees nothing, and its robot walks
    assert ann.violation(AHEAD, 0.0) is not None
    ann.end()
    assert not ann.at_rest, "what it saw before the step is no evidence"
    hindrance = ann.admit([TURN])
    assert hindrance is not None
    assert hindrance.reason == "room_restless"
    assert room.ledger.counter == number
    room.run(1)
    assert ann.at_rest
    assert ann.admit([TURN]) is None


def test_after_a_step_that_the_room_ended_a_moving_robot_begins_no_other_one() -> None:
    room = Room(ann=START)
    ann, link = room.members["ann"], room.links["ann"]
    assert ann.admit([AHEAD]) is None
    ann.begin()
    room.shaking.add("ann")
    link.down = True
    room.run(LOST_S + 1)
    assert ann.violation(AHEAD, 0.0) is not None
    ann.end()
    link.down = False
    room.run(0.5)
    assert room.holds("ann")
    hindrance = ann.admit([AHEAD])
    assert hindrance is not None
    assert hindrance.reason == "room_restless"
    room.shaking.clear()
    room.run(1)
    assert ann.admit([AHEAD]) is None
