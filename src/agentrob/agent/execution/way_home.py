"""The way home as ordinary steps: turn, walk, turn. Pure geometry in the frame of the home."""

from __future__ import annotations

import math

from agentrob.model import Capabilities, Direction, Op, Pose, Primitive

#: Closer than this is at home, and smaller angles are not turned.
NEAR_M, NEAR_DEG = 0.08, 4.0


def way_home(pose: Pose, can: Capabilities) -> list[Primitive]:
    """Return the steps from a pose in the frame of the home to the home; none if the robot is there."""
    steps: list[Primitive] = []
    heading, distance_m = pose.yaw_rad, math.hypot(pose.x_m, pose.y_m)
    if distance_m > NEAR_M:
        towards = math.atan2(-pose.y_m, -pose.x_m)
        steps += _turn(towards - heading)
        heading = towards if steps else heading
        walks = math.ceil(distance_m / can.limits.step_m)
        steps += [Primitive(Op.MOVE, Direction.FORWARD, distance_m=round(distance_m / walks, 3))] * walks
    return steps + _turn(-heading)


def from_home(pose: Pose) -> tuple[float, float]:
    """Return the distance from home in metres, and the angle to its direction in degrees, positive to the left."""
    return math.hypot(pose.x_m, pose.y_m), _degrees(pose.yaw_rad)


def _turn(angle_rad: float) -> list[Primitive]:
    degrees = round(_degrees(angle_rad), 1)
    if abs(degrees) < NEAR_DEG:
        return []
    return [Primitive(Op.TURN, Direction.LEFT if degrees > 0 else Direction.RIGHT, degrees=abs(degrees))]


def _degrees(angle_rad: float) -> float:
    return math.degrees(math.atan2(math.sin(angle_rad), math.cos(angle_rad)))
