"""The speed of a base whose messages tell only where it is."""

from __future__ import annotations

from typing import NamedTuple

from agentrob.model import Pose
from agentrob.robots.control.controller import rotate, wrap

#: Speed is taken from poses that lie at least this far apart, in seconds.
SPEED_OVER_S = 0.1
#: Stamps count if they lie at most this much further apart than the arrivals, in seconds. A larger difference means
#: that the sender's clock was set.
MAX_DELAY_S = 0.5


class _Sample(NamedTuple):
    came_s: float
    stamp_s: float
    pose: Pose
    velocity: tuple[float, float, float] | None


class PoseSpeed:
    """Call `update` with each pose of the odometry.

    The stamps give the time between two poses, because messages that were delayed on a busy machine or network arrive
    close together. Without stamps that advance, it is the time between the arrivals.
    """

    def __init__(self) -> None:
        self._last: _Sample | None = None

    def update(self, came_s: float, stamp_s: float, pose: Pose | None) -> tuple[float, float, float] | None:
        """Return the speed forward and to the left in m/s, and the turning speed in rad/s; None while it is unknown.

        `came_s` is the time of arrival, `stamp_s` the time of the pose by its sender's clock (0 without a stamp), both
        in seconds. `pose` is None if the message had none that can be used.
        """
        last = self._last
        if pose is None:
            self._last = None
            return None
        if last is None:
            self._last = _Sample(came_s, stamp_s, pose, None)
            return None
        seconds = _seconds_between(last, came_s, stamp_s)
        if seconds < SPEED_OVER_S:
            return last.velocity
        forward_m, left_m = rotate(pose.x_m - last.pose.x_m, pose.y_m - last.pose.y_m, -pose.yaw_rad)
        turned_rad = wrap(pose.yaw_rad - last.pose.yaw_rad)
        velocity = forward_m / seconds, left_m / seconds, turned_rad / seconds
        self._last = _Sample(came_s, stamp_s, pose, velocity)
        return velocity


def _seconds_between(last: _Sample, came_s: float, stamp_s: float) -> float:
    arrivals_s, stamps_s = came_s - last.came_s, stamp_s - last.stamp_s
    return stamps_s if last.stamp_s > 0.0 and 0.0 < stamps_s <= arrivals_s + MAX_DELAY_S else arrivals_s
