"""A simulated differential base in a room with obstacles: kinematics, odometry and laser scan.

It needs numpy alone: the demo's simulator (`simulator.py`) and the peer tests' rclpy node both run it.
Wheels follow their commands with a lag, slip a little, and are measured by encoders of their own, so that the odometry
drifts from the true pose as on a real base.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[Any]

TRACK_M = 0.287  # between the wheels, as on a TurtleBot 3 Waffle
RADIUS_M = 0.17
WHEEL_MPS = 0.8  # maximum of a wheel
LAG_S = 0.08  # a wheel follows its motor with this time constant
HOLD_S = 0.5  # a command expires after this time, as in diff_drive_controller
SLIP = 0.004  # relative error of what a wheel rolls, drawn for each meter
BEAMS, RANGE_MIN_M, RANGE_MAX_M, RANGE_NOISE_M = 360, 0.10, 12.0, 0.008


class Box(NamedTuple):
    """An obstacle seen from above: a rectangle around (x_m, y_m), parallel to the axes."""

    x_m: float
    y_m: float
    length_m: float
    width_m: float
    name: str = ""
    colour: str = "#9aa4b0"


class Pillar(NamedTuple):
    """A round obstacle around (x_m, y_m)."""

    x_m: float
    y_m: float
    radius_m: float
    name: str = ""
    colour: str = "#9aa4b0"


Obstacle = Box | Pillar
#: The room of the demo and the tests, with the base at its origin: `ROOM_M` by `ROOM_M`, walls included.
ROOM_M = 8.0
ROOM: tuple[Obstacle, ...] = (
    Box(2.6, 2.2, 0.9, 0.6, "table", "#996940"),
    Box(-2.7, -2.3, 0.5, 1.2, "shelf", "#7a5b3a"),
    Pillar(-2.2, 2.4, 0.25, "plant", "#3f8f4f"),
    Pillar(2.4, -2.4, 0.20, "bin", "#4a6fa5"),
)


@dataclass(slots=True)
class SimulatedBase:
    """Call `advance` with the seconds that passed; positions in metres, x forward at the start, y left."""

    obstacles: list[Obstacle] = field(default_factory=lambda: list(ROOM))
    room_m: float = ROOM_M
    seed: int = 7
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    #: What its encoders say, in the frame of its start.
    odom: tuple[float, float, float] = (0.0, 0.0, 0.0)
    odom_speed: tuple[float, float] = (0.0, 0.0)  # m/s, rad/s
    charge: float = 0.93  # 0 to 1
    bumped: bool = False
    #: The brakes are on, as with its emergency stop pressed: it hears commands and does not follow them.
    braked: bool = False
    _wheels: tuple[float, float] = (0.0, 0.0)
    _wanted: tuple[float, float] = (0.0, 0.0)
    _held_s: float = 0.0
    _slips: tuple[float, float] = (0.0, 0.0)
    _rolled_m: float = 1.0
    _random: random.Random = field(init=False)
    _noise: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self._random, self._noise = random.Random(self.seed), np.random.default_rng(self.seed)

    def command(self, forward_mps: float, turn_rps: float) -> None:
        """Take a velocity; a wheel that cannot be so fast slows both."""
        left, right = forward_mps - turn_rps * TRACK_M / 2, forward_mps + turn_rps * TRACK_M / 2
        slower = max(abs(left) / WHEEL_MPS, abs(right) / WHEEL_MPS, 1.0)
        self._wanted, self._held_s = (left / slower, right / slower), HOLD_S

    def advance(self, seconds: float) -> None:
        """Move on in steps of at most 10 ms."""
        while seconds > 1e-9:
            dt = min(0.01, seconds)
            seconds -= dt
            self._step(dt)

    def _step(self, dt: float) -> None:
        self._held_s -= dt
        wanted = self._wanted if self._held_s > 0 and not self.braked else (0.0, 0.0)
        a = 1.0 - math.exp(-dt / LAG_S)
        self._wheels = tuple(v + a * (w - v) for v, w in zip(self._wheels, wanted, strict=True))  # type: ignore[assignment]
        if max(map(abs, self._wheels)) < 1e-4:
            self._wheels = (0.0, 0.0)
        left, right = self._wheels
        self._rolled_m += max(abs(left), abs(right)) * dt
        if self._rolled_m >= 1.0:
            self._rolled_m = 0.0
            self._slips = self._random.gauss(0, SLIP), self._random.gauss(0, SLIP)
        self.odom = _moved(self.odom, (left + right) / 2 * dt, (right - left) / TRACK_M * dt)
        self.odom_speed = (left + right) / 2, (right - left) / TRACK_M
        left, right = left * (1 + self._slips[0]), right * (1 + self._slips[1])
        pose = _moved((self.x_m, self.y_m, self.yaw_rad), (left + right) / 2 * dt, (right - left) / TRACK_M * dt)
        self.bumped = self.clearance_m(pose[0], pose[1]) < 0.0
        if not self.bumped:  # it stands against what it hit, with spinning wheels
            self.x_m, self.y_m, self.yaw_rad = pose
        self.charge = max(0.0, self.charge - 2e-6 * dt)

    def clearance_m(self, x_m: float, y_m: float) -> float:
        """Free space around the hull at a place; negative inside something."""
        free = self.room_m / 2 - max(abs(x_m), abs(y_m))
        for one in self.obstacles:
            if isinstance(one, Pillar):
                free = min(free, math.hypot(x_m - one.x_m, y_m - one.y_m) - one.radius_m)
            else:
                dx = max(abs(x_m - one.x_m) - one.length_m / 2, 0.0)
                dy = max(abs(y_m - one.y_m) - one.width_m / 2, 0.0)
                free = min(free, math.hypot(dx, dy))
        return free - RADIUS_M

    def scan(self) -> list[float]:
        """`BEAMS` ranges in metres, counter-clockwise from straight ahead; infinite beyond `RANGE_MAX_M`."""
        angles = self.yaw_rad + 2 * math.pi * np.arange(BEAMS) / BEAMS
        dx, dy = np.cos(angles), np.sin(angles)
        with np.errstate(divide="ignore", invalid="ignore"):
            half = self.room_m / 2
            ranges = np.minimum((np.copysign(half, dx) - self.x_m) / dx, (np.copysign(half, dy) - self.y_m) / dy)
            for one in self.obstacles:
                x, y = one.x_m - self.x_m, one.y_m - self.y_m
                found = (
                    _to_circle(x, y, one.radius_m, dx, dy) if isinstance(one, Pillar) else _to_box(one, x, y, dx, dy)
                )
                ranges = np.fmin(ranges, found)
        ranges = ranges + self._noise.normal(0.0, RANGE_NOISE_M, BEAMS)
        seen: list[float] = np.where(ranges <= RANGE_MAX_M, np.maximum(ranges, RANGE_MIN_M), np.inf).tolist()
        return seen


def _moved(pose: tuple[float, float, float], forward_m: float, turn_rad: float) -> tuple[float, float, float]:
    x, y, yaw = pose
    middle = yaw + turn_rad / 2
    return x + forward_m * math.cos(middle), y + forward_m * math.sin(middle), yaw + turn_rad


def _to_circle(x: float, y: float, radius: float, dx: Floats, dy: Floats) -> Floats:
    """How far each ray goes until a circle around (x, y); infinite past it."""
    along = x * dx + y * dy
    beside2 = x * x + y * y - along * along
    hit = (along > 0) & (beside2 <= radius * radius)
    return np.where(hit, along - np.sqrt(np.maximum(radius * radius - beside2, 0.0)), np.inf)


def _to_box(box: Box, x: float, y: float, dx: Floats, dy: Floats) -> Floats:
    """How far each ray goes until a box around (x, y); infinite past it."""
    near_x, far_x = (x - np.copysign(box.length_m / 2, dx)) / dx, (x + np.copysign(box.length_m / 2, dx)) / dx
    near_y, far_y = (y - np.copysign(box.width_m / 2, dy)) / dy, (y + np.copysign(box.width_m / 2, dy)) / dy
    enter, leave = np.maximum(near_x, near_y), np.minimum(far_x, far_y)
    return np.where((enter > 0) & (enter <= leave), enter, np.inf)
