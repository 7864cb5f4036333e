"""The control loop of one step: goals along a way, within limits of speed and place, until the arm is at rest there.

The arm gets goals, not velocities: whatever ends this loop, it stays at its last goal, which is at most some degrees
ahead of where it is.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import NamedTuple

from agentrob.model import RobotState
from agentrob.robots.protocol import Watch
from agentrob_so101.keep_out import KeepOut
from agentrob_so101.link import RATE_HZ, Link, Reading
from agentrob_so101.pose import ArmPose, between, farthest_deg, near

#: A state that is older ends a step (law 8).
STATE_AGE_S = 0.5
#: The watch is asked at every second goal, 25 times a second.
WATCHED = 2
#: A loop that comes late goes on from where it was: its goals never jump.
LATEST_S = 0.04
GRIPPER_PPS = 100.0
#: A way speeds up and slows down in this time.
RAMP_S = 0.3
#: A joint that is this far from its goal, for this long, does not follow.
BEHIND_DEG, BEHIND_S = 20.0, 0.3
#: Positions that do not change for this long, while goals have gone this far, are no news.
FROZEN_S, FROZEN_DEG = 0.3, 4.0
#: A goal may fail to be sent for so long, as a packet is lost on a bus.
REFUSED_S = 0.4
#: How much faster than its limit a joint may be measured: servos swing.
FASTER, SLACK_DPS = 1.5, 30.0
#: At rest: slower than this for so long. A step waits so long for that, and for its joints to be this near.
REST_DPS, REST_PPS, REST_S, SETTLE_S = 3.0, 4.0, 0.15, 2.5
NEAR_DEG, GOOD_DEG = 1.0, 4.0
#: Gravity pulls joints from their goals; goals are corrected by this share of the error, at most so far.
CORRECTION, MOST_CORRECTION_DEG = 0.08, 10.0
#: A gripper that closes on something presses with a goal so far inside it.
SQUEEZE, HELD_FROM = 12.0, 6.0


class Ended(NamedTuple):
    """How a way ended: a stable word and a sentence, both empty if the arm is where it should be."""

    reason: str = ""
    message: str = ""
    began: bool = True


class Mover:
    """Moves the arm of a link. `state` is the robot's."""

    def __init__(self, link: Link, keep_out: KeepOut, speed_dps: float, state: Callable[[], RobotState]) -> None:
        self._link, self._keep_out, self._speed_dps, self._state = link, keep_out, speed_dps, state
        self._behind_s = 0.0
        self._offset = ArmPose()  # what is added to where the arm should be, against gravity
        self._reached: tuple[ArmPose, ArmPose] | None = None  # where it should be since the last step, and its goal

    def start(self) -> ArmPose | None:
        """Return the pose from which a way begins: where the last step ended, or else the last goal if the arm is
        near it, or else where it is. None while the arm has not reported its position."""
        reading, goal = self._link.reading, self._link.goal
        if reading is None:
            return None
        if goal is None or farthest_deg(goal, reading.pose)[1] > MOST_CORRECTION_DEG:
            return reading.pose
        return self._reached[0] if self._reached is not None and self._reached[1] == goal else goal

    def go(self, poses: tuple[ArmPose, ...], watch: Watch, stops: int) -> Ended:
        """Move through the poses; `stops` is how many stops there had been when the step began."""
        start = self.start()
        if (unseen := self._unseen()) or start is None:
            return Ended("stale_state", unseen, began=False)
        reading = self._link.reading
        here = self._keep_out.now(reading.pose) if reading is not None else None
        if objection := here or self._keep_out.on_the_way((start, *poses)):
            return Ended(*objection, began=False)  # without a hold, which would yield to what pushes it
        if reason := watch(self._state()):
            return Ended(reason, began=False)
        self._behind_s = time.monotonic()
        if self._reached is None or self._reached[0] is not start:
            self._offset = ArmPose()
        self._reached = None
        for first, last in itertools.pairwise((start, *poses)):
            if ended := self._along(first, last, watch, stops):
                return ended
        return self._settle(poses[-1], watch, stops)

    def _along(self, start: ArmPose, end: ArmPose, watch: Watch, stops: int) -> Ended | None:
        seconds, passed_s, before_s, count = self._seconds(start, end), 0.0, time.monotonic(), 0
        moved_from, moved_s, goal = start, before_s, start
        while passed_s < seconds:
            now_s, reading = time.monotonic(), self._link.reading
            if reading is not None and reading.changed_s > moved_s:
                moved_from, moved_s = goal, now_s
            frozen = farthest_deg(goal, moved_from)[1] > FROZEN_DEG and now_s - moved_s > FROZEN_S
            if ended := self._objection(goal, watch if count % WATCHED == 0 else None, frozen=frozen):
                return ended
            if self._link.idle:  # a link that is late must not find a goal far ahead
                passed_s += min(now_s - before_s, LATEST_S)
                goal = between(start, end, eased(min(1.0, passed_s / seconds), seconds))
                self._link.aim(plus(goal, self._offset), stops)
            before_s, count = now_s, count + 1
            time.sleep(1 / RATE_HZ)
        return None

    def _settle(self, target: ArmPose, watch: Watch, stops: int) -> Ended:
        """Wait for rest at the target, and correct what gravity does."""
        end_s, rests_s = time.monotonic() + SETTLE_S, time.monotonic()
        while (now_s := time.monotonic()) < end_s:
            reading = self._link.reading
            if ended := self._objection(target, watch):
                return ended
            assert reading is not None
            if not at_rest(reading):
                rests_s = now_s
            error_deg = farthest_deg(target, reading.pose)[1]
            if now_s - rests_s > REST_S and error_deg < NEAR_DEG:
                break
            self._offset = corrected(self._offset, target, reading.pose)
            self._link.aim(plus(target, self._offset), stops)
            time.sleep(1 / RATE_HZ)
        return self._arrived(target, stops)

    def _arrived(self, target: ArmPose, stops: int) -> Ended:
        reading = self._link.reading
        assert reading is not None
        if reading.pose.gripper - target.gripper > HELD_FROM:  # it closed on something
            target = target._replace(gripper=max(0.0, reading.pose.gripper - SQUEEZE))
        goal = plus(target, self._offset)
        self._link.aim(goal, stops)
        self._reached = target, goal
        joint, error_deg = farthest_deg(target, reading.pose)
        if error_deg > GOOD_DEG:
            return Ended("inaccurate", f"The joint {joint} is {error_deg:.1f}° from where it should be.")
        if not at_rest(reading):
            return Ended("restless", "The arm did not come to rest.")
        return Ended()

    def _objection(self, goal: ArmPose, watch: Watch | None, *, frozen: bool = False) -> Ended | None:
        """Why the arm must stop now; None if it may go on."""
        if watch is not None and (reason := watch(self._state())):
            return Ended(reason)
        if unseen := self._unseen():
            return Ended("stale_state", unseen)
        reading = self._link.reading
        assert reading is not None
        if (refusal := self._link.refusal) is not None and time.monotonic() - refusal.since_s > REFUSED_S:
            return Ended("no_answer", refusal.why)
        if objection := self._keep_out.now(reading.pose):
            return Ended(*objection)
        if reading.speed_dps > FASTER * self._speed_dps + SLACK_DPS:
            allowed = f"{self._speed_dps:g}°/s are allowed"
            return Ended("limit_turn_dps", f"A joint turned at {reading.speed_dps:.0f}°/s, and {allowed}.")
        if frozen:
            return Ended("stalled", "The arm's positions do not change, though it gets goals: it does not follow them.")
        joint, behind_deg = farthest_deg(goal, reading.pose)
        if behind_deg < BEHIND_DEG:
            self._behind_s = time.monotonic()
        elif time.monotonic() - self._behind_s > BEHIND_S:
            return Ended("stalled", f"The joint {joint} does not follow: it is {behind_deg:.0f}° from its goal.")
        return None

    def _unseen(self) -> str:
        """A sentence about a state that is too old; empty for a fresh one."""
        reading = self._link.reading
        if reading is not None and reading.age_s < STATE_AGE_S:
            return ""
        age = "never came" if reading is None else f"is {reading.age_s:.1f} s old"
        return f"The arm's state {age}. {self._link.problem}".strip()

    def _seconds(self, start: ArmPose, end: ArmPose) -> float:
        """How long a part of the way takes, also to speed up and to slow down."""
        turned_s = farthest_deg(start, end)[1] / self._speed_dps
        return max(turned_s, abs(end.gripper - start.gripper) / GRIPPER_PPS) + RAMP_S


def at_rest(reading: Reading) -> bool:
    return reading.speed_dps < REST_DPS and reading.gripper_pps < REST_PPS


def eased(share: float, seconds: float) -> float:
    """Return the share of the way that is behind after a share of its time: the speed rises and falls in `RAMP_S`."""
    ramp = min(0.5, RAMP_S / seconds)
    full = 1.0 / (1.0 - ramp)  # speed between the ramps
    if share < ramp:
        return full * share * share / (2 * ramp)
    if share > 1.0 - ramp:
        return 1.0 - full * (1.0 - share) ** 2 / (2 * ramp)
    return full * (share - ramp / 2)


def plus(pose: ArmPose, offset: ArmPose) -> ArmPose:
    return ArmPose(*(p + o for p, o in zip(pose, offset, strict=True)))


def corrected(offset: ArmPose, target: ArmPose, measured: ArmPose) -> ArmPose:
    """Return an offset that is moved by a share of what the joints miss; the gripper is not corrected."""
    moved = ArmPose(*(o + CORRECTION * (t - m) for o, t, m in zip(offset, target, measured, strict=True)))
    return near(moved, ArmPose(), MOST_CORRECTION_DEG)._replace(gripper=0.0)
