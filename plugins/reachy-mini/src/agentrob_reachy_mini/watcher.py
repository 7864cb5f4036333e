"""Follows the state of a Reachy Mini: asks its daemon 25 times a second, and says how old and how believable it is."""

from __future__ import annotations

import itertools
import logging
import math
import threading
import time
from collections import deque
from typing import NamedTuple

from agentrob.model import Pose, RobotState
from agentrob_reachy_mini.daemon import MOTORS_ON, Daemon, DaemonLost, DaemonRefused
from agentrob_reachy_mini.pose import BodyPose, apart_rad

log = logging.getLogger(__name__)

POLL_S = 0.04
#: Moves of others and the health of the daemon are asked for with every so many states.
EVERY = 3
#: Its motors must have answered the daemon within this time.
MOTORS_S = 0.3
#: It is at rest once no angle has changed by more than this for so long.
REST_RAD, REST_S = 0.012, 0.25
#: Faster than this for so long without a move of ours, somebody else moves it.
FOREIGN_RPS, FOREIGN_S = 0.2, 0.5
KEPT_S = 1.0
#: What AgentRob does with it now.
IDLE, GESTURE, TURNING = "idle", "gesture", "walking"
#: The motors are off, or somebody moves it by hand: the robot does not go where it is sent.
LIMP = "damping"


class Seen(NamedTuple):
    """A pose, and when it was asked for (monotonic seconds)."""

    at_s: float
    pose: BodyPose


class Watcher:
    """`doing` is set by the robot while it moves. Everything may be read from any thread."""

    def __init__(self, daemon: Daemon) -> None:
        self._daemon = daemon
        self.doing = IDLE
        self._came = threading.Condition()
        self._recent: tuple[Seen, ...] = ()
        self._stamp = self._mode = self._complaint = self._unhealthy = ""
        self._ours: deque[str] = deque(maxlen=100)
        self._foreign = False
        self._alive: float | None = None
        self._alive_s: float | None = None  # when `_alive` last changed
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="reachy-mini-state", daemon=True)
        self._thread.start()

    # ------------------------------------------------------------ what is known
    @property
    def newest(self) -> Seen | None:
        recent = self._recent
        return recent[-1] if recent else None

    def age_s(self) -> float:
        """How old the newest state is, by the last answer of its motors where the daemon tells it; infinite if none
        ever came."""
        newest = self.newest
        if newest is None:
            return math.inf
        return time.monotonic() - (newest.at_s if self._alive_s is None else min(newest.at_s, self._alive_s))

    def state(self) -> RobotState:
        """As the guard has it: the foot stays, and its yaw is that of the body."""
        newest = self.newest
        if newest is None:
            return RobotState(math.inf)
        pose = Pose(0.0, 0.0, newest.pose.body_yaw)
        return RobotState(
            self.age_s(), pose, (0.0, 0.0), self._yaw_rate_rps(), self._mode_now(), upright=True, error_code=0
        )

    def silence(self) -> str:
        """Why no state comes, as a sentence; empty if nothing is wrong."""
        return self._complaint

    def at_rest(self) -> bool:
        """Whether it has held its pose for a moment, by a state that is recent."""
        recent = [seen for seen in self._recent if seen.at_s >= time.monotonic() - REST_S - 2 * POLL_S]
        return (
            len(recent) > 2
            and recent[-1].at_s - recent[0].at_s >= REST_S - POLL_S
            and all(apart_rad(seen.pose, recent[-1].pose) < REST_RAD for seen in recent)
        )

    def own(self, move: str) -> None:
        """Record that a move is ours."""
        self._ours.append(move)

    def wait_newer(self, than: Seen | None, limit_s: float) -> Seen | None:
        """Wait for a state newer than this one; return the newest, which is the same one if none comes in time."""
        with self._came:
            self._came.wait_for(lambda: self.newest is not than or self._closed.is_set(), limit_s)
        return self.newest

    def close(self) -> None:
        self._closed.set()
        with self._came:
            self._came.notify_all()
        self._thread.join()

    # ------------------------------------------------------------ asking
    def _run(self) -> None:
        count, next_s = 0, time.monotonic()
        while not self._closed.is_set():
            complaint = self._ask(count)
            if complaint and complaint != self._complaint:
                log.warning("%s", complaint)
            self._complaint = complaint
            count += 1
            next_s = max(next_s + POLL_S, time.monotonic())
            self._closed.wait(next_s - time.monotonic())

    def _ask(self, count: int) -> str:
        """Take one state in; return what is wrong."""
        try:
            if count % EVERY == 0:
                self._unhealthy = self._ask_health()
            if self._unhealthy:
                return self._unhealthy
            at_s = time.monotonic()
            sample = self._daemon.state()
        except (DaemonLost, DaemonRefused) as e:
            return str(e)
        if sample.stamp == self._stamp:
            return f"{self._daemon.url} repeats an old state: its time stamp does not advance."
        self._stamp, self._mode = sample.stamp, sample.mode
        recent = (seen for seen in self._recent if seen.at_s >= at_s - KEPT_S)
        with self._came:
            self._recent = (*recent, Seen(at_s, sample.pose))
            self._came.notify_all()
        return ""

    def _ask_health(self) -> str:
        health = self._daemon.health()
        now_s = time.monotonic()
        if health.alive is not None and health.alive != self._alive:
            self._alive, self._alive_s = health.alive, now_s
        if not health.running or health.error:
            why = f": {health.error}" if health.error else ""
            return f"The control loop of {self._daemon.url} does not run{why}."
        if self._alive_s is not None and now_s - self._alive_s > MOTORS_S:
            return f"The motors have not answered {self._daemon.url} for {now_s - self._alive_s:.1f} s."
        self._foreign = bool(self._daemon.running() - set(self._ours))
        return ""

    # ------------------------------------------------------------ what it does
    def _mode_now(self) -> str:
        if self._mode != MOTORS_ON:
            return LIMP
        if self.doing != IDLE:
            return self.doing
        return GESTURE if self._foreign or self._moved_by_others() else IDLE

    def _moved_by_others(self) -> bool:
        """Whether head or body have turned all the time for a moment, each state farther on than the one before."""
        recent = self._recent
        if not recent or recent[-1].at_s - recent[0].at_s < FOREIGN_S:
            return False
        late = [seen.pose for seen in recent if seen.at_s >= recent[-1].at_s - FOREIGN_S]
        aside = [pose._replace(right_antenna=0.0, left_antenna=0.0) for pose in late]
        return all(apart_rad(a, b) > FOREIGN_RPS * POLL_S for a, b in itertools.pairwise(aside))

    def speed_rps(self) -> float:
        """How fast the fastest of its angles changes, in rad/s."""
        recent = self._recent[-3:]
        if len(recent) < 2:
            return 0.0
        return apart_rad(recent[-1].pose, recent[0].pose) / max(recent[-1].at_s - recent[0].at_s, 1e-3)

    def _yaw_rate_rps(self) -> float | None:
        recent = self._recent[-3:]
        if len(recent) < 2:
            return None
        return (recent[-1].pose.body_yaw - recent[0].pose.body_yaw) / max(recent[-1].at_s - recent[0].at_s, 1e-3)
