"""Where the arm may not be: the table, the keep-out boxes of its owner, and beyond its joints' limits. Pure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from agentrob_so101.kinematics import Array, Kinematics
from agentrob_so101.options import So101Options
from agentrob_so101.pose import GRIPPER, NAMES, ArmPose, between, farthest_deg

#: A planned way keeps this far away from a box; the arm that is measured inside the box itself is stopped.
MARGIN_M = 0.02
#: The table may be touched, since the bars are thicker than the tips: how deep in it a planned way and the arm may be.
TOUCHING_M, TOUCHED_M = 0.006, 0.012
#: How much nearer to a box an arm may come that is too near already: as much as a servo swings.
NEARER_M = 0.001
#: A way is checked at poses that are at most this far apart.
CHECKED_DEG = 2.0
#: Joints may be measured so far beyond their limits: a servo swings, and a limit of the owner's may be near.
MEASURED_SLACK_DEG = 4.0
_FAR_M = 5.0

#: A stable word (as in `ActionResult.reason`) and a sentence.
Objection = tuple[str, str]


class Box(NamedTuple):
    """Two corners (3,) in metres, and how far away the arm must be: on a planned way, and where it is measured."""

    name: str
    low: Array
    high: Array
    planned_m: float
    measured_m: float


class KeepOut:
    """The places and angles that are forbidden to one arm."""

    def __init__(self, options: So101Options, arm: Kinematics) -> None:
        self._arm = arm
        self._lowest, self._highest = options.limits
        table = np.array([-_FAR_M, -_FAR_M, options.table_m - _FAR_M]), np.array([_FAR_M, _FAR_M, options.table_m])
        self._boxes = [Box("the table", *table, -TOUCHING_M, -TOUCHED_M)]
        for box in options.keep_out:
            self._boxes.append(Box(box.name, np.array(box.from_m), np.array(box.to_m), MARGIN_M, 0.0))

    def on_the_way(self, poses: Sequence[ArmPose]) -> Objection | None:
        """Return what forbids a way, straight from pose to pose in the space of the joints; None if nothing does. From
        where the arm is too near to a box already it may go on, but not nearer."""
        for pose in poses[1:]:
            if why := self._beyond(pose, "would be", 1e-6):
                return "joint_limits", why
        least = [min(box.planned_m, gap - NEARER_M) for box, gap in zip(self._boxes, self._gaps(poses[0]), strict=True)]
        for start, end in itertools.pairwise(poses):
            count = 1 + math.ceil(farthest_deg(start, end)[1] / CHECKED_DEG)
            for step in range(count + 1):
                if name := self._entered(between(start, end, step / count), least):
                    return "keep_out", f"The arm would come too near to {name} on its way."
        return None

    def now(self, pose: ArmPose) -> Objection | None:
        """Return what is wrong with where the arm is measured to be; None if nothing is."""
        if why := self._beyond(pose, "is", MEASURED_SLACK_DEG):
            return "joint_limits", why
        if name := self._entered(pose, [box.measured_m for box in self._boxes]):
            return "keep_out", f"The arm is too near to {name}."
        return None

    def _beyond(self, pose: ArmPose, verb: str, slack: float) -> str:
        """A sentence about a joint that is beyond its limits; empty if none is."""
        for name, value, low, high in zip(NAMES, pose, self._lowest, self._highest, strict=True):
            if not low - slack <= value <= high + slack:
                unit = " %" if name == GRIPPER else "°"
                return f"The joint {name} {verb} at {value:.0f}{unit}; it may be from {low:.0f} to {high:.0f}{unit}."
        return ""

    def _entered(self, pose: ArmPose, least_m: Sequence[float]) -> str:
        """The name of the first box that the arm is nearer to than it may be; empty if there is none."""
        gaps = zip(self._boxes, self._gaps(pose), least_m, strict=True)
        return next((box.name for box, gap, least in gaps if gap < least), "")

    def _gaps(self, pose: ArmPose) -> list[float]:
        """How far the arm is from each box in metres; negative for how deep a part of it is inside."""
        points, radii = self._arm.points(pose)
        gaps = []
        for box in self._boxes:
            outside = np.maximum(np.maximum(box.low - points, points - box.high), 0.0)
            gaps.append(float((np.linalg.norm(outside, axis=1) - radii).min()))
        return gaps
