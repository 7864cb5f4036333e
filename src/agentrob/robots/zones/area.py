"""The floor that a robot needs: capsules in the frame of its room. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from agentrob.model import Op, Pose, Primitive
from agentrob.robots.control.controller import rotate, wrap
from agentrob.robots.control.step_runner import unit_vector
from agentrob.robots.protocol import BODY_RADIUS_M

#: Kept free between the areas of two robots, each of which includes its own errors.
MARGIN_M = 0.20
#: Kept free to a robot that stands, of which the guard also keeps its distance by the measured poses.
STANDING_MARGIN_M = 0.05
#: A robot leaves its predicted path by at most this: a step's tolerance, and the sway of its gait.
PATH_M = 0.08
#: What is covered may stick out by this much: the odometry of a robot that stands is noisy.
NOISE_M = 0.03
#: A step may end this far from where it should, …
STEP_M = 0.05
#: … and 4° off, so that what follows lies aside by this share of its length.
HEADING_SHARE = 0.07
#: From the middle of a robot to what a gesture moves: an arm stretched out, a body that sits back on its hind legs.
#: In the simulator a Go2's reaches 0.62 m and a G1's 0.61 m, from where the robot stood before.
GESTURE_RADIUS_M = 0.65
#: Operations in place that keep within the standing robot's own outline.
_QUIET = frozenset({Op.TURN, Op.SIT, Op.STAND})


class Capsule(NamedTuple):
    """All points within `radius_m` of a segment; a disc if its ends coincide."""

    x0_m: float
    y0_m: float
    x1_m: float
    y1_m: float
    radius_m: float


#: Capsules that together cover a path; None is the whole room.
Area = tuple[Capsule, ...] | None


def at_m(pose: Pose) -> tuple[float, float]:
    return pose.x_m, pose.y_m


def disc(pose: Pose, radius_m: float) -> Capsule:
    return Capsule(pose.x_m, pose.y_m, pose.x_m, pose.y_m, radius_m)


def body(pose: Pose, error_m: float) -> Capsule:
    """A robot that stands; `error_m` is by how much its pose in the room may be wrong."""
    return disc(pose, BODY_RADIUS_M + error_m)


def swept(pose: Pose, steps: Sequence[Primitive], error_m: float) -> tuple[Capsule, ...]:
    """The area of steps from a pose in the room, each predicted to end as asked.

    The path widens with every step, because none is exact.
    """
    at, behind_m, off_m = pose, 0.0, 0.0
    found: list[Capsule] = []
    for step in steps:
        if not step.moves:
            continue
        if step.op is Op.MOVE:
            distance_m = step.distance_m or 0.0
            behind_m += distance_m if found else 0.0  # the heading of the first step is known
            end = _after_move(at, step)
            found.append(
                Capsule(*at_m(at), *at_m(end), BODY_RADIUS_M + PATH_M + error_m + off_m + HEADING_SHARE * behind_m)
            )
            at, off_m = end, off_m + STEP_M
            continue
        radius_m, travel_m = BODY_RADIUS_M, 0.0
        if step.op not in _QUIET:
            does = step.operation  # what robots declare ends somewhere within its travel; built-in gestures in place
            travel_m = (does.travel_m or 0.0) if isinstance(step.op, Op) else does.most_travel_m
            radius_m = max(GESTURE_RADIUS_M, does.free_space_m) + travel_m
        sway_m = PATH_M if radius_m < GESTURE_RADIUS_M else 0.0  # of gestures it is in the radius
        found.append(disc(at, radius_m + sway_m + error_m + off_m + HEADING_SHARE * behind_m))
        off_m += travel_m + STEP_M
        if step.op is Op.TURN:
            sign = -1.0 if step.direction == "right" else 1.0
            at = Pose(at.x_m, at.y_m, wrap(at.yaw_rad + sign * math.radians(step.degrees or 0.0)))
    return tuple(found) or (body(pose, error_m),)


def _after_move(at: Pose, step: Primitive) -> Pose:
    x, y = unit_vector(step)
    dx, dy = rotate(x * (step.distance_m or 0.0), y * (step.distance_m or 0.0), at.yaw_rad)
    return Pose(at.x_m + dx, at.y_m + dy, at.yaw_rad)


def gap_m(one: Sequence[Capsule], other: Sequence[Capsule]) -> float:
    """The distance between two areas; negative where they overlap, infinite if one is empty."""
    return min((_gap_m(a, b) for a in one for b in other), default=math.inf)


def conflict(one: Area, other: Area) -> bool:
    """Whether two areas are nearer than `MARGIN_M`. The whole room conflicts with everything."""
    return one is None or other is None or not gap_m(one, other) >= MARGIN_M


def covers(area: Area, part: Area) -> bool:
    """Whether each capsule of `part` lies within one capsule of `area` (sufficient, not necessary)."""
    if area is None or part is None:
        return area is None
    return all(any(_within(small, large) for large in area) for small in part)


def _within(small: Capsule, large: Capsule) -> bool:
    room_m = large.radius_m - small.radius_m + NOISE_M
    line = large[:4]
    return max(_point_m(small[0], small[1], *line), _point_m(small[2], small[3], *line)) <= room_m


def _gap_m(a: Capsule, b: Capsule) -> float:
    return _segments_m(a, b) - a.radius_m - b.radius_m


def _segments_m(a: Capsule, b: Capsule) -> float:
    """The distance between two segments: zero where they cross, else one of their ends is nearest."""
    if _cross(a, b):
        return 0.0
    return min(
        _point_m(a.x0_m, a.y0_m, *b[:4]),
        _point_m(a.x1_m, a.y1_m, *b[:4]),
        _point_m(b.x0_m, b.y0_m, *a[:4]),
        _point_m(b.x1_m, b.y1_m, *a[:4]),
    )


def _cross(a: Capsule, b: Capsule) -> bool:
    def side(c: Capsule, x: float, y: float) -> float:
        return (c.x1_m - c.x0_m) * (y - c.y0_m) - (c.y1_m - c.y0_m) * (x - c.x0_m)

    return (
        side(a, b.x0_m, b.y0_m) * side(a, b.x1_m, b.y1_m) < 0 and side(b, a.x0_m, a.y0_m) * side(b, a.x1_m, a.y1_m) < 0
    )


def _point_m(x: float, y: float, x0: float, y0: float, x1: float, y1: float) -> float:
    """From a point to a segment."""
    dx, dy = x1 - x0, y1 - y0
    length2 = dx * dx + dy * dy
    share = 0.0 if length2 == 0.0 else min(1.0, max(0.0, ((x - x0) * dx + (y - y0) * dy) / length2))
    return math.hypot(x - x0 - share * dx, y - y0 - share * dy)
