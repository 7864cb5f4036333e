"""Law 11 in a shared room: whatever crashes, hangs, is lost, delayed, doubled or overtaken, no two robots move in one
zone, none moves into another one, and every command ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from agentrob.errors import RobotUnreachable
from agentrob.model import Direction, Hindrance, Op, Pose, Primitive
from agentrob.robots.protocol import BODY_RADIUS_M
from agentrob.robots.zones.area import Area, conflict, swept
from agentrob.robots.zones.ledger import Answer, Ledger, Message, Other, Place, StillHeard
from agentrob.robots.zones.member import KEEP_S, LOST_S, RoomMember

ERROR_M = 0.1
STARTS = {"ann": Pose(0, 0, 0), "bob": Pose(2.5, 0, math.pi), "cid": Pose(1.2, -2, math.pi / 2)}
ROBOTS = st.sampled_from(sorted(STARTS))
#: What the way to the keeper does with the next messages.
FATES = st.sampled_from(["arrives", "lost", "answer lost", "delayed", "doubled"])


class BadLink:
    """Delivers messages to a ledger, or loses, delays or doubles them. Delayed ones arrive when `late` is called."""

    def __init__(self, ledger: Ledger, clock: Callable[[], float]) -> None:
        self.ledger, self.clock, self.fate, self.before = ledger, clock, "arrives", 0
        self.delayed: list[Callable[[], Any]] = []

    def _send(self, call: Callable[[], Any]) -> Any:
        fate = "arrives"
        if self.before > 0:
            self.before -= 1
        else:
            fate, self.fate = self.fate, "arrives"
        if fate in ("lost", "delayed"):
            self.delayed += [call] if fate == "delayed" else []
            raise RobotUnreachable("no answer")
        if fate == "doubled":
            self.delayed.append(call)
        answer = call()
        if fate == "answer lost":
            raise RobotUnreachable("no answer")
        return answer

    def late(self, index: int) -> None:
        call = self.delayed.pop(index % len(self.delayed))
        try:
            call()
        except Exception:  # nobody waits for the answer
            return

    def hello(self, robot: str) -> int:
        return self._send(lambda: self.ledger.hello(robot, self.clock()))  # type: ignore[no-any-return]

    def take(self, message: Message, place: Place, area: Area, doing: str) -> Answer:
        return self._send(lambda: self.ledger.take(message, place, area, doing, self.clock()))  # type: ignore[no-any-return]

    def report(self, message: Message, lease: int, place: Place, *, at_rest: bool) -> list[Other]:
        call: Callable[[], Any] = lambda: self.ledger.report(  # noqa: E731
            message, lease, place, at_rest=at_rest, now_s=self.clock()
        )
        return self._send(call)  # type: ignore[no-any-return]


@dataclass
class Truth:
    """The true motion of a robot. While it moves it may be anywhere on its `path`."""

    pose: Pose
    moving: bool = False
    stepping: bool = False  # whether its driver commands it
    area: Area = None
    end: Pose | None = None
    step: Primitive | None = None
    alive: bool = True
    frozen: bool = False
    known: bool = True  # whether its place was not released
    outcomes: list[str] = field(default_factory=list)


class Zones(RuleBasedStateMachine):
    framed = True

    def __init__(self) -> None:
        super().__init__()
        self.now_s = 100.0
        self.ledger = Ledger()
        self.link = BadLink(self.ledger, lambda: self.now_s)
        self.truths = {name: Truth(pose) for name, pose in STARTS.items()}
        self.members: dict[str, RoomMember] = {}

    @initialize()
    def begin(self) -> None:
        for name in STARTS:
            self._start(name)
        self._pass(1.0)

    def _start(self, name: str) -> None:
        truth = self.truths[name]
        self.members[name] = RoomMember(
            name,
            "lab",
            self.link,
            error_m=ERROR_M if self.framed else None,
            clock=lambda: self.now_s,  # type: ignore[arg-type]
        )
        truth.alive, truth.frozen, truth.stepping = True, False, False

    def _pass(self, seconds: float) -> None:
        """Let time go by: each driver that runs sees its robot 20 times a second and exchanges messages."""
        for _ in range(round(seconds * 20)):
            self.now_s += 0.05
            for name, truth in self.truths.items():
                if not truth.alive or truth.frozen:
                    continue
                member = self.members[name]
                seen = truth.pose if not truth.moving else _moved(truth.pose, self.now_s)
                member.observe(seen, 0.0, seen if not truth.moving else truth.pose)
                if truth.stepping and truth.step is not None and member.violation(truth.step, 0.0) is not None:
                    self._end_step(name, "stopped")
                member.exchange()

    def _end_step(self, name: str, how: str) -> None:
        truth = self.truths[name]
        truth.stepping = False
        truth.outcomes.append(how)
        self.members[name].end()

    def _rests(self, name: str, share: float) -> None:
        truth = self.truths[name]
        if truth.end is not None:
            x, y = truth.pose.x_m, truth.pose.y_m
            truth.pose = Pose(x + share * (truth.end.x_m - x), y + share * (truth.end.y_m - y), truth.end.yaw_rad)
        truth.moving, truth.end = False, None

    def _ask(self, name: str, step: Primitive) -> Hindrance | None:
        truth, member = self.truths[name], self.members[name]
        hindrance = member.admit([step])
        if hindrance is None:
            assert not truth.moving
            member.begin()
            if member.violation(step, 0.0) is not None:  # a step checks this before its first command
                member.end()
                return Hindrance("room_lost", "")
            truth.stepping = truth.moving = True
            area = swept(truth.pose, [step], ERROR_M)
            truth.area, truth.step = (area if self.framed else None), step
            last = area[-1]
            turned = math.radians(step.degrees or 0.0)
            truth.end = Pose(last.x1_m, last.y1_m, truth.pose.yaw_rad + turned)
        return hindrance

    # ------------------------------------------------------------ what happens
    @rule(name=ROBOTS, distance_m=st.sampled_from([0.5, 1.0, 2.0, 3.0]), fate=FATES, before=st.integers(0, 2))
    def walks(self, name: str, distance_m: float, fate: str, before: int) -> None:
        self._may_ask(name, Primitive(Op.MOVE, Direction.FORWARD, distance_m=distance_m), fate, before)

    @rule(name=ROBOTS, degrees=st.sampled_from([45.0, 90.0, 180.0]), fate=FATES, before=st.integers(0, 2))
    def turns(self, name: str, degrees: float, fate: str, before: int) -> None:
        self._may_ask(name, Primitive(Op.TURN, Direction.LEFT, degrees=degrees), fate, before)

    def _may_ask(self, name: str, step: Primitive, fate: str, before: int) -> None:
        truth = self.truths[name]
        if truth.alive and not truth.frozen and not truth.stepping:
            self.link.fate, self.link.before = fate, before
            self._ask(name, step)

    @rule(name=ROBOTS, share=st.sampled_from([0.0, 0.5, 1.0]), then_s=st.sampled_from([0.0, 0.6, KEEP_S + 0.5]))
    def arrives(self, name: str, share: float, then_s: float) -> None:
        """The step ends, and the robot is at rest."""
        truth = self.truths[name]
        if truth.moving:
            self._rests(name, share)
            if truth.stepping and not truth.frozen:
                self._end_step(name, "done")
        self._pass(then_s)

    @rule(seconds=st.sampled_from([0.05, 0.3, 1.0, KEEP_S]))
    def time_passes(self, seconds: float) -> None:
        self._pass(seconds)

    @rule(name=ROBOTS)
    def crashes(self, name: str) -> None:
        self.truths[name].alive = self.truths[name].stepping = False

    @precondition(lambda self: any(not truth.alive for truth in self.truths.values()))
    @rule(then_s=st.sampled_from([0.0, 0.6]))
    def is_restarted(self, then_s: float) -> None:
        name = next(name for name, truth in self.truths.items() if not truth.alive)
        self._start(name)
        self._pass(then_s)

    @rule(name=ROBOTS)
    def hangs(self, name: str) -> None:
        self.truths[name].frozen = True

    @precondition(lambda self: any(truth.frozen for truth in self.truths.values()))
    @rule()
    def runs_again(self) -> None:
        name, truth = next((name, truth) for name, truth in self.truths.items() if truth.frozen)
        truth.frozen = False
        if truth.stepping and truth.step is not None and self.members[name].violation(truth.step, 0.0) is not None:
            self._end_step(name, "stopped")

    @rule(fate=FATES, before=st.integers(0, 3))
    def a_message_is_lost(self, fate: str, before: int) -> None:
        self.link.fate, self.link.before = fate, before

    @precondition(lambda self: self.link.delayed)
    @rule(index=st.integers(0, 50))
    def a_message_arrives_late(self, index: int) -> None:
        self.link.late(index)

    @rule(name=ROBOTS)
    def its_owner_releases_it(self, name: str) -> None:
        """The owner has seen that the robot is at rest."""
        truth = self.truths[name]
        if not truth.moving:
            try:
                self.ledger.release(name, self.now_s)
            except StillHeard:
                return
            truth.known = False
            if truth.stepping:  # of a driver that hangs, and its robot stands: it does not go on
                assert truth.frozen

    # ------------------------------------------------------------ what always holds
    @invariant()
    def no_two_move_in_one_zone(self) -> None:
        moving = [truth for truth in self.truths.values() if truth.moving or (truth.stepping and not truth.frozen)]
        for k, one in enumerate(moving):
            for other in moving[k + 1 :]:
                assert not conflict(one.area, other.area)

    @invariant()
    def none_walks_into_another(self) -> None:
        names = [name for name, truth in self.truths.items() if truth.known]
        if not self.framed or len(names) < len(STARTS):
            return
        truths = list(self.truths.values())
        for k, one in enumerate(truths):
            for other in truths[k + 1 :]:
                apart_m = math.hypot(one.pose.x_m - other.pose.x_m, one.pose.y_m - other.pose.y_m)
                assert apart_m >= 2 * BODY_RADIUS_M

    def teardown(self) -> None:
        """Once everything works again, each command ends: each robot moves, or is told who stands in its way."""
        if not self.members:
            return
        self.link.fate, self.link.before, self.link.delayed = "arrives", 0, []
        for name, truth in self.truths.items():
            if truth.moving:
                self._rests(name, 0.5)
            if not truth.alive or truth.frozen or truth.stepping:
                self._start(name)
        self._pass(KEEP_S + LOST_S)
        assert not any(member.lease for member in self.ledger.members.values())
        for name in STARTS:
            hindrance = self._ask(name, Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5))
            assert hindrance is None or hindrance.reason == "room_blocked", hindrance
            if hindrance is None:
                self._rests(name, 0.0)
                self._end_step(name, "done")
            self._pass(KEEP_S + 1)


class WholeRoom(Zones):
    """The same without a common frame: one mover at a time."""

    framed = False


def _moved(pose: Pose, now_s: float) -> Pose:
    """Odometry of a robot that is not at rest."""
    return Pose(pose.x_m + 0.2 * math.sin(7 * now_s), pose.y_m, pose.yaw_rad)


#: Shrinking a failure of a state machine takes minutes.
PHASES = [Phase.explicit, Phase.reuse, Phase.generate]
TestZones = Zones.TestCase
TestZones.settings = settings(max_examples=60, stateful_step_count=40, phases=PHASES, report_multiple_bugs=False)
TestWholeRoom = WholeRoom.TestCase
TestWholeRoom.settings = settings(max_examples=30, stateful_step_count=40, phases=PHASES, report_multiple_bugs=False)
