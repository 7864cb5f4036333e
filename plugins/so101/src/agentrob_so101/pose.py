"""Poses of the arm, in LeRobot's names and units: degrees of the joints, percent of the gripper's opening."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple


class ArmPose(NamedTuple):
    """Degrees from the middle of each joint's range (a positive pan turns to the right, the other positive angles lean
    forward and down), and how far the gripper is open: 0 closed, 100 open."""

    shoulder_pan: float = 0.0
    shoulder_lift: float = 0.0
    elbow_flex: float = 0.0
    wrist_flex: float = 0.0
    wrist_roll: float = 0.0
    gripper: float = 0.0

    @property
    def joints(self) -> tuple[float, ...]:
        """The five joint angles, without the gripper."""
        return self[:-1]

    def __str__(self) -> str:
        angles = ", ".join(f"{name} {value:.1f}°" for name, value in zip(JOINTS, self, strict=False))
        return f"{angles}, {GRIPPER} {self.gripper:.0f} %"


NAMES: tuple[str, ...] = ArmPose._fields
JOINTS, GRIPPER = NAMES[:-1], NAMES[-1]
SUFFIX = ".pos"


def pose_of(observation: Mapping[str, object]) -> ArmPose:
    """Read an observation of LeRobot's ("shoulder_pan.pos", …). Raises `ValueError` with a sentence if a position is
    missing or is not a number."""
    values = []
    for name in NAMES:
        value = observation.get(name + SUFFIX)
        if value is None:
            raise ValueError(f"The arm does not tell {name}{SUFFIX}.")
        try:
            number = float(value)  # type: ignore[arg-type]  # numbers of numpy too
        except (TypeError, ValueError):
            number = math.nan
        if not math.isfinite(number):
            raise ValueError(f"The arm tells {name}{SUFFIX} as {value!r}, which is not a number.")
        values.append(number)
    return ArmPose(*values)


def action_of(pose: ArmPose) -> dict[str, float]:
    """Return a pose as an action of LeRobot's."""
    return {name + SUFFIX: round(float(value), 4) for name, value in zip(NAMES, pose, strict=True)}


def between(start: ArmPose, end: ArmPose, share: float) -> ArmPose:
    """Return the pose at a share (0 to 1) of the way from one pose to another."""
    return ArmPose(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))


def near(pose: ArmPose, middle: ArmPose, degrees: float) -> ArmPose:
    """Return the pose that is nearest to `pose` with no value farther than `degrees` (or percent) from `middle`."""
    return ArmPose(*(max(m - degrees, min(m + degrees, p)) for p, m in zip(pose, middle, strict=True)))


def farthest_deg(a: ArmPose, b: ArmPose) -> tuple[str, float]:
    """Return the joint that differs most between two poses, and by how many degrees; the gripper does not count."""
    return max(((n, abs(x - y)) for n, x, y in zip(JOINTS, a, b, strict=False)), key=lambda found: found[1])
