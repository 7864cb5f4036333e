"""Read pose, attitude, ranges and charge from ROS 2 messages. Pure; implausible values are unknown.

Each function returns its value and a sentence on what is wrong with the message, which is empty if nothing is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from agentrob.model import Pose
from agentrob.robots.protocol import BODY_RADIUS_M
from agentrob.robots.safety.ranges import HULL_M
from agentrob_ros2.messages import BatteryState, LaserScan, Quaternion, Transform
from agentrob_ros2.options import BodyOptions, ScanOptions

#: A quaternion is one if its length differs from 1 by at most this.
UNIT_SLACK = 0.02
#: A base that is tilted by more than this has tipped over or is being carried.
UPRIGHT = math.cos(math.radians(35))
#: Longer ranges are not metres.
LONGEST_M = 300.0
#: Things that close to the outline count as in its way.
BESIDE_M = 0.05
#: A side is known only if at least this share of the beams towards it gave an answer.
ANSWERED = 0.5
#: The beams that must answer lie within this angle of the side.
CONE_RAD = math.radians(30)

Ranges = tuple[float | None, float | None, float | None, float | None]
UNKNOWN: Ranges = (None, None, None, None)


class Mount(NamedTuple):
    """Where a sensor sits on the base: forward and left in metres, its direction, and whether it hangs upside down."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    upside_down: bool = False


# ------------------------------------------------------------------ attitude and position
def is_rotation(q: Quaternion) -> bool:
    length = math.sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)
    return math.isfinite(length) and abs(length - 1.0) <= UNIT_SLACK


