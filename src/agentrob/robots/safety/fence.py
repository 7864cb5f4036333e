"""The fence: a rectangle around the owner's home pose that every move must stay inside. Pure geometry."""

from __future__ import annotations

import math

from agentrob.config.robots import FenceConfig
from agentrob.model import Op, Pose, Primitive
from agentrob.robots.control.controller import rotate
from agentrob.robots.control.step_runner import unit_vector

#: A path must end this far inside: more than a step's tolerance, so that an accurate step never crosses the fence.
MARGIN_M = 0.10


class Fence:
    """`home` is a pose in the odometry frame; all points below are in metres relative to it."""

    def __init__(self, config: FenceConfig, home: Pose) -> None:
        self.config, self.home = config, home

    def at_home(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Transform an odometry point into the home frame."""
        return rotate(x_m - self.home.x_m, y_m - self.home.y_m, -self.home.yaw_rad)

    def outside_m(self, x_m: float, y_m: float) -> float:
        """Distance of an odometry point outside the fence; negative inside (distance to the nearest side).

        Infinite if a coordinate is NaN or infinite: such a point is not known to be inside.
        """
        x, y = self.at_home(x_m, y_m)
        c = self.config
        beyond = (c.x_min_m - x, x - c.x_max_m, c.y_min_m - y, y - c.y_max_m)
        return max(beyond) if all(map(math.isfinite, beyond)) else math.inf

    def refusal(self, pose: Pose, primitive: Primitive) -> str | None:
        """Return why the step may not start here, or None. The fence is convex, so checking both ends is enough."""
        if not (outside_m := self.outside_m(pose.x_m, pose.y_m)) <= 0:
            return (
                f"The robot stands {outside_m:.2f} m outside its fence; its owner must bring it back or set a new home."
            )
        if primitive.op is not Op.MOVE:
            return None
        end = ahead(pose, primitive, primitive.distance_m or 0.0)
        if not (outside_m := self.outside_m(*end) + MARGIN_M) <= 0:
            x, y = self.at_home(*end)
            c = self.config
            return (
                f"The way ends at x {x:.2f} m, y {y:.2f} m from home, {outside_m:.2f} m beyond what the fence allows "
                f"(x {c.x_min_m:g} to {c.x_max_m:g} m, y {c.y_min_m:g} to {c.y_max_m:g} m, less {MARGIN_M:g} m)."
            )
        return None


def ahead(pose: Pose, primitive: Primitive, distance_m: float) -> tuple[float, float]:
    """The odometry point that lies `distance_m` from a pose in the direction of a move."""
    dx, dy = rotate(*unit_vector(primitive), pose.yaw_rad)
    return pose.x_m + dx * distance_m, pose.y_m + dy * distance_m


def onward(pose: Pose, velocity_mps: tuple[float, float], seconds: float) -> tuple[float, float]:
    """The odometry point that a body reaches in so many seconds at this velocity (forward, left)."""
    dx, dy = rotate(*velocity_mps, pose.yaw_rad)
    return pose.x_m + dx * seconds, pose.y_m + dy * seconds
