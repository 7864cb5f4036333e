"""Simulated sensors of the Go2: odometry with drift, IMU, ranges to obstacles, and a battery that drains.

The figures are plausible, not measured: white noise of 2 mm and 0.2° on the odometry, and a scale error of 0.3 % (one
standard deviation, drawn per run) on path and turning.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from agentrob.sim.world import room
from agentrob.sim.world.legged import Array, Legged
from agentrob.sim.world.world import FIRST_ROBOT_GROUP, MOST_ROBOTS

POSITION_NOISE_M, YAW_NOISE_RAD = 0.002, math.radians(0.2)
SCALE_ERROR = 0.003
GYRO_NOISE_RPS, ACCELERATION_NOISE_MPS2, VELOCITY_NOISE_MPS = 0.005, 0.05, 0.01
GRAVITY_MPS2 = 9.81

RANGE_LIMIT_M = 5.0  # the reading if nothing is nearer
RANGE_NOISE_M = 0.004
NOSE_M, SIDE_M = 0.34, 0.16  # from the body's middle to its outline; ranges count from the outline
RAY_HEIGHTS_M = (0.12, 0.28)  # they hit a ball but pass below a table top
FAN_RAD: Array = np.radians(np.linspace(-24.0, 24.0, 9))
SIDES_RAD: Array = np.radians([0.0, 90.0, 180.0, 270.0])  # front, left, back, right


def wrap(angle_rad: float) -> float:
    """The same angle within ±π."""
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi


class Odometry:
    """Dead reckoning since the last reset: (x, y) in m and yaw in rad, with the robot's error."""

    def __init__(self, body: Legged, rng: np.random.Generator, noisy: bool) -> None:
        self._body = body
        self._rng = rng
        self._noisy = noisy
        scale = SCALE_ERROR if noisy else 0.0
        self._path_scale, self._turn_scale = 1 + rng.normal(0, scale), 1 + rng.normal(0, scale)
        self.reset()

    def reset(self) -> None:
        """Set the current pose as the origin."""
        self._true_xy, self._true_yaw = self._body.xy_m, self._body.yaw_rad
        self._x = self._y = self._yaw = 0.0

    def jump(self, forward_m: float, left_m: float) -> None:
        """Inject a fault: shift the position from now on."""
        c, s = math.cos(self._yaw), math.sin(self._yaw)
        self._x += c * forward_m - s * left_m
        self._y += s * forward_m + c * left_m

    def update(self) -> None:
        """Once per period."""
        xy, yaw = self._body.xy_m, self._body.yaw_rad
        dx, dy = (xy - self._true_xy) * self._path_scale
        turn = self._yaw - self._true_yaw
        c, s = math.cos(turn), math.sin(turn)
        self._x += c * dx - s * dy
        self._y += s * dx + c * dy
        self._yaw = wrap(self._yaw + wrap(yaw - self._true_yaw) * self._turn_scale)
        self._true_xy, self._true_yaw = xy, yaw

    def read(self) -> tuple[float, float, float]:
        """x, y (m) and yaw (rad) with white noise."""
        if not self._noisy:
            return self._x, self._y, self._yaw
        ex, ey = self._rng.normal(0, POSITION_NOISE_M, 2)
        return self._x + ex, self._y + ey, wrap(self._yaw + self._rng.normal(0, YAW_NOISE_RAD))


