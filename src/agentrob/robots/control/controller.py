"""Closed-loop controller of one move or turn, fed with odometry; pure arithmetic, without clock or transport.

The same object runs behind a robot's SDK, in the fake robot and in simulated time (`benchmarks/accuracy.py`):

    motion = MotionController(gait, forward_m=1.0)
    while (velocity := motion.step(now_s, pose)) is not None:
        send(velocity)                      # 20 times a second
    motion.ended                            # arrived, inaccurate, stalled or timeout
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from typing import NamedTuple

from agentrob.model import Pose

#: Control periods per second.
RATE_HZ = 20.0
#: Odometry is averaged over this long at rest, against its noise.
REST_WINDOW_S = 0.3
#: After a stop the body must stay in place this long to count as at rest.
STOPPED_WINDOW_S = 0.5
#: A body that moves less than this in that time is at rest; larger than the noise of the odometry (2 mm, 0.2°).
REST_M, REST_RAD = 0.012, math.radians(1.2)
#: Upper bound of the learned shift of position and heading while coming to rest.
SHIFT_M, SHIFT_RAD = 0.05, math.radians(6)


class Velocity(NamedTuple):
    """Body velocity: forward and left in m/s, counter-clockwise in rad/s."""

    forward_mps: float = 0.0
    left_mps: float = 0.0
    turn_rps: float = 0.0


REST = Velocity()


@dataclass(frozen=True, slots=True)
class Gait:
    """How a robot walks: the velocities it may be commanded, the smallest that take effect, and how it coasts."""

    speed_mps: float = 0.5
    side_mps: float = 0.3
    turn_rps: float = math.radians(45)
    speed_min_mps: float = 0.20  # the lowest speed while walking; below it a body that was faster may stop
    turn_min_rps: float = 0.30
    step_mps: float = 0.15  # the lowest speed from rest, for corrections
    step_rps: float = 0.25
    gain_speed: float = 2.0  # 1/s: slow down near the goal
    gain_turn: float = 2.0  # 1/s
    gain_hold: float = 1.2  # 1/s: to hold the heading in a move and the position in a turn
    coast_s: float = 0.10  # a body coasts about speed x coast_s after its command drops …
    coast_turn_s: float = 0.05  # … and turns about rate x coast_turn_s further
    settle_s: float = 0.9  # wait at least this long before measuring again …
    settle_limit_s: float = 2.0  # … and at most this long if it does not come to rest
    corrections: int = 4
    # Bipeds correct by whole strides of this length at one velocity: measurements within a stride are mostly sway.
    stride_s: float = 0.0
    #: Initial estimate of their unintended shift: forward and left in m, counter-clockwise in rad; then learned.
    stride_shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    stop_at_m: float = 0.015  # the goal is reached inside this …
    stop_at_rad: float = math.radians(1.2)
    accept_m: float = 0.03  # … but at rest accept this (looser: no endless dithering; odometry adds its own error)
    accept_rad: float = math.radians(2.8)
    start_s: float = 3.0  # without any progress from the start: stalled
    stall_s: float = 2.0  # without progress later
    budget_s: float = 14.0  # in addition to twice the time of the path at full speed

    def at_most(self, speed_mps: float, turn_rps: float) -> Gait:
        """The same gait, commanded no faster than this."""
        return replace(
            self,
            speed_mps=min(self.speed_mps, speed_mps),
            side_mps=min(self.side_mps, speed_mps),
            turn_rps=min(self.turn_rps, turn_rps),
            speed_min_mps=min(self.speed_min_mps, speed_mps),
            turn_min_rps=min(self.turn_min_rps, turn_rps),
            step_mps=min(self.step_mps, speed_mps),
            step_rps=min(self.step_rps, turn_rps),
        )


def wrap(angle_rad: float) -> float:
    """The same angle in [-pi, pi)."""
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi


def known(pose: Pose | None) -> Pose | None:
    """Return the pose, or None if any of its numbers is NaN or infinite."""
    if pose is None or not all(map(math.isfinite, (pose.x_m, pose.y_m, pose.yaw_rad))):
        return None
    return pose


def rotate(x: float, y: float, angle_rad: float) -> tuple[float, float]:
    """A vector turned counter-clockwise."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return c * x - s * y, s * x + c * y