def yaw_of(q: Quaternion) -> float:
    """The heading in radians, counter-clockwise."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def upright_of(q: Quaternion) -> bool | None:
    """Whether the base stands on its wheels; None if this is no attitude."""
    return 1.0 - 2.0 * (q.x * q.x + q.y * q.y) > UPRIGHT if is_rotation(q) else None


def pose_of(x_m: float, y_m: float, q: Quaternion) -> tuple[Pose | None, str]:
    if not (math.isfinite(x_m) and math.isfinite(y_m)):
        return None, "its position is not a number"
    if not is_rotation(q):
        return None, "its orientation is not a unit quaternion"
    return Pose(x_m, y_m, yaw_of(q)), ""


# ------------------------------------------------------------------ transforms
class StaticTransforms:
    """The tree of `/tf_static`: where sensors sit on the base."""

    def __init__(self) -> None:
        self._edges: dict[str, dict[str, np.ndarray]] = {}

    def add(self, parent: str, child: str, transform: Transform) -> None:
        if not is_rotation(transform.rotation):
            return
        matrix = _matrix(transform)
        parent, child = parent.lstrip("/"), child.lstrip("/")
        self._edges.setdefault(parent, {})[child] = matrix
        self._edges.setdefault(child, {})[parent] = np.linalg.inv(matrix)

    def mount(self, base: str, sensor: str) -> Mount | None:
        """Where `sensor` is seen from `base`; None if no chain of transforms connects them, or if it is tilted."""
        base, sensor = base.lstrip("/"), sensor.lstrip("/")
        found, queue = {base: np.eye(4)}, [base]
        while queue and sensor not in found:
            here = queue.pop(0)
            for there, matrix in self._edges.get(here, {}).items():
                if there not in found:
                    found[there] = found[here] @ matrix
                    queue.append(there)
        if sensor not in found or abs((matrix := found[sensor])[2, 2]) < math.cos(math.radians(10)):
            return None
        upside_down = bool(matrix[2, 2] < 0)
        yaw = math.atan2(matrix[1, 0], matrix[0, 0])
        return Mount(float(matrix[0, 3]), float(matrix[1, 3]), yaw, upside_down)


def _matrix(transform: Transform) -> np.ndarray:
    q, at = transform.rotation, transform.translation
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), at.x],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), at.y],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), at.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def mount_of(options: ScanOptions) -> Mount | None:
    """The mount of the configuration; None if it is left to `/tf_static`."""
    if options.mount_m is None:
        return None
    return Mount(*options.mount_m, math.radians(options.mount_deg), options.upside_down)


# ------------------------------------------------------------------ ranges
def ranges_of(scan: LaserScan, mount: Mount, body: BodyOptions) -> tuple[Ranges, str]:
    """The free distance to the front, left, back and right in metres, as the guard takes it: from the middle of a body
    of its own size (`HULL_M`, `BODY_RADIUS_M`).

    A side is the strip as wide as the base, so that a thing half in the way counts. For a base that is larger than the
    guard's body the readings are shortened, so that its margins hold from this base's outline. A side on which nothing
    answers, or from which too few beams answered, is unknown (law 8): so are glass, black walls and great halls.
    """
    if wrong := _implausible(scan):
        return UNKNOWN, wrong
    ranges = np.asarray(scan.ranges, dtype=float)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    angles = mount.yaw_rad + (-angles if mount.upside_down else angles)
    ranges = np.where(np.isneginf(ranges), scan.range_min, ranges)  # REP 117: too near to be measured
    answered = np.isposinf(ranges) | (np.isfinite(ranges) & (ranges > 0.0))
    seen = np.isfinite(ranges) & (ranges > 0.0) & (ranges <= scan.range_max)
    x = mount.x_m + np.where(seen, ranges, 0.0) * np.cos(angles)
    y = mount.y_m + np.where(seen, ranges, 0.0) * np.sin(angles)
    half_length, half_width = body.length_m / 2, body.width_m / 2
    seen &= ~((np.abs(x) < half_length) & (np.abs(y) < half_width))  # parts of the base itself
    grown = larger_m(body)
    sides: list[float | None] = []
    for side, (along, across, half) in enumerate(((x, y, half_width), (y, x, half_length)) * 2):
        sign = 1.0 if side < 2 else -1.0
        strip = seen & (sign * along > 0.0) & (np.abs(across) <= half + BESIDE_M)
        off = np.abs((angles - side * math.pi / 2 + math.pi) % (2 * math.pi) - math.pi)
        cone = off <= CONE_RAD
        known = strip.any() and cone.any() and answered[cone].mean() >= ANSWERED
        sides.append(max(0.01, float((sign * along)[strip].min()) - grown) if known else None)
    front, left, back, right = sides
    return (front, left, back, right), ""


def larger_m(body: BodyOptions) -> float:
    """By how much this base reaches further than the body that the guard's margins are made for, at most."""
    half_length, half_width = body.length_m / 2, body.width_m / 2
    radius = math.hypot(half_length, half_width)
    return max(0.0, half_length - HULL_M[0], half_width - HULL_M[1], radius - BODY_RADIUS_M)


def _implausible(scan: LaserScan) -> str:
    numbers = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
    if not all(map(math.isfinite, numbers)) or len(scan.ranges) < 2:
        return "it has no beams, or its angles or bounds are not numbers"
    if abs(scan.angle_increment) * (len(scan.ranges) - 1) > 2 * math.pi + 0.2:
        return "its angles cover more than a full turn: are they degrees? ROS wants radians"
    if not 0.0 < scan.range_max <= LONGEST_M:
        return f"its range_max is {scan.range_max:g}: is that millimetres? ROS wants metres"
    if _longest(scan.ranges) > 2 * scan.range_max:
        return f"it has ranges far beyond its own range_max of {scan.range_max:g} m: are they millimetres?"
    return ""


def _longest(ranges: Sequence[float]) -> float:
    values = np.asarray(ranges, dtype=float)
    values = values[np.isfinite(values)]
    return float(values.max()) if len(values) else 0.0


# ------------------------------------------------------------------ charge
def percent_of(battery: BatteryState) -> tuple[float | None, str]:
    """The charge in percent. ROS tells it from 0 to 1; a driver that tells percent is not believed."""
    share = float(battery.percentage)
    if not battery.present or math.isnan(share):
        return None, ""
    if not 0.0 <= share <= 1.0:
        return None, f"its percentage is {share:g}, and ROS wants 0 to 1: the charge counts as unknown"
    return 100.0 * share, ""
