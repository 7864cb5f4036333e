"""Who gets which zone: order, standing robots, silence, old messages and the owner's release."""

from __future__ import annotations

import math

import pytest

from agentrob.model import Direction, Op, Pose, Primitive
from agentrob.robots.zones.area import swept
from agentrob.robots.zones.ledger import (
    RELEASE_S,
    WAITER_S,
    Answer,
    LeaseGone,
    Ledger,
    Message,
    OldSession,
    Place,
    StillHeard,
)

ERROR_M = 0.1


class Robots:
    """A ledger, and drivers that number their messages."""

    def __init__(self, **poses: Pose | None) -> None:
        self.ledger, self.now_s = Ledger(), 10.0
        self.sessions: dict[str, int] = {}
        self.numbers = dict.fromkeys(poses, 0)
        self.poses = poses
        for name in poses:
            self.sessions[name] = self.ledger.hello(name, self.now_s)
            self.rests(name)

    def message(self, name: str) -> Message:
        self.numbers[name] += 1
        return Message(name, self.sessions[name], self.numbers[name])

    def place(self, name: str) -> Place:
        pose = self.poses[name]
        return Place() if pose is None else Place(pose, ERROR_M)

    def rests(self, name: str) -> None:
        self.ledger.report(self.message(name), 0, self.place(name), at_rest=True, now_s=self.now_s)

    def moves(self, name: str, lease: int) -> None:
        self.ledger.report(self.message(name), lease, self.place(name), at_rest=False, now_s=self.now_s)

    def walk(self, name: str, distance_m: float = 1.0, direction: Direction = Direction.FORWARD) -> Answer:
        return self.ask(name, Primitive(Op.MOVE, direction, distance_m=distance_m))

    def ask(self, name: str, step: Primitive) -> Answer:
        pose = self.poses[name]
        area = None if pose is None else swept(pose, [step], ERROR_M)
        return self.ledger.take(self.message(name), self.place(name), area, str(step.op), self.now_s)


def test_one_mover_a_room_without_a_common_frame_and_the_next_when_it_rests() -> None:
    robots = Robots(ann=None, bob=None)
    first = robots.walk("ann")
    assert first.number > 0
    assert robots.walk("bob") == Answer(reason="room_busy", robot="ann", doing="move")
    robots.moves("ann", first.number)
    assert robots.walk("bob").reason == "room_busy", "a lease is given back only at rest"
    robots.rests("ann")
    assert robots.walk("bob").number > first.number


def test_disjoint_paths_run_together_and_crossing_ones_one_after_the_other() -> None:
    robots = Robots(ann=Pose(0, 0, 0), bob=Pose(0, 2.5, 0), cid=Pose(2, -2, math.pi / 2))
    assert robots.walk("ann", 3).number
    assert robots.walk("bob", 3).number
    assert robots.walk("cid", 4) == Answer(reason="room_busy", robot="ann", doing="move")


def test_those_that_wait_are_served_in_order_as_far_as_they_conflict() -> None:
    robots = Robots(ann=None, bob=None, cid=None)
    robots.walk("ann")
    assert robots.walk("bob").robot == "ann"
    assert robots.walk("cid").robot == "ann"
    robots.rests("ann")
    answer = robots.walk("cid")
    assert (answer.reason, answer.robot, answer.doing) == ("room_busy", "bob", "wait")
    assert robots.walk("bob").number
    robots.rests("bob")
    assert robots.walk("cid").number


def test_who_no_longer_asks_holds_nobody_up() -> None:
    robots = Robots(ann=None, bob=None, cid=None)
    robots.walk("ann")
    robots.walk("bob")
    robots.rests("ann")
    robots.now_s += WAITER_S + 0.1
    assert robots.walk("cid").number


def test_a_standing_robot_in_the_way_is_named_and_not_waited_for() -> None:
    robots = Robots(ann=Pose(0, 0, 0), bob=Pose(2, 0, 0))
    assert robots.walk("ann", 2) == Answer(reason="room_blocked", robot="bob")
    assert robots.ledger.waiting(robots.now_s) == []
    assert robots.walk("ann", 0.5).number