class Ranges:
    """Distances from the robot's outline to the nearest thing in front, left, back and right, in metres.

    Each is the nearest hit of a fan of rays ±24° wide at two heights, measured along that side's axis; what is higher
    than 0.28 m or in the gaps between the fans is not seen. 5 m means nothing within 5 m.
    """

    def __init__(self, body: Legged, rng: np.random.Generator, noisy: bool) -> None:
        self._body = body
        self._rng = rng
        self._noise = RANGE_NOISE_M if noisy else 0.0
        own = int(body.model.geom_group[np.flatnonzero(body.geoms)].max())
        self._groups = np.zeros(6, np.uint8)
        self._groups[[room.ROOM_GROUP, room.NEAR_WALL_GROUP]] = 1
        self._groups[FIRST_ROBOT_GROUP : FIRST_ROBOT_GROUP + MOST_ROBOTS] = 1
        self._groups[own] = 0
        self._outline = np.array([NOSE_M, SIDE_M, NOSE_M, SIDE_M])
        self._hits = np.zeros(len(SIDES_RAD) * len(FAN_RAD), np.int32)
        self._distances = np.zeros(len(self._hits))

    def read(self) -> Array:
        """(4,) front, left, back, right."""
        angles = (self._body.yaw_rad + SIDES_RAD[:, None] + FAN_RAD[None, :]).ravel()
        rays = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1).ravel()
        x, y = self._body.xy_m
        nearest = np.full(4, RANGE_LIMIT_M)
        for height in RAY_HEIGHTS_M:
            along = self._cast(np.array([x, y, height]), rays)
            nearest = np.minimum(nearest, along.min(axis=1) - self._outline)
        noisy = nearest + self._rng.normal(0, self._noise, 4) if self._noise else nearest
        return np.asarray(
            np.maximum(noisy, 0.01)
        )  # noisy at the limit too: a reading that never changes is a dead sensor

    def _cast(self, origin: Array, rays: Array) -> Array:
        body = self._body
        reach = RANGE_LIMIT_M + NOSE_M + 1.0
        mujoco.mj_multiRay(
            body.model, body.data, origin, rays, self._groups, True, -1,
            self._hits, self._distances, None, len(self._hits), reach,
        )  # fmt: skip
        distances = np.where(self._distances < 0, np.inf, self._distances).reshape(len(SIDES_RAD), -1)
        return np.asarray(distances * np.cos(FAN_RAD))


class Inertia:
    """The inertial unit: angular velocity (rad/s) and acceleration (m/s², gravity included) in the body's frame."""

    def __init__(self, body: Legged, rng: np.random.Generator, noisy: bool) -> None:
        self._body = body
        self._rng = rng
        self._noisy = 1.0 if noisy else 0.0

    def gyro_rps(self) -> Array:
        return self._body.gyro_rps + self._noisy * self._rng.normal(0, GYRO_NOISE_RPS, 3)

    def acceleration_mps2(self) -> Array:
        body = self._body
        felt = np.array(body.data.qacc[body.root_v : body.root_v + 3])
        felt[2] += GRAVITY_MPS2
        return np.asarray(body.rotation.T @ felt + self._noisy * self._rng.normal(0, ACCELERATION_NOISE_MPS2, 3))

    def tilt_rad(self) -> tuple[float, float]:
        """Roll and pitch."""
        r = self._body.rotation
        return math.atan2(r[2, 1], r[2, 2]), -math.asin(max(-1.0, min(1.0, float(r[2, 0]))))


class Battery:
    """Charge that drains with time and with mechanical work. It is never charged; `exchange` replaces a drained one."""

    CAPACITY_WH, FULL_V, EMPTY_V = 236.0, 32.0, 26.0
    IDLE_W, EFFICIENCY = 70.0, 0.35  # electronics and holding; mechanical work per electrical work
    FRESH_PERCENT, EXCHANGED_PERCENT = 87.0, 25.0  # a world that runs for days must not end with an empty robot

    def __init__(self, percent: float = FRESH_PERCENT) -> None:
        self.percent = percent
        self.power_w = self.IDLE_W

    def drain(self, mechanical_w: float, seconds: float) -> None:
        self.power_w = self.IDLE_W + mechanical_w / self.EFFICIENCY
        self.percent = max(0.0, self.percent - 100 * self.power_w * seconds / 3600 / self.CAPACITY_WH)

    def exchange(self) -> None:
        """Replace the battery if it is nearly drained."""
        if self.percent < self.EXCHANGED_PERCENT:
            self.percent = self.FRESH_PERCENT

    @property
    def volts(self) -> float:
        return self.EMPTY_V + (self.FULL_V - self.EMPTY_V) * self.percent / 100


def foot_forces_n(body: Legged, feet: tuple[str, ...]) -> list[int]:
    """Normal force on each named foot, in N."""
    ids = {int(body.model.geom(f"{body.name}/{foot}").id): k for k, foot in enumerate(feet)}
    total = [0.0] * len(feet)
    force = np.zeros(6)
    pairs: Any = body.data.contact.geom
    for c, pair in enumerate(pairs):
        for geom in pair:
            if int(geom) in ids:
                mujoco.mj_contactForce(body.model, body.data, c, force)
                total[ids[int(geom)]] += float(force[0])
    return [round(f) for f in total]
