"""Which robot may move in which part of one room: a state machine without clock, disk or network.

A driver first says `hello` and gets a session number; messages of an earlier session of that robot are refused. It
numbers its messages, so that one that was delayed, doubled or overtaken has no effect. `take` grants a zone lease with
a fencing number. Only `report` with `at_rest`, sent by a driver that measured rest, gives it back: a driver that is
silent keeps its lease, since its robot may move, until it reports or the owner calls `release`.

Everything that a request needs is granted at once or not at all, and nobody waits while it holds something else, so
that robots cannot wait for each other in a circle. Those that wait are served in the order in which they asked, as far
as their areas conflict.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from agentrob.model import Pose
from agentrob.robots.protocol import BODY_RADIUS_M
from agentrob.robots.zones.area import GESTURE_RADIUS_M, STANDING_MARGIN_M, Area, Capsule, body, conflict, gap_m

#: A robot that waits asks again at least this often; otherwise it has given up.
WAITER_S = 3.0
#: A lease can be released once its driver has been silent for this long: it has then stopped the robot by itself.
RELEASE_S = 3.0
#: A robot that is near another one may move away from it, or turn, with a tolerance of this.
AWAY_M = 0.01


class Message(NamedTuple):
    """Who sends a message: the robot, its driver's session, and the number of the message in that session."""

    robot: str
    session: int
    number: int


@dataclass(frozen=True, slots=True)
class Place:
    """Where a robot is in the room's frame, within `error_m`; `pose` is None where that is not known."""

    pose: Pose | None = None
    error_m: float = 0.0

    @property
    def body(self) -> tuple[Capsule, ...]:
        return () if self.pose is None else (body(self.pose, self.error_m),)


@dataclass(frozen=True, slots=True)
class ZoneLease:
    """The right of a robot to move in an area. `number` is the fencing number, `doing` the operation that it does."""

    number: int
    area: Area
    doing: str


@dataclass(slots=True)
class Member:
    """The record of one robot of the room. `seen_s` is when its driver last sent a valid message, None for an
    earlier boot of the keeper's host."""

    session: int = 0
    message: int = 0
    seen_s: float | None = None
    place: Place = field(default_factory=Place)
    at_rest: bool = False
    lease: ZoneLease | None = None


@dataclass(slots=True)
class Waiter:
    robot: str
    area: Area
    seen_s: float


