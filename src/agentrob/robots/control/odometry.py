"""Detects jumps of the odometry, and whether the robot stands still. Pure: feed it states in order."""

from __future__ import annotations

import math

from agentrob.model import Pose, RobotState
from agentrob.robots.control.controller import wrap

#: Between two states a pose may change by slack + speed x time; more is a jump.
SLACK_M, PLAUSIBLE_MPS = 0.25, 2.0
SLACK_RAD, PLAUSIBLE_RPS = 0.4, 3.0
#: After this long without state the robot may have been restarted, with its odometry back at zero.
REBOOT_GAP_S = 10.0
#: Upper bound of the time between two states when checking for a jump.
LOOK_S = 1.0
#: The body counts as still once it has stayed in place this long.
STILL_S = 0.3


class OdometryMonitor:
    """Call `update` with each state; `still` tells whether the robot has stayed in place for a moment."""

    def __init__(self, time_scale: float = 1.0) -> None:
        """`time_scale` is how much faster than real time a fake robot runs; 1 if its steps take no time."""
        self._time_scale = time_scale if math.isfinite(time_scale) else 1.0
        self._last: tuple[float, Pose] | None = None
        self._came_s: float | None = None  # when the newest state came
        self._anchor: tuple[float, Pose] | None = None

    def update(self, now_s: float, state: RobotState, asked_s: float | None = None) -> str | None:
        """Return why the odometry can no longer be trusted, or None.

        `asked_s` is when the state was asked for: on a busy machine a thread may rest between asking and `now_s`, and
        the state is of some moment between the two.
        """
        if state.pose is None or state.age_s > REBOOT_GAP_S:
            return None
        came_s = now_s - state.age_s
        silent_s = 0.0 if self._came_s is None else came_s - self._came_s
        self._came_s = came_s
        last, self._last = self._last, (now_s if asked_s is None else asked_s, state.pose)
        if self._anchor is None or not _same_place(self._anchor[1], state.pose):
            self._anchor = now_s, state.pose
        if last is None:
            return None
        if silent_s > REBOOT_GAP_S:
            return f"no state was received for {silent_s:.0f} s, and the robot may have been restarted"
        distance_m, angle_rad = _apart(last[1], state.pose)
        dt = min(now_s - last[0], LOOK_S) * self._time_scale
        if distance_m > SLACK_M + PLAUSIBLE_MPS * dt or angle_rad > SLACK_RAD + PLAUSIBLE_RPS * dt:
            return f"its odometry jumped by {distance_m:.2f} m and {math.degrees(angle_rad):.0f}°"
        return None

    def still(self, now_s: float) -> bool:
        return self._anchor is not None and now_s - self._anchor[0] >= STILL_S


def _apart(a: Pose, b: Pose) -> tuple[float, float]:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m), abs(wrap(a.yaw_rad - b.yaw_rad))


def _same_place(a: Pose, b: Pose) -> bool:
    distance_m, angle_rad = _apart(a, b)
    return distance_m < 0.02 and angle_rad < 0.05
