"""Does the odometry go on from where it was, and does anybody else move the robot? Pure: fed with states in order."""

from __future__ import annotations

import math

from agentrob.model import Op, Pose, RobotState
from agentrob.robots.control.controller import wrap

#: Between two looks a pose may change by slack + speed x time; more is a jump.
SLACK_M, PLAUSIBLE_MPS = 0.25, 2.0
SLACK_RAD, PLAUSIBLE_RPS = 0.4, 3.0
#: After so long without state the robot may have been restarted, with its odometry at zero by chance where it was.
REBOOT_GAP_S = 10.0
#: A look is not counted for longer than this when judging a jump.
LOOK_S = 1.0
#: The body counts as still when it kept its place for this long.
STILL_S = 0.3


class Odometry:
    """`see` each state; `still` says whether the robot has kept its place for a moment."""

    def __init__(self, time_scale: float = 1.0) -> None:
        """`time_scale`: how much faster than life a fake robot goes; where its steps take no time, 1."""
        self._time_scale = time_scale if math.isfinite(time_scale) else 1.0
        self._last: tuple[float, Pose] | None = None
        self._came_s: float | None = None  # when the newest state came
        self._anchor: tuple[float, Pose] | None = None

    def see(self, now_s: float, state: RobotState) -> str | None:
        """A sentence when the odometry cannot be trusted to go on from where it was."""
        if state.pose is None or state.age_s > REBOOT_GAP_S:
            return None
        came_s = now_s - state.age_s
        silent_s = 0.0 if self._came_s is None else came_s - self._came_s
        self._came_s = came_s
        last, self._last = self._last, (now_s, state.pose)
        if self._anchor is None or not _same_place(self._anchor[1], state.pose):
            self._anchor = self._last
        if last is None:
            return None
        if silent_s > REBOOT_GAP_S:
            return f"no state came for {silent_s:.0f} s, and the robot may have been restarted"
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


WALKS = (Op.MOVE, Op.TURN)
#: Limp: only an operator or the robot's own hardware stop does that; no step of ours ever does.
DAMPING = "damping"
#: Modes into which a robot does not go by itself while we do nothing.
FOREIGN_MODES = frozenset({DAMPING, "locked", "lying", "sitting", "gesture"})
#: Our own step may show in mode and speed for so long after it ended.
OURS_S = 3.0
#: Faster than this for `MOVED_S` without a step of ours is somebody else's hand.
MOVED_MPS, MOVED_S = 0.2, 0.5
#: A walk that a killed driver left behind is stopped at once and has died down after so long.
DECAY_S = 2.0
#: A gesture that it left behind may go on for so long; these are the modes that it shows or ends in.
GESTURE_S = 10.0
GESTURE_MODES = {Op.SIT: frozenset({"gesture", "sitting"}), Op.STAND: frozenset({"gesture", "locked"})}


class Hands:
    """Notices an operator's remote, another program or a hardware stop (law 12)."""

    def __init__(self) -> None:
        self._mode, self._ours_until_s, self._slow_s = "", -math.inf, -math.inf
        self._decays_until_s = self._gesture_until_s = -math.inf
        self._gesture_modes: frozenset[str] = frozenset()

    def ours(self, now_s: float) -> None:
        """We move the robot, now."""
        self._ours_until_s = now_s + OURS_S

    def inherit(self, now_s: float, op: Op, mode: str) -> None:
        """A driver before us died in a step, and saw the robot in `mode` last: motion that dies down is ours.

        A mode that the step does not lead to is a foreign hand as ever, and so is damping.
        """
        self._mode, self._decays_until_s = mode, now_s + DECAY_S
        if op not in WALKS:
            self._gesture_until_s = now_s + GESTURE_S
            self._gesture_modes = GESTURE_MODES.get(op, frozenset({"gesture"}))

    def see(self, now_s: float, state: RobotState, *, walking: bool, gesturing: bool) -> str | None:
        """A sentence when somebody else changed what the robot does."""
        if not math.isfinite(state.age_s):
            return None  # no state ever came
        before, self._mode = self._mode, state.mode
        if walking or gesturing:
            self.ours(now_s)
        ours = now_s < self._ours_until_s
        changed = bool(before) and state.mode != before and state.mode in FOREIGN_MODES
        damped = bool(before) and state.mode != before and state.mode == DAMPING  # never ours, whatever we do meanwhile
        inherited = now_s < self._gesture_until_s and state.mode in self._gesture_modes
        if damped or (changed and (walking or not ours) and not (gesturing or inherited)):
            return f"the robot went from {before} to {state.mode}, which we did not command"
        speed_mps = math.hypot(*state.velocity_mps) if state.velocity_mps else 0.0
        if ours or now_s < self._decays_until_s or speed_mps < MOVED_MPS or state.age_s > MOVED_S:
            self._slow_s = now_s
        elif now_s - self._slow_s > MOVED_S:
            self._slow_s = now_s
            return f"the robot moves at {speed_mps:.2f} m/s, which we did not command"
        return None