def _clip(value: float, bound: float) -> float:
    return max(-bound, min(bound, value))


class RestDetector:
    """Detects from odometry that a body is at rest: it stayed in place for `window_s`."""

    def __init__(self, window_s: float = REST_WINDOW_S) -> None:
        self._window_s = window_s
        self._seen: deque[tuple[float, Pose]] = deque()
        self.reached = False

    def update(self, now_s: float, pose: Pose) -> bool:
        self._seen.append((now_s, pose))
        while self._seen[0][0] < now_s - self._window_s:
            self._seen.popleft()
        self.reached = now_s - self._seen[0][0] >= 0.8 * self._window_s and all(
            math.hypot(p.x_m - pose.x_m, p.y_m - pose.y_m) < REST_M and abs(wrap(p.yaw_rad - pose.yaw_rad)) < REST_RAD
            for _, p in self._seen
        )
        return self.reached

    @property
    def since_s(self) -> float:
        """Time of the oldest pose of the rest window; infinite before the first."""
        return self._seen[0][0] if self._seen else math.inf

    def distance_m(self, start: Pose | None) -> float | None:
        """Distance from `start` to the current position, averaged over the rest window; None if either is unknown."""
        if start is None or not self._seen:
            return None
        n = len(self._seen)
        x_m, y_m = sum(p.x_m for _, p in self._seen) / n, sum(p.y_m for _, p in self._seen) / n
        return round(math.hypot(x_m - start.x_m, y_m - start.y_m), 4)

    def turned_rad(self, start: Pose | None) -> float | None:
        """Angle from the heading of `start` to the current heading, averaged likewise."""
        if start is None or not self._seen:
            return None
        return sum(wrap(p.yaw_rad - start.yaw_rad) for _, p in self._seen) / len(self._seen)


class _Sample(NamedTuple):
    t_s: float
    x_m: float
    y_m: float
    turned_rad: float  # since the start, beyond half a turn too


class _Error(NamedTuple):
    """Remaining distance in the body's frame, and remaining angle."""

    forward_m: float
    left_m: float
    turn_rad: float

    @property
    def distance_m(self) -> float:
        return math.hypot(self.forward_m, self.left_m)

    def within(self, distance_m: float, angle_rad: float) -> bool:
        return self.distance_m < distance_m and abs(self.turn_rad) < angle_rad


_NOTHING = _Error(0.0, 0.0, 0.0)


class _Stride(NamedTuple):
    """A correction of a two-legged body: one velocity for whole strides. `error` is what was left when it began."""

    until_s: float
    velocity: Velocity
    plan: _Error
    error: _Error


