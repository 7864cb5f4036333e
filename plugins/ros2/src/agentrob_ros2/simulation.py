"""A simulated base as its ROS topics show it: samples of odometry, scan and battery, and faults on purpose.

It needs numpy alone. `simulator.py` publishes the samples with Cyclone DDS, the tests' peer with rclpy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from agentrob_ros2.simulated_base import (
    BEAMS,
    RANGE_MAX_M,
    RANGE_MIN_M,
    Box,
    Pillar,
    SimulatedBase,
)

ODOM_HZ, SCAN_HZ, BATTERY_HZ = 50.0, 10.0, 1.0
ODOM, SCAN, BATTERY = "odom", "scan", "battery"


class OdomSample(NamedTuple):
    """Metres and radians in the odometry frame, m/s and rad/s of the base."""

    stamp_s: float
    x_m: float
    y_m: float
    quaternion: tuple[float, float, float, float]  # x, y, z, w
    forward_mps: float
    turn_rps: float


class ScanSample(NamedTuple):
    stamp_s: float
    increment_rad: float
    range_min: float
    range_max: float
    ranges: list[float]


class BatterySample(NamedTuple):
    stamp_s: float
    percentage: float


Sample = OdomSample | ScanSample | BatterySample


@dataclass(slots=True)
class Faults:
    """Injected faults. `muted`: topics that are not published. `frozen`: topics that repeat their last
    message. `units`: `mm` (positions and ranges), `degrees` (angles of the scan), `percent` (battery). `dead_scan`:
    every beam says 0. `tipped`: it lies on its side."""

    muted: set[str] = field(default_factory=set)
    frozen: set[str] = field(default_factory=set)
    units: str = ""
    dead_scan: bool = False
    tipped: bool = False


class Simulation:
    """Call `tick` with the seconds that passed; it returns the samples that are due."""

    def __init__(self, start_s: float = 0.0, seed: int = 7) -> None:
        self.base, self.faults, self.now_s = SimulatedBase(seed=seed), Faults(), start_s
        self._due = {ODOM: start_s, SCAN: start_s, BATTERY: start_s}
        self._last: dict[str, Sample] = {}
        self._jump_m = 0.0

    def tick(self, seconds: float) -> dict[str, Sample]:
        self.base.advance(seconds)
        self.now_s += seconds
        found: dict[str, Sample] = {}
        for topic, hertz, make in (
            (ODOM, ODOM_HZ, self._odom),
            (SCAN, SCAN_HZ, self._scan),
            (BATTERY, BATTERY_HZ, self._battery),
        ):
            if self.now_s + 1e-9 < self._due[topic]:
                continue
            self._due[topic] = max(self._due[topic] + 1 / hertz, self.now_s)
            if not (topic in self.faults.frozen and topic in self._last):
                self._last[topic] = make()
            if topic not in self.faults.muted:
                found[topic] = self._last[topic]
        return found

    def apply(self, what: dict[str, Any]) -> dict[str, Any]:
        """Change faults, obstacles or odometry; return the true state of the base."""
        base, faults = self.base, self.faults
        for topic_set in ("muted", "frozen"):
            if topic_set in what:
                setattr(faults, topic_set, set(what[topic_set]))
        for name in ("units", "dead_scan", "tipped"):
            if name in what:
                setattr(faults, name, what[name])
        if "braked" in what:
            base.braked = bool(what["braked"])
        if "charge" in what:
            base.charge = float(what["charge"])
        if "box" in what:  # [x, y, length, width]
            base.obstacles.append(Box(*what["box"]))
        if "pillar" in what:  # [x, y, radius]
            base.obstacles.append(Pillar(*what["pillar"]))
        if "clear" in what:
            base.obstacles.clear()
        if "jump_m" in what:
            self._jump_m += float(what["jump_m"])
        if "pose" in what:  # where it is put, with its odometry unchanged
            base.x_m, base.y_m, base.yaw_rad = what["pose"]
        return {
            "x_m": base.x_m, "y_m": base.y_m, "yaw_rad": base.yaw_rad, "odom": base.odom, "now_s": self.now_s,
            "clearance_m": base.clearance_m(base.x_m, base.y_m), "bumped": base.bumped,
        }  # fmt: skip

    def _odom(self) -> OdomSample:
        x, y, yaw = self.base.odom
        scale = 1000.0 if self.faults.units == "mm" else 1.0
        half = yaw / 2
        upright = (0.0, 0.0, math.sin(half), math.cos(half))
        quaternion = (math.sin(math.pi / 4), 0.0, 0.0, math.cos(math.pi / 4)) if self.faults.tipped else upright
        return OdomSample(self.now_s, scale * (x + self._jump_m), scale * y, quaternion, *self.base.odom_speed)

    def _scan(self) -> ScanSample:
        increment, scale = 2 * math.pi / BEAMS, 1000.0 if self.faults.units == "mm" else 1.0
        if self.faults.units == "degrees":
            increment = math.degrees(increment)
        ranges = [0.0] * BEAMS if self.faults.dead_scan else [scale * r for r in self.base.scan()]
        return ScanSample(self.now_s, increment, scale * RANGE_MIN_M, scale * RANGE_MAX_M, ranges)

    def _battery(self) -> BatterySample:
        return BatterySample(self.now_s, self.base.charge * (100.0 if self.faults.units == "percent" else 1.0))
