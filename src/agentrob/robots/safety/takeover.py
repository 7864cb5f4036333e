"""Detects that somebody else moves the robot (law 12). Pure: feed it states in order."""

from __future__ import annotations

import math

from agentrob.model import Op, RobotState

WALKS = (Op.MOVE, Op.TURN)
#: Limp: caused by an operator or the robot's hardware stop, never by a step of ours.
DAMPING = "damping"
#: Modes into which a robot does not go by itself while we do nothing.
FOREIGN_MODES = frozenset({DAMPING, "locked", "lying", "sitting", "gesture"})
#: Our own step may show in mode and speed for this long after it ended.
OURS_S = 3.0
#: Faster than this for `MOVED_S` without a step of ours means that somebody else moves the robot.
MOVED_MPS, MOVED_S = 0.2, 0.5
#: A walk left by a killed driver is stopped at once and has ended after this long.
DECAY_S = 2.0
#: A gesture left by it may run this long; these are the modes that it shows or ends in.
GESTURE_S = 10.0
GESTURE_MODES: dict[str, frozenset[str]] = {
    Op.SIT: frozenset({"gesture", "sitting"}),
    Op.STAND: frozenset({"gesture", "locked"}),
}


class TakeoverDetector:
    """Detects an operator's remote, another program or a hardware stop (law 12)."""

    def __init__(self) -> None:
        self._mode, self._ours_until_s, self._slow_s = "", -math.inf, -math.inf
        self._decays_until_s = self._gesture_until_s = -math.inf
        self._gesture_modes: frozenset[str] = frozenset()

    def own_motion(self, now_s: float) -> None:
        """Record that we are moving the robot now."""
        self._ours_until_s = now_s + OURS_S

    def inherit(self, now_s: float, op: str, mode: str) -> None:
        """Continue after a driver that died during `op` with the robot in `mode`: motion that decays counts as ours.

        Damping, and modes that the step does not lead to, still count as a takeover.
        """
        self._mode, self._decays_until_s = mode, now_s + DECAY_S
        if op not in WALKS:
            self._gesture_until_s = now_s + GESTURE_S
            self._gesture_modes = GESTURE_MODES.get(op, frozenset({"gesture"}))

    def update(self, now_s: float, state: RobotState, *, walking: bool, gesturing: bool) -> str | None:
        """Return what somebody else did to the robot, or None."""
        if not math.isfinite(state.age_s):
            return None  # no state ever came
        before, self._mode = self._mode, state.mode
        if walking or gesturing:
            self.own_motion(now_s)
        ours = now_s < self._ours_until_s
        changed = bool(before) and state.mode != before and state.mode in FOREIGN_MODES
        damped = bool(before) and state.mode != before and state.mode == DAMPING  # never ours, whatever we do meanwhile
        inherited = now_s < self._gesture_until_s and state.mode in self._gesture_modes
        if damped or (changed and (walking or not ours) and not inherited):
            return f"the robot went from {before} to {state.mode}, which we did not command"
        speed_mps = math.hypot(*state.velocity_mps) if state.velocity_mps else 0.0
        if ours or now_s < self._decays_until_s or speed_mps < MOVED_MPS or state.age_s > MOVED_S:
            self._slow_s = now_s
        elif now_s - self._slow_s > MOVED_S:
            self._slow_s = now_s
            return f"the robot moves at {speed_mps:.2f} m/s, which we did not command"
        return None