def test_a_robot_that_waits_will_move_on_so_it_is_waited_for() -> None:
    robots = Robots(ann=Pose(0, 0, 0), bob=Pose(2, 0, math.pi / 2), cid=Pose(2, 3, 0))
    assert robots.walk("cid", 2, Direction.RIGHT).reason == "room_blocked"
    robots.walk("cid", 0.3, Direction.RIGHT)
    assert robots.walk("bob", 2).robot == "cid"
    assert robots.walk("ann", 2) == Answer(reason="room_busy", robot="bob", doing="wait")


def test_two_robots_that_want_each_others_place_are_both_told_so() -> None:
    robots = Robots(ann=Pose(0, 0, 0), bob=Pose(2, 0, math.pi))
    assert robots.walk("ann", 2).reason == robots.walk("bob", 2).reason == "room_blocked"


def test_a_robot_that_stands_too_near_may_leave_and_turn_but_come_no_nearer() -> None:
    robots = Robots(ann=Pose(0, 0, 0), bob=Pose(1.0, 0, 0))
    assert robots.walk("ann", 0.2).reason == "room_blocked"
    assert robots.ask("ann", Primitive(Op.HELLO)).reason == "room_blocked"
    assert robots.walk("ann", 1, Direction.BACKWARD).number
    robots.rests("ann")
    assert robots.ask("ann", Primitive(Op.TURN, Direction.LEFT, degrees=180)).number


def test_a_silent_holder_keeps_its_zone_until_its_driver_says_at_rest() -> None:
    robots = Robots(ann=None, bob=None)
    robots.walk("ann")
    robots.now_s += 3600
    answer = robots.walk("bob")
    assert (answer.reason, answer.robot, answer.silent_s) == ("room_busy", "ann", 3600)
    robots.sessions["ann"] = robots.ledger.hello("ann", robots.now_s)
    robots.numbers["ann"] = 0
    assert robots.walk("bob").reason == "room_busy", "a driver that has just started has measured nothing yet"
    robots.rests("ann")
    assert robots.walk("bob").number


def test_or_until_its_owner_releases_it_which_ends_its_right_to_move() -> None:
    robots = Robots(ann=None, bob=None)
    lease = robots.walk("ann").number
    robots.now_s += RELEASE_S - 0.1
    with pytest.raises(StillHeard):
        robots.ledger.release("ann", robots.now_s)
    robots.now_s += 0.2
    released = robots.ledger.release("ann", robots.now_s)
    assert released is not None
    assert released.number == lease
    with pytest.raises(LeaseGone):
        robots.moves("ann", lease)
    assert robots.walk("bob").number
    assert robots.ledger.release("nobody", robots.now_s) is None


def test_old_doubled_and_overtaken_messages_have_no_effect() -> None:
    robots = Robots(ann=None, bob=None)
    late_rest = robots.message("ann")
    asked = robots.message("ann")
    lease = robots.ledger.take(asked, Place(), None, "move", robots.now_s).number
    for stale in (late_rest, asked):
        with pytest.raises(OldSession):
            robots.ledger.report(stale, 0, Place(), at_rest=True, now_s=robots.now_s)
    assert robots.walk("bob").reason == "room_busy"
    of_the_last_driver = Message("ann", robots.sessions["ann"], 99)
    robots.sessions["ann"] = robots.ledger.hello("ann", robots.now_s)
    for late in (of_the_last_driver, Message("stranger", 1, 1)):
        with pytest.raises(OldSession):
            robots.ledger.report(late, lease, Place(), at_rest=True, now_s=robots.now_s)
    assert robots.walk("bob").reason == "room_busy"


def test_a_robot_that_was_not_reported_at_rest_gets_nothing() -> None:
    robots = Robots(ann=None)
    robots.moves("ann", 0)
    assert robots.walk("ann").reason == "room_restless"
    robots.rests("ann")
    assert robots.walk("ann").number
    assert robots.walk("ann").reason == "room_restless", "it holds one already"


def test_after_a_restart_of_the_host_leases_stay_and_waiters_are_gone() -> None:
    robots = Robots(ann=None, bob=None)
    robots.walk("ann")
    robots.walk("bob")
    robots.ledger.rebooted()
    robots.now_s = 0.5
    assert robots.ledger.waiting(robots.now_s) == []
    answer = robots.walk("bob")
    assert (answer.reason, answer.silent_s) == ("room_busy", math.inf)
