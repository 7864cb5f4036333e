"""The driver of one robot: its guard and its leases, without sockets."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Sequence
from dataclasses import replace

from agentrob.errors import RobotBusy, RobotError
from agentrob.model import ActionResult, FencingToken, Hindrance, Lock, Pose, Posture, Primitive, RobotState, StopResult
from agentrob.robots.codec import display_name
from agentrob.robots.driver.fencing import FencingNumbers
from agentrob.robots.driver.lease import Leases
from agentrob.robots.safety.guard import Guard
from agentrob.robots.zones.keeper import ZoneKeeper

log = logging.getLogger(__name__)

#: Wait at most this long for rest before the process ends.
LAST_STOP_S = 0.4
#: A new holder waits at most this long for the end of the last holder's step: a robot comes to rest within 3 s.
TAKE_S = 4.0
#: Minimum time between two pictures taken with `look`.
LOOK_S = 0.4


class Driver:
    """The driver's operations, without sockets. All methods are thread-safe."""

    def __init__(
        self, name: str, guard: Guard, numbers: FencingNumbers | None = None, kept: tuple[str, ZoneKeeper] | None = None
    ) -> None:
        """`kept` is the name of the room whose zones this driver keeps for other hosts, and its keeper."""
        self.name, self.guard, self.kept = name, guard, kept
        self.leases = Leases(numbers=numbers)
        self._step = threading.Lock()
        self._looking, self._looked_s = threading.Lock(), -LOOK_S

    @property
    def busy(self) -> bool:
        return self._step.locked()

    def state(self) -> RobotState:
        return self.guard.state()

    def posture(self, *, joints: bool = True) -> Posture:
        return self.guard.posture(joints=joints)

    def fence(self, fence: FencingToken) -> None:
        """Lock out workers with a smaller fencing number of the same database, also after a restart of the driver; a
        lease of such a worker ends, and its robot stops.

        Raises `Fenced` if a larger number was seen, and `RobotError` if this one cannot be written to disk.
        """
        self.leases.fence(fence)
        self.leases.numbers.save()

    def take(self, holder: str, since_s: float | None = None, fence: FencingToken | None = None) -> str:
        """Return a new lease, after waiting until the previous holder's step has come to rest.

        `since_s` is when the command was accepted, in monotonic seconds; default now. `fence` is the fencing number of
        a worker that shares the robot with others. Raises `RobotBusy`, `LeaseLost` if a stop or halt came since then,
        including during this wait, and as `fence`.
        """
        asked_s = time.monotonic()
        since_s, end_s = asked_s if since_s is None else since_s, asked_s + TAKE_S
        self.leases.refuse_ended(since_s)
        if fence is not None:
            self.fence(fence)
        while self.leases.holder is None and self.busy and time.monotonic() < end_s:
            time.sleep(0.02)
        if self.leases.holder is None and self.busy:
            raise RobotBusy("the robot is still ending its previous holder's step; try again in a moment")
        lease = self.leases.take(holder, since_s, fence)
        log.info("lease to %s", holder)
        return lease

    def give_back(self, lease: str) -> None:
        """End a lease on behalf of its holder, and its zone once the robot is at rest."""
        self.leases.give_back(lease)
        if self.leases.holder is None:
            self.guard.leave_room()

    def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        """Run a step and block until it has ended. Raises `LeaseLost` and `RobotBusy`."""
        self.leases.check(lease)
        if not self._step.acquire(blocking=False):
            raise RobotBusy("another step of this lease is still running")
        try:
            result = self.guard.step(primitive, lambda _: self.leases.lost(lease), deadline_s)
        finally:
            self._step.release()
        log.info("step %s %s: %s %s", primitive.op, primitive.asked(), result.outcome, result.message)
        return result

    def enter_room(self, steps: Sequence[Primitive]) -> Hindrance | None:
        """Get the zone that these steps need in the shared room, if there is one; they then begin within some seconds.

        Return why not: asking again, at least every two seconds, keeps the robot's place among those that wait.
        """
        return self.guard.enter_room(steps)

    def look(self) -> bytes:
        """Return a picture of the robot's own camera. Raises `RobotBusy` if the last one, of any client, was less than
        `LOOK_S` ago or is still being taken."""
        if not self._looking.acquire(blocking=False):
            raise RobotBusy("the robot's camera is in use by another request")
        try:
            if time.monotonic() - self._looked_s < LOOK_S:
                raise RobotBusy(f"the robot's camera gives at most one picture every {LOOK_S:g} s")
            self._looked_s = time.monotonic()
            return self.guard.look()
        finally:
            self._looking.release()

    def stop(self, by: str, asked_s: float | None = None, *, running_only: bool = False) -> StopResult:
        """Stop the robot and end the lease, as well as commands that were accepted before.

        With `running_only`, which an agent uses to end its own command, accepted commands are not affected. `asked_s`
        is when the stop was requested, in monotonic seconds; the measured latency starts there.
        """
        asked_s = time.monotonic() if asked_s is None else asked_s
        ended_s = self.leases.end("stop", by, running_only=running_only)
        late_ms = 1000 * (time.monotonic() - asked_s)
        result = self.guard.stop()
        if not running_only:
            self.guard.leave_room()
        log.warning("stop by %s: %s", by, result)
        return replace(result, latency_ms=round(result.latency_ms + late_ms, 3), ended_s=ended_s)

    def halt(self, by: str) -> StopResult:
        """Stop, and refuse all motion until a `release` that was requested after `ended_s` of the result."""
        ended_s = self.leases.end("halt", by)
        return replace(self.guard.halt(display_name(by), asked_s=ended_s), ended_s=ended_s)

    def release(self, by: str, since_s: float = math.inf) -> Lock | None:
        """Unlock the robot; return the removed lock, or None if there was none. Commands that were accepted before
        are ended, so nothing moves (law 14).

        `since_s` is when the release was requested, in monotonic seconds. Raises `RobotError` if it stays locked.
        """
        lock = self.guard.release(by, since_s)
        if lock is not None:
            self.leases.end("release", by)
        return lock

    def home(self, by: str) -> Pose:
        """Set home to the robot's current pose. Raises `RobotError`, also while the robot moves."""
        if self.busy:
            raise RobotError("cannot set home while a step runs")
        return self.guard.home(display_name(by))

    def close(self) -> None:
        """Stop the robot, wait briefly until it is at rest, and disconnect."""
        self.leases.end("shutdown")
        last = threading.Thread(target=self.guard.stop, daemon=True)
        last.start()
        last.join(LAST_STOP_S)
        self.guard.close()
