"""A driver's part in a shared room: takes zone leases for its robot, reports where it is, and knows the others.

The guard calls `observe` with every state, `admit` before a step and `violation` while it runs. `exchange` does one
round of messages with the keeper; the driver calls it from a thread of its own, so that neither a step nor a stop waits
for a disk or a network. A stop never comes here.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Sequence

from agentrob.errors import RobotError
from agentrob.model import Hindrance, Op, Pose, Primitive
from agentrob.robots.control.controller import REST_WINDOW_S, RestDetector, rotate
from agentrob.robots.control.step_runner import unit_vector
from agentrob.robots.protocol import BODY_RADIUS_M
from agentrob.robots.zones.area import Area, covers, swept
from agentrob.robots.zones.keeper import ZoneKeeper
from agentrob.robots.zones.ledger import Answer, LeaseGone, Message, OldSession, Other, Place

log = logging.getLogger(__name__)

#: How often a robot that may move reports, and one that stands.
MOVING_EVERY_S, STANDING_EVERY_S = 0.1, 0.5
#: A step ends if no report was answered for this long; less than `RELEASE_S`, after which the owner may release it.
LOST_S = 2.0
#: A lease is kept this long after a step for the next one of the same command.
KEEP_S = 5.0
#: Only states younger than this are evidence of rest.
FRESH_S = 0.2
#: Free space to another robot's body, ahead of a robot that moves.
NEAR_M = 0.10


class RoomMember:
    """One robot in a room. Thread-safe. Without a common frame (`error_m` None) it always takes the whole room."""

    def __init__(
        self,
        robot: str,
        room: str,
        keeper: ZoneKeeper,
        *,
        home: Pose = Pose(0, 0, 0),
        error_m: float | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`home` is where the robot's home is in the room's frame, `error_m` by how much its place may be wrong."""
        self.robot, self.room, self.keeper = robot, room, keeper
        self._home, self._error_m, self._clock = home, error_m, clock
        self._framed = True
        self._io = threading.Lock()  # one exchange with the keeper at a time
        self._session, self._message = 0, 0
        self._rest = RestDetector(REST_WINDOW_S)
        self._state_s = -math.inf  # when the robot was in the newest state that came
        self._place: Pose | None = None
        self._moving = False  # whether a step runs
        self._must_rest = False  # whether a step was ended by the room: none follows before rest is measured
        self._lease = 0
        self._area: Area = None
        self._kept_until_s, self._answered_s, self._reported_s = -math.inf, -math.inf, -math.inf
        self._others: list[Other] = []
        self._closed = threading.Event()
        self._thread: threading.Thread | None = None

    # ------------------------------------------------------------ of the guard
    @property
    def framed(self) -> bool:
        """Whether the robot's place in the room is known."""
        return self._framed and self._error_m is not None

    def observe(self, odometry: Pose | None, age_s: float, at_home: Pose | None) -> None:
        """Take in a state: the odometry, and the same in the frame of the robot's home (None without a home)."""
        now_s = self._clock()
        if odometry is not None and age_s < FRESH_S:  # else it is where it was seen last
            self._state_s = now_s - age_s
            self._rest.update(now_s, odometry)
            self._place = None if at_home is None else self._in_room(at_home)

    def lose_frame(self, why: str) -> None:
        """From now on it is unknown where the robot is in the room: it takes the whole room."""
        if self._framed and self._error_m is not None:
            log.warning("%s takes the whole room %r from now on: %s", self.robot, self.room, why)
        self._framed = False

    def regain_frame(self) -> None:
        """The robot's home is again where its settings say."""
        self._framed = True

    def _in_room(self, at_home: Pose) -> Pose:
        x_m, y_m = rotate(at_home.x_m, at_home.y_m, self._home.yaw_rad)
        return Pose(self._home.x_m + x_m, self._home.y_m + y_m, self._home.yaw_rad + at_home.yaw_rad)

    @property
    def at_rest(self) -> bool:
        """Whether rest was measured: fresh states show the robot in one place, and no step runs."""
        fresh = self._clock() - self._state_s < FRESH_S
        return not self._moving and fresh and self._rest.reached

    def admit(self, steps: Sequence[Primitive]) -> Hindrance | None:
        """Get the lease for these steps, unless the held one covers them. Asks once; does not wait for others."""
        steps = [step for step in steps if step.moves]
        if not steps:
            return None
        area = self._area_of(steps)
        with self._io:
            now_s = self._clock()
            may_go_on = not self._must_rest or self.at_rest
            if self._lease and may_go_on and self._answered_s >= now_s - LOST_S and covers(self._area, area):
                self._kept_until_s = now_s + KEEP_S
                return None
            if not self.at_rest:
                return Hindrance("room_restless", "The robot has not come to rest, so it may not enter its room anew.")
            try:
                self._report(at_rest=True)
                asked_s = self._clock()
                place, doing = self._reported_place(), str(steps[0].op)
                answer = self.keeper.take(self._next(), place, area, doing)
            except OldSession:
                self._session = 0
                return self._unreachable("another driver of this robot has spoken since")
            except RobotError as e:
                return self._unreachable(str(e))
            if not answer.number:
                return self._hindrance(answer)
            self._lease, self._area = answer.number, area
            self._answered_s, self._kept_until_s = asked_s, asked_s + KEEP_S
            return None

    def begin(self) -> None:
        """A step begins: only states from now on are evidence that the robot rests afterwards."""
        self._moving, self._must_rest = True, False
        self._rest = RestDetector(REST_WINDOW_S)

    def end(self) -> None:
        """The step has ended; the lease is kept for a moment, and given back when the robot is at rest."""
        self._kept_until_s = self._clock() + KEEP_S
        self._moving = False

    def leave(self) -> None:
        """No step follows: give the lease back as soon as the robot is at rest."""
        self._kept_until_s = -math.inf

    def violation(self, primitive: Primitive, ahead_m: float) -> Hindrance | None:
        """Why a running step must end. `ahead_m` is how far a move would go on before it is at rest."""
        now_s, here, found = self._clock(), self._place, None
        if not self._lease or self._answered_s < now_s - LOST_S:
            sentence = f"It lost its place in the room {self.room!r}: {self._why_lost(now_s)}."
            found = Hindrance("room_lost", sentence)
        elif self.framed and here is not None:
            found = self._near(primitive, here, ahead_m)
        self._must_rest = self._must_rest or found is not None
        return found

    def _near(self, primitive: Primitive, here: Pose, ahead_m: float) -> Hindrance | None:
        x, y = unit_vector(primitive) if primitive.op is Op.MOVE else (0.0, 0.0)
        dx, dy = rotate(x * ahead_m, y * ahead_m, here.yaw_rad)
        for other in self._others:
            if (there := other.place.pose) is None:
                continue
            now_m = math.hypot(there.x_m - here.x_m, there.y_m - here.y_m)
            then_m = math.hypot(there.x_m - here.x_m - dx, there.y_m - here.y_m - dy)
            if primitive.op is Op.MOVE and then_m >= now_m:
                continue
            needed_m = 2 * BODY_RADIUS_M + (NEAR_M if primitive.op is Op.MOVE else 0.0)
            if then_m < needed_m:
                sentence = f"{other.robot} is {now_m:.2f} m away; this step needs {needed_m:.2f} m there."
                return Hindrance("robot_near", sentence, other.robot)
        return None

    def _why_lost(self, now_s: float) -> str:
        if not self._lease:
            return "its owner released it"
        return f"whoever keeps the room has not answered for {now_s - self._answered_s:.1f} s"

    def others(self) -> list[Other]:
        """The other robots of the room as they were last reported."""
        return self._others

    # ------------------------------------------------------------ messages
    def exchange(self) -> None:
        """Report, and give the lease back if it is no longer needed and rest was measured. Never raises."""
        now_s = self._clock()
        every_s = MOVING_EVERY_S if self._lease else STANDING_EVERY_S
        if now_s < self._reported_s + every_s:
            return
        with self._io:
            needed = self._moving or self._clock() < self._kept_until_s
            try:
                self._report(at_rest=self.at_rest and not needed)
            except OldSession:
                self._session = 0
                self._lose("another driver of this robot has spoken since")
            except LeaseGone:
                self._lose("its owner released it")
            except RobotError as e:
                log.warning("no report to the room %r: %s", self.room, e)
                self._reported_s = self._clock()

    def _report(self, *, at_rest: bool) -> None:
        """Report once; with `at_rest` the lease is over, even if the answer is lost. Raises what the keeper raises."""
        sent_s = self._clock()
        if at_rest:
            self._lease, self._area = 0, None
        if not self._session:
            self._session, self._message = self.keeper.hello(self.robot), 0
        self._others = self.keeper.report(self._next(), self._lease, self._reported_place(), at_rest=at_rest)
        self._answered_s = self._reported_s = sent_s

    def _lose(self, why: str) -> None:
        if self._lease:
            log.warning("the lease of %s in the room %r is lost: %s", self.robot, self.room, why)
        self._lease, self._area = 0, None

    def _next(self) -> Message:
        self._message += 1
        return Message(self.robot, self._session, self._message)

    def _reported_place(self) -> Place:
        return Place(self._place, self._error_m or 0.0) if self.framed else Place()

    def _area_of(self, steps: Sequence[Primitive]) -> Area:
        if not self.framed or self._place is None:
            return None
        return swept(self._place, steps, self._error_m or 0.0)

    # ------------------------------------------------------------ sentences
    def _unreachable(self, why: str) -> Hindrance:
        return Hindrance("room_unreachable", f"It cannot ask for its place in the room {self.room!r}: {why}.")

    def _hindrance(self, answer: Answer) -> Hindrance:
        who = answer.robot
        if answer.reason == "room_blocked":
            return Hindrance("room_blocked", f"{who} stands in the way.", answer.robot)
        if answer.reason == "room_restless":
            return Hindrance("room_restless", "The robot has not come to rest, so it may not enter its room anew.")
        sentence = f"The room {self.room!r} is taken: {who} moves or waits there ({answer.doing})."
        if answer.silent_s > LOST_S:
            silent = f"for {answer.silent_s:.0f} s" if math.isfinite(answer.silent_s) else "since a restart"
            sentence += (
                f" Its driver has been silent {silent}: the room is free again when it says that the robot is at rest, "
                f"or when its owner has seen to it: agentrob room {self.room} --release {answer.robot}"
            )
        return Hindrance("room_busy", sentence, answer.robot, answer.doing, answer.silent_s)

    # ------------------------------------------------------------ its thread
    def start(self) -> None:
        """Exchange messages in a thread until `close`."""
        self._thread = threading.Thread(target=self._run, name="room", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._closed.wait(MOVING_EVERY_S / 2):
            try:
                self.exchange()
            except Exception:  # the thread must survive: without reports every step ends
                log.exception("the exchange with the room failed")

    def close(self) -> None:
        """End the exchange. If the robot is at rest, this is said; otherwise its lease stays until the next driver
        says so."""
        self._closed.set()
        if self._thread is not None:
            self._thread.join(1.0)
        self._kept_until_s = -math.inf
        if self.at_rest:
            self._reported_s = -math.inf
            self.exchange()