class MotionController:
    """One move (`forward_m`, `left_m`, heading held) or turn (`turn_rad`, position held)."""

    def __init__(self, gait: Gait, forward_m: float = 0.0, left_m: float = 0.0, turn_rad: float = 0.0) -> None:
        if not (turn_rad or math.hypot(forward_m, left_m) > 1e-6):
            raise ValueError("a motion needs a distance or an angle")
        self.gait = gait
        self.forward_m, self.left_m, self.turn_rad = forward_m, left_m, turn_rad
        self.ended = ""
        self._goal: tuple[float, float] | None = None  # set by the first sample
        self._last = _Sample(0.0, 0.0, 0.0, 0.0)
        self._yaw = 0.0
        self._drift = (0.0, 0.0, 0.0)  # low-passed velocity: m/s, m/s, rad/s in the odometry frame
        self._deadline_s = math.inf
        self._best, self._best_s, self._patience_s = math.inf, 0.0, gait.start_s
        self._settling, self._settle_s, self._rest, self._rounds = False, 0.0, RestDetector(), 0
        self._window: deque[_Sample] = deque()
        self._expected = _Error(0.0, 0.0, 0.0)  # the expected remaining error when it was commanded to rest
        self._shift = (0.0, 0.0, 0.0)
        self._stride: _Stride | None = None

    def step(self, now_s: float, pose: Pose) -> Velocity | None:
        """Take one odometry sample; return the velocity to command, or None once the motion has ended."""
        here = self._track(now_s, pose)
        if now_s > self._deadline_s:
            self.ended = "timeout"
        elif self._settling:
            return self._settle(now_s, here)
        elif self._stride is not None:
            return self._stride.velocity if now_s < self._stride.until_s else self._begin_settling(now_s, _NOTHING)
        else:
            return self._approach(now_s, here)
        return None

    def _track(self, now_s: float, pose: Pose) -> _Sample:
        if self._goal is None:
            self._begin(now_s, pose)
        last = self._last
        here = _Sample(now_s, pose.x_m, pose.y_m, last.turned_rad + wrap(pose.yaw_rad - self._yaw))
        if (dt := now_s - last.t_s) > 0:
            a = dt / (0.15 + dt)
            vx, vy, w = self._drift
            self._drift = (
                vx + a * ((here.x_m - last.x_m) / dt - vx),
                vy + a * ((here.y_m - last.y_m) / dt - vy),
                w + a * ((here.turned_rad - last.turned_rad) / dt - w),
            )
        self._last, self._yaw = here, pose.yaw_rad
        return here

    def _begin(self, now_s: float, pose: Pose) -> None:
        self._last, self._yaw = _Sample(now_s, pose.x_m, pose.y_m, 0.0), pose.yaw_rad
        dx, dy = rotate(self.forward_m, self.left_m, pose.yaw_rad)
        self._goal = pose.x_m + dx, pose.y_m + dy
        way_s = math.hypot(self.forward_m / self.gait.speed_mps, self.left_m / self.gait.side_mps)
        self._deadline_s = now_s + self.gait.budget_s + 2 * (way_s + abs(self.turn_rad) / self.gait.turn_rps)
        self._best_s = now_s

    def _approach(self, now_s: float, here: _Sample) -> Velocity | None:
        error = self._error(here, coasting=True)
        if self._reached(error):
            return self._begin_settling(now_s, error)
        left = error.distance_m + 0.3 * abs(error.turn_rad)
        if left < self._best - 0.01:
            self._best, self._best_s, self._patience_s = left, now_s, self.gait.stall_s
        elif now_s - self._best_s > self._patience_s:
            if error.within(0.05, math.radians(4)):  # close to the goal without progress: measure again at rest
                return self._begin_settling(now_s, error)
            self.ended = "stalled"
            return None
        return self._towards(error) if self._rounds == 0 else self._correct(error)

    def _reached(self, error: _Error) -> bool:
        """On the way, check only the requested axis, since a walking body sways; a correction checks all axes."""
        if self._rounds:
            return error.within(0.6 * self.gait.accept_m, 0.6 * self.gait.accept_rad)
        if self.turn_rad:
            return math.copysign(1.0, self.turn_rad) * error.turn_rad < self.gait.stop_at_rad
        return self._along(error) < self.gait.stop_at_m

    def _along(self, error: _Error) -> float:
        """Metres left in the direction of the move; negative past the goal."""
        way_m = math.hypot(self.forward_m, self.left_m)
        return (error.forward_m * self.forward_m + error.left_m * self.left_m) / way_m

    def _error(self, here: _Sample, *, coasting: bool) -> _Error:
        assert self._goal is not None
        # Coasting: where the body would come to rest if commanded to stop now.
        ahead, ahead_turning = (self.gait.coast_s, self.gait.coast_turn_s) if coasting else (0.0, 0.0)
        ex = self._goal[0] - here.x_m - self._drift[0] * ahead
        ey = self._goal[1] - here.y_m - self._drift[1] * ahead
        turn = self.turn_rad - here.turned_rad - self._drift[2] * ahead_turning
        forward_m, left_m = rotate(ex, ey, -self._yaw)
        if coasting:
            forward_m, left_m, turn = (
                e - shift for e, shift in zip((forward_m, left_m, turn), self._shift, strict=True)
            )
        return _Error(forward_m, left_m, turn)

    def _begin_settling(self, now_s: float, expected: _Error) -> Velocity:
        self._settling, self._settle_s, self._rest, self._expected = True, now_s, RestDetector(), expected
        self._window.clear()
        return REST

    def _settle(self, now_s: float, here: _Sample) -> Velocity | None:
        self._window.append(here)
        while self._window[0].t_s < now_s - REST_WINDOW_S:
            self._window.popleft()
        resting = self._rest.update(now_s, Pose(here.x_m, here.y_m, here.turned_rad))
        waited_s = now_s - self._settle_s
        if waited_s < self.gait.settle_s or not (resting or waited_s > self.gait.settle_limit_s):
            return REST
        n = len(self._window)
        _, x_m, y_m, turned = (sum(values) / n for values in zip(*self._window, strict=True))
        error = self._error(_Sample(now_s, x_m, y_m, turned), coasting=False)
        if error.within(self.gait.accept_m, self.gait.accept_rad):
            self.ended = "arrived"
        elif self._rounds >= self.gait.corrections:
            self.ended = "inaccurate"
        else:
            self._rounds += 1
            if self.gait.stride_s:
                self._stride = self._next_stride(now_s, error)
                self._settling = False
                return self._stride.velocity
            self._shift = self._learned(error)
            self._settling, self._best, self._best_s, self._patience_s = False, math.inf, now_s, self.gait.stall_s
            return self._correct(error)
        return None

    def _learned(self, error: _Error) -> tuple[float, float, float]:
        """How far the body moved past the expected point while coming to rest, in its frame; used for the next stop."""
        expected = zip(self._expected, error, self._shift, strict=True)
        forward_m, left_m, turn = (shift + hoped - found for hoped, found, shift in expected)
        return _clip(forward_m, SHIFT_M), _clip(left_m, SHIFT_M), _clip(turn, SHIFT_RAD)

    def _next_stride(self, now_s: float, error: _Error) -> _Stride:
        """Plan strides at one velocity for this error, corrected by the unintended shift of the last strides."""
        g, shift = self.gait, _Error(*self.gait.stride_shift)
        if (last := self._stride) is not None:
            moves = zip(last.error, error, last.plan, strict=True)
            forward_m, left_m, turn = (before - after - planned for before, after, planned in moves)
            shift = _Error(_clip(forward_m, 2 * SHIFT_M), _clip(left_m, 2 * SHIFT_M), _clip(turn, SHIFT_RAD))
        plan = _Error(*(e - s for e, s in zip(error, shift, strict=True)))
        needed_s = max(plan.distance_m / g.side_mps, abs(plan.turn_rad) / g.turn_rps)
        seconds = g.stride_s * max(1, math.ceil(needed_s / g.stride_s))
        return _Stride(now_s + seconds, Velocity(*(p / seconds for p in plan)), plan, error)

    def _towards(self, error: _Error) -> Velocity:
        """On the way: drive the requested axis fast and correct the others gently."""
        g = self.gait
        if self.turn_rad:
            hold = g.gain_hold if error.distance_m > g.accept_m else 0.0
            return self._bounded(
                hold * error.forward_m, hold * error.left_m, self._turning(error.turn_rad, g.turn_min_rps)
            )
        way_m, left_m = math.hypot(self.forward_m, self.left_m), self._along(error)
        ux, uy = self.forward_m / way_m, self.left_m / way_m
        speed = max(g.gain_speed * left_m, g.speed_min_mps)
        aside_m = error.left_m * ux - error.forward_m * uy
        vx, vy = speed * ux - g.gain_hold * aside_m * uy, speed * uy + g.gain_hold * aside_m * ux
        return self._bounded(vx, vy, g.gain_hold * error.turn_rad)

    def _correct(self, error: _Error) -> Velocity:
        """From rest: take a few quick steps, then measure again."""
        g, vx, vy, wz = self.gait, 0.0, 0.0, 0.0
        if (distance_m := error.distance_m) > 0.5 * g.accept_m:
            speed = max(g.gain_speed * distance_m, g.step_mps)
            vx, vy = speed * error.forward_m / distance_m, speed * error.left_m / distance_m
        if abs(error.turn_rad) > 0.5 * g.accept_rad:
            wz = self._turning(error.turn_rad, g.step_rps)
        return self._bounded(vx, vy, wz)

    def _turning(self, left_rad: float, least_rps: float) -> float:
        return math.copysign(max(self.gait.gain_turn * abs(left_rad), least_rps), left_rad)

    def _bounded(self, vx: float, vy: float, wz: float) -> Velocity:
        g = self.gait
        slower = max(math.hypot(vx, vy) / g.speed_mps, abs(vy) / g.side_mps, 1.0)
        return Velocity(vx / slower, vy / slower, _clip(wz, g.turn_rps))
