"""Walk a distance or turn an angle, closed on odometry: pure arithmetic, no clock, no transport.

The same object runs behind a robot's SDK, in the fake robot and in simulated time (`benchmarks/accuracy.py`):

    motion = Motion(gait, forward_m=1.0)
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


class Velocity(NamedTuple):
    """Body velocity: forward and left in m/s, counter-clockwise in rad/s."""

    forward_mps: float = 0.0
    left_mps: float = 0.0
    turn_rps: float = 0.0


REST = Velocity()


@dataclass(frozen=True, slots=True)
class Gait:
    """How a robot walks: what it may be commanded, from where on commands have an effect, and how it coasts."""

    speed_mps: float = 0.5
    side_mps: float = 0.3
    turn_rps: float = math.radians(45)
    speed_min_mps: float = 0.10
    turn_min_rps: float = 0.20
    gain_speed: float = 1.5  # 1/s: slow down near the goal
    gain_turn: float = 2.2  # 1/s
    coast_s: float = 0.25  # a body goes on for about speed x coast_s after its command drops
    settle_s: float = 0.8  # at rest before looking again
    corrections: int = 4
    stop_at_m: float = 0.015  # stop correcting inside this …
    stop_at_rad: float = math.radians(1.2)
    accept_m: float = 0.02  # … but at rest accept this (looser: no endless dithering)
    accept_rad: float = math.radians(2.0)
    start_s: float = 3.0  # without any progress from the start: stalled
    stall_s: float = 2.0  # without progress later
    budget_s: float = 14.0  # beside twice the time of the way at full speed

    def at_most(self, speed_mps: float, turn_rps: float) -> Gait:
        """The same gait, commanded no faster than this."""
        return replace(
            self,
            speed_mps=min(self.speed_mps, speed_mps),
            side_mps=min(self.side_mps, speed_mps),
            turn_rps=min(self.turn_rps, turn_rps),
            speed_min_mps=min(self.speed_min_mps, speed_mps),
            turn_min_rps=min(self.turn_min_rps, turn_rps),
        )


def wrap(angle_rad: float) -> float:
    """The same angle in [-pi, pi)."""
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi


def rotate(x: float, y: float, angle_rad: float) -> tuple[float, float]:
    """A vector turned counter-clockwise."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return c * x - s * y, s * x + c * y


class _Sample(NamedTuple):
    t_s: float
    x_m: float
    y_m: float
    turned_rad: float  # since the start, beyond half a turn too


class _Error(NamedTuple):
    """What is left to go: in the body's frame, and the angle."""

    forward_m: float
    left_m: float
    turn_rad: float

    @property
    def distance_m(self) -> float:
        return math.hypot(self.forward_m, self.left_m)

    def within(self, distance_m: float, angle_rad: float) -> bool:
        return self.distance_m < distance_m and abs(self.turn_rad) < angle_rad


class Motion:
    """One move (`forward_m`, `left_m`, heading held) or turn (`turn_rad`, position held)."""

    def __init__(self, gait: Gait, forward_m: float = 0.0, left_m: float = 0.0, turn_rad: float = 0.0) -> None:
        self.gait = gait
        self.forward_m, self.left_m, self.turn_rad = forward_m, left_m, turn_rad
        self.ended = ""
        self._goal: tuple[float, float] | None = None  # set by the first sample
        self._last = _Sample(0.0, 0.0, 0.0, 0.0)
        self._yaw = 0.0
        self._drift = (0.0, 0.0, 0.0)  # low-passed velocity: m/s, m/s, rad/s in the odometry frame
        self._deadline_s = math.inf
        self._best, self._best_s, self._patience_s = math.inf, 0.0, gait.start_s
        self._settling, self._settled_s, self._rounds = False, 0.0, 0
        self._window: deque[_Sample] = deque()

    def step(self, now_s: float, pose: Pose) -> Velocity | None:
        """One odometry sample in, the velocity to command out; None when the motion has ended."""
        here = self._track(now_s, pose)
        if now_s > self._deadline_s:
            self.ended = "timeout"
        elif self._settling:
            return self._settle(now_s, here)
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
        if error.within(self.gait.stop_at_m, self.gait.stop_at_rad):
            return self._begin_settling(now_s)
        left = error.distance_m + 0.3 * abs(error.turn_rad)
        if left < self._best - 0.01:
            self._best, self._best_s, self._patience_s = left, now_s, self.gait.stall_s
        elif now_s - self._best_s > self._patience_s:
            if error.within(0.05, math.radians(4)):  # close by and only dithering: look again at rest
                return self._begin_settling(now_s)
            self.ended = "stalled"
            return None
        return self._towards(error)

    def _error(self, here: _Sample, *, coasting: bool) -> _Error:
        assert self._goal is not None
        ahead = self.gait.coast_s if coasting else 0.0  # where the body would come to rest if commanded to stop now
        ex = self._goal[0] - here.x_m - self._drift[0] * ahead
        ey = self._goal[1] - here.y_m - self._drift[1] * ahead
        turn = self.turn_rad - here.turned_rad - self._drift[2] * ahead
        return _Error(*rotate(ex, ey, -self._yaw), turn)

    def _begin_settling(self, now_s: float) -> Velocity:
        self._settling, self._settled_s = True, now_s + self.gait.settle_s
        self._window.clear()
        return REST

    def _settle(self, now_s: float, here: _Sample) -> Velocity | None:
        self._window.append(here)
        while self._window[0].t_s < now_s - REST_WINDOW_S:
            self._window.popleft()
        if now_s < self._settled_s:
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
            self._settling, self._best, self._best_s, self._patience_s = False, math.inf, now_s, self.gait.stall_s
            return self._towards(error)
        return None

    def _towards(self, error: _Error) -> Velocity:
        g, vx, vy, wz = self.gait, 0.0, 0.0, 0.0
        if (distance := error.distance_m) >= g.stop_at_m * 0.7:
            speed = min(max(g.gain_speed * distance, g.speed_min_mps), g.speed_mps)
            vx, vy = speed * error.forward_m / distance, speed * error.left_m / distance
            slower = max(abs(vy) / g.side_mps, 1.0)
            vx, vy = vx / slower, vy / slower
        if abs(error.turn_rad) >= g.stop_at_rad * 0.7:
            wz = math.copysign(min(max(g.gain_turn * abs(error.turn_rad), g.turn_min_rps), g.turn_rps), error.turn_rad)
        return Velocity(vx, vy, wz)
