"""Gestures of the G1's arms on top of its walking policy, which keeps balancing.

A pose is seven joints of one arm: shoulder pitch, roll and yaw, elbow, wrist roll, pitch and yaw, in rad. Both arms
are the left one's seven and then the right one's.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agentrob.sim.bodies.g1_policy import STAND_RAD
from agentrob.sim.bodies.go2_gestures import Frame, Motion
from agentrob.sim.world.legged import Array

Indices = NDArray[np.intp]

LEFT, RIGHT = np.arange(15, 22), np.arange(22, 29)
BOTH = np.arange(15, 29)
_MIRROR: Array = np.array([1.0, -1, -1, 1, -1, 1, -1])

RAISE_S, SHOW_S, LOWER_S = 1.2, 3.0, 1.2
#: Raising both arms faster, or on another path, makes it step aside by 25 cm, because the policy ignores the arms.
SLOWLY_S = 2.6


def both(right: Array) -> Array:
    """The pose of a right arm, and its mirror image on the left."""
    return np.concatenate([right * _MIRROR, right])


@dataclass(frozen=True, slots=True)
class ArmGesture:
    """`show(t)` is the pose after the arms were raised, `by_way_of` the poses on the way up, lowest first.

    `holds`: the arms stay up until they are released, as the real robot does.
    """

    name: str
    joints: Indices
    show: Callable[[float], Array]
    by_way_of: tuple[Array, ...] = ()
    raise_s: float = RAISE_S
    show_s: float = SHOW_S
    holds: bool = False

    def play(self, start: Array) -> Motion:
        """Raise the arms from these joints, perform the gesture, and lower them unless it holds."""
        step_s = self.raise_s / (len(self.by_way_of) + 1)
        frames = [Frame(step_s, pose) for pose in (*self.by_way_of, self.show(0.0))]
        frames.append(Frame(self.show_s, drawn=self.show))
        if not self.holds:
            frames += self._down(self.show(self.show_s))
        return Motion(start, frames)

    def lower(self, start: Array) -> Motion:
        """Lower the arms from any point of the gesture."""
        return Motion(start, self._down(start))

    def _down(self, start: Array) -> list[Frame]:
        # Use only poses that are lower than the arms are now, so that they never rise again.
        pitch = len(start) - len(RIGHT)  # of the right shoulder
        below = [pose for pose in reversed(self.by_way_of) if pose[pitch] > start[pitch] + 0.1]
        step_s = LOWER_S / (len(below) + 1)  # quick: going down moves it by 2 cm at most
        return [Frame(step_s, pose) for pose in (*below, STAND_RAD[self.joints])]


def _swing(t: float, hertz: float) -> float:
    return math.sin(2 * math.pi * hertz * t)


def _waving(t: float) -> Array:
    swing = _swing(t, 1.3)
    return np.array([-2.11, -1.62 - 0.10 * swing, 0.73 + 0.35 * swing, 0.55, 0.0, 0.0, 0.0])


def _clapping(t: float) -> Array:
    apart = 0.5 + 0.5 * math.cos(2 * math.pi * 1.6 * t)
    return both(np.array([-0.35, -0.39, 0.54 - 0.45 * apart, -0.21, 0.0, 0.0, 0.0]))


def _heart(_: float) -> Array:
    return both(np.array([-2.9, -1.05, 1.25, 0.45, 0.0, 0.0, 0.0]))


def _shaking(t: float) -> Array:
    swing = _swing(t, 1.5) * min(1.0, t / 0.3, max(0.0, SHOW_S - t) / 0.3)
    return np.array([-0.50 - 0.10 * swing, -0.05, 0.05, -0.10 - 0.20 * swing, 0.0, 0.0, 0.0])


# Sideways, because two arms in front of the body shift its weight.
_ASIDE = both(np.array([0.0, -1.95, 0.1, 0.5, 0.0, 0.0, 0.0]))
_ABOVE = both(np.array([-2.0, -1.87, 1.22, 0.4, 0.0, 0.0, 0.0]))

RELEASE = 99
#: By the ids of the arm service.
GESTURES: Mapping[int, ArmGesture] = {
    17: ArmGesture("clap", BOTH, _clapping),
    20: ArmGesture("heart", BOTH, _heart, (_ASIDE, _ABOVE), raise_s=SLOWLY_S, show_s=1.0, holds=True),
    26: ArmGesture("high wave", RIGHT, _waving),
    27: ArmGesture("shake hand", RIGHT, _shaking, holds=True),
}
