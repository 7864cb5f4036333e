"""The link to the arm: a thread that reads its pose and sends it the goals of steps, 50 times a second.

A goal of a step is sent only while no stop came since the step began, so that nothing follows a hold. A hold does not
wait for the thread: it is sent by whoever asks for it, as soon as the bus is free.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from typing import NamedTuple

from agentrob_so101.follower import Follower
from agentrob_so101.kinematics import so101
from agentrob_so101.pose import GRIPPER, NAMES, ArmPose, action_of, farthest_deg, near, pose_of

log = logging.getLogger(__name__)

RATE_HZ = 50.0
#: Speeds are measured over at least this time.
SPEED_S = 0.1
#: A hold goes at most this far from the measured pose: as far as gravity pulls a servo from its goal, so that holding
#: again does not lower the arm.
HOLD_DEG = 4.0
#: A hold waits so long for the answer that the bus owes another call.
BUSY_S = 0.1
#: Positions farther beyond the limits than this are not in degrees and percent.
UNITS_SLACK = 15.0


class Reading(NamedTuple):
    """A measured pose, when it came (monotonic), when it last differed from the one before, and the speeds of the
    fastest joint in °/s and of the gripper in %/s."""

    pose: ArmPose
    came_s: float
    changed_s: float
    speed_dps: float
    gripper_pps: float

    @property
    def age_s(self) -> float:
        return time.monotonic() - self.came_s


class Refusal(NamedTuple):
    """Why no goal could be sent, since when (monotonic)."""

    why: str
    since_s: float


class Link:
    """Holds an arm that is connected. `reading` is the newest pose, None until one came; `problem` says why none comes.
    `goal` is the newest pose that was sent, and `refusal` says why the last one was not and the
    next one waits; `stops` counts the holds."""

    def __init__(self, follower: Follower) -> None:
        self.reading: Reading | None = None
        self.problem = ""
        self.refusal: Refusal | None = None
        self.goal: ArmPose | None = None
        self.stops = 0
        self._wanted: tuple[ArmPose, int] | None = None  # the next goal, and the stops when its step began
        self._follower = follower
        self._bus = threading.Lock()  # one call of the follower at a time
        self._seen: deque[tuple[float, float, ArmPose]] = deque()  # when it was asked for, when it came
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._read, name="so101 link", daemon=True)
        self._thread.start()

    def aim(self, goal: ArmPose, stops: int) -> None:
        """Have a goal sent soon, of a step that began when there had been so many stops. Never blocks."""
        self._wanted = goal, stops

    @property
    def idle(self) -> bool:
        """Whether no goal waits to be sent."""
        return self._wanted is None

    def hold(self) -> bool:
        """Make the arm stay where it is, at once; goals of steps that began before are not sent any more. Returns
        whether it was sent."""
        self.stops += 1
        reading, self._wanted = self.reading, None
        if reading is None or not self._bus.acquire(timeout=BUSY_S):
            return False
        try:
            return self._sent(near(self.goal or reading.pose, reading.pose, HOLD_DEG))
        finally:
            self._bus.release()

    def close(self) -> None:
        """Hold, and disconnect; the arm keeps its pose."""
        if self._closed.is_set():
            return
        self.hold()
        self._closed.set()
        self._thread.join(1.0)
        try:
            self._follower.disconnect()
        except Exception as e:  # what LeRobot and the serial port raise
            log.warning("the arm could not be disconnected: %s", e)

    def _sent(self, goal: ArmPose) -> bool:
        try:
            self._follower.send_action(action_of(goal))
        except Exception as e:  # as above
            why = f"The arm takes no goal: {type(e).__name__}: {e}."
            if self.refusal is None:
                log.warning("%s", why)
            self.refusal = Refusal(why, self.refusal.since_s if self.refusal else time.monotonic())
            return False
        self.goal, self.refusal = goal, None
        return True

    def _send_wanted(self) -> None:
        with self._bus:
            wanted = self._wanted
            failed = wanted is not None and wanted[1] == self.stops and not self._sent(wanted[0])
            if not failed and self._wanted is wanted:
                self._wanted = None

    def _read(self) -> None:
        due_s = time.monotonic()
        while not self._closed.wait(max(0.0, due_s - time.monotonic())):
            due_s = max(due_s + 1 / RATE_HZ, time.monotonic())
            try:
                with self._bus:
                    asked_s = time.monotonic()
                    observation = self._follower.get_observation()
                pose = pose_of(observation)
            except ValueError as e:
                self.problem = str(e)
                continue
            except Exception as e:  # as above; one lost packet is no news, the state's age tells when they all are
                self.problem = f"The arm does not answer: {type(e).__name__}: {e}."
                continue
            self.problem = _wrong_units(pose)
            if not self.problem:
                self.reading = self._taken(asked_s, pose)
                self._send_wanted()

    def _taken(self, asked_s: float, pose: ArmPose) -> Reading:
        """The reading of a pose that came now. A pose is of some moment since it was asked for, so the speed is the
        least one that explains two of them."""
        now_s, before = time.monotonic(), self.reading
        self._seen.append((asked_s, now_s, pose))
        while len(self._seen) > 1 and asked_s - self._seen[1][1] > SPEED_S:
            self._seen.popleft()
        then_asked_s, _, then = self._seen[0]
        passed_s = max(now_s - then_asked_s, SPEED_S)
        changed_s = now_s if before is None or before.pose != pose else before.changed_s
        return Reading(
            pose,
            now_s,
            changed_s,
            farthest_deg(pose, then)[1] / passed_s,
            abs(pose.gripper - then.gripper) / passed_s,
        )


def _wrong_units(pose: ArmPose) -> str:
    """A sentence about a position that cannot be in degrees or percent; empty if all can."""
    arm = so101()
    for name, value, low, high in zip(NAMES, pose, arm.lowest, arm.highest, strict=True):
        if not low - UNITS_SLACK <= value <= high + UNITS_SLACK:
            unit = "percent" if name == GRIPPER else "degrees"
            return (
                f"The arm tells {name} as {value:.0f}, which is not in {unit}: is it calibrated, and does another "
                "program set other units?"
            )
    return ""