@dataclass(frozen=True, slots=True)
class Other:
    """Another robot of the room, as a member hears of it. `silent_s` is infinite if its driver was never heard."""

    robot: str
    place: Place
    moving: bool
    doing: str
    silent_s: float


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to `take`: the fencing number, or why not.

    `reason`: `room_busy` (`robot` moves in the area, or asked for it earlier: asking again may help), `room_blocked`
    (`robot` stands in the area) or `room_restless` (the robot itself was not reported at rest). `doing` is what `robot`
    does, `silent_s` how long its driver has not been heard.
    """

    number: int = 0
    reason: str = ""
    robot: str = ""
    doing: str = ""
    silent_s: float = 0.0


class OldSession(Exception):
    """The message is of an earlier session, or arrived after a later message of its session. Nothing was changed."""


class LeaseGone(Exception):
    """The robot no longer holds the lease that it reports: the owner released it. Its driver must stop it."""


class StillHeard(Exception):
    """The driver of the robot was heard a moment ago, so its lease is not released: it gives it back by itself."""


@dataclass
class Ledger:
    """All robots of a room. Times are monotonic seconds of the keeper's host."""

    counter: int = 0
    members: dict[str, Member] = field(default_factory=dict)
    waiters: list[Waiter] = field(default_factory=list)

    # ------------------------------------------------------------ of drivers
    def hello(self, robot: str, now_s: float) -> int:
        """Begin a session of this robot's driver; return its number. A lease of an earlier session stays."""
        self.counter += 1
        member = self.members.setdefault(robot, Member())
        member.session, member.message, member.seen_s, member.at_rest = self.counter, 0, now_s, False
        self._forget_waiter(robot)
        return self.counter

    def take(self, message: Message, place: Place, area: Area, doing: str, now_s: float) -> Answer:
        """Ask for a lease of this area, for a robot that is at rest at `place` and holds none. Raises `OldSession`."""
        member = self._receive(message, now_s)
        if member.lease is not None or not member.at_rest:
            return Answer(reason="room_restless", robot=message.robot)
        member.place = place
        self._drop_silent_waiters(now_s)
        if (answer := self._refusal(message.robot, place, area, now_s)) is not None:
            if answer.reason == "room_busy":
                self._wait(message.robot, area, now_s)
            else:
                self._forget_waiter(message.robot)
            return answer
        self._forget_waiter(message.robot)
        self.counter += 1
        member.lease, member.at_rest = ZoneLease(self.counter, area, doing), False
        return Answer(self.counter)

    def report(self, message: Message, lease: int, place: Place, *, at_rest: bool, now_s: float) -> list[Other]:
        """Say where the robot is, and whether rest was measured; return the other robots.

        With `at_rest` its lease ends, of whatever session. Otherwise `lease` is the number that its driver moves by, 0
        for none. Raises `OldSession`, and `LeaseGone` if that lease was released.
        """
        member = self._receive(message, now_s)
        member.place, member.at_rest = place, at_rest
        if at_rest:
            member.lease = None
        elif lease and (member.lease is None or member.lease.number != lease):
            raise LeaseGone
        return self.others(message.robot, now_s)

    # ------------------------------------------------------------ of owners
    def release(self, robot: str, now_s: float) -> ZoneLease | None:
        """End the lease of a robot that its owner has seen at rest, and forget where it stood. Return the lease.

        Raises `StillHeard` unless its driver has been silent for `RELEASE_S`.
        """
        member = self.members.get(robot)
        if member is None:
            return None
        if member.seen_s is not None and now_s - member.seen_s < RELEASE_S:
            raise StillHeard
        lease, member.lease = member.lease, None
        member.place, member.at_rest = Place(), False
        self._forget_waiter(robot)
        return lease

    def others(self, robot: str, now_s: float) -> list[Other]:
        """The robots of the room without this one."""
        return [self._other(name, now_s) for name in sorted(self.members) if name != robot]

    def waiting(self, now_s: float) -> list[str]:
        """The robots that wait, the first one first."""
        self._drop_silent_waiters(now_s)
        return [waiter.robot for waiter in self.waiters]

    # ------------------------------------------------------------ how
    def _receive(self, message: Message, now_s: float) -> Member:
        member = self.members.get(message.robot)
        if member is None or member.session != message.session or message.number <= member.message:
            raise OldSession
        member.message, member.seen_s = message.number, now_s
        return member

    def _refusal(self, robot: str, place: Place, area: Area, now_s: float) -> Answer | None:
        for other in self.others(robot, now_s):
            lease = self.members[other.robot].lease
            if lease is not None and conflict(area, lease.area):
                return Answer(0, "room_busy", other.robot, other.doing, other.silent_s)
        ahead = self._ahead_of(robot)
        for other in self.others(robot, now_s):
            if self.members[other.robot].lease is None and _in_the_way(area, place, other.place):
                waits = any(waiter.robot == other.robot for waiter in ahead)  # it will move on, and not wait for us
                return Answer(0, "room_busy" if waits else "room_blocked", other.robot, other.doing, other.silent_s)
        for waiter in ahead:
            if conflict(area, waiter.area):
                other = self._other(waiter.robot, now_s)
                return Answer(0, "room_busy", other.robot, other.doing, other.silent_s)
        return None

    def _ahead_of(self, robot: str) -> list[Waiter]:
        names = [waiter.robot for waiter in self.waiters]
        return self.waiters[: names.index(robot)] if robot in names else self.waiters

    def _other(self, robot: str, now_s: float) -> Other:
        member = self.members[robot]
        silent_s = math.inf if member.seen_s is None else max(0.0, now_s - member.seen_s)
        waits = any(waiter.robot == robot for waiter in self.waiters)
        doing = member.lease.doing if member.lease is not None else "wait" if waits else ""
        return Other(robot, member.place, member.lease is not None, doing, silent_s)

    def _wait(self, robot: str, area: Area, now_s: float) -> None:
        """Enter a waiter behind the others; one that asks again keeps its place, also if its area has changed."""
        for waiter in self.waiters:
            if waiter.robot == robot:
                waiter.area, waiter.seen_s = area, now_s
                return
        self.waiters.append(Waiter(robot, area, now_s))

    def _forget_waiter(self, robot: str) -> None:
        self.waiters = [waiter for waiter in self.waiters if waiter.robot != robot]

    def _drop_silent_waiters(self, now_s: float) -> None:
        self.waiters = [waiter for waiter in self.waiters if now_s - waiter.seen_s <= WAITER_S]

    def rebooted(self) -> None:
        """The keeper's host was restarted, so its clock began anew: nobody has been heard since."""
        self.waiters = []
        for member in self.members.values():
            member.seen_s = None


def _in_the_way(area: Area, start: Place, other: Place) -> bool:
    """Whether a robot that stands is in an area. One that is too near already may still be left, or turned beside."""
    if area is None or other.pose is None or gap_m(area, other.body) >= STANDING_MARGIN_M:
        return False
    if start.pose is None or gap_m(start.body, other.body) >= STANDING_MARGIN_M:
        return True
    standing = (Capsule(other.pose.x_m, other.pose.y_m, other.pose.x_m, other.pose.y_m, 0.0),)
    now_m = math.hypot(start.pose.x_m - other.pose.x_m, start.pose.y_m - other.pose.y_m)
    return any(_comes_nearer(capsule, standing, now_m) for capsule in area)


def _comes_nearer(capsule: Capsule, standing: tuple[Capsule, ...], now_m: float) -> bool:
    in_place = capsule[:2] == capsule[2:4]
    if in_place and (capsule.radius_m >= GESTURE_RADIUS_M or now_m < 2 * BODY_RADIUS_M):
        return True
    return gap_m((capsule._replace(radius_m=0.0),), standing) < now_m - AWAY_M
