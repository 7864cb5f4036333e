"""Where the parts of the arm are at given joint angles: forward kinematics, read from the model's file.

It needs numpy alone, since the machine of a real arm need not have MuJoCo. Frames are those of the model: the origin is
under the base, x ahead, y to the left, z up, in metres.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agentrob_so101.pose import GRIPPER, JOINTS, ArmPose

Array = NDArray[Any]

MODEL = Path(__file__).with_name("model") / "so101.xml"
#: How far the arm's points for checks are apart.
SPACING_M = 0.015
#: The last body, the jaw that moves, and their ends: from the frame of the body to the tip, in metres.
HAND, JAW = "gripper", "moving_jaw_so101_v1"
TIP, JAW_TIP = (-0.0079, -0.0002, -0.105), (-0.0123, -0.082, 0.0189)
HAND_R, TIP_R = 0.028, 0.008


class _Part(NamedTuple):
    """From one place of a body to one of another, as a round bar: its radius at both ends."""

    start: tuple[str, tuple[float, float, float]]
    end: tuple[str, tuple[float, float, float]]
    start_r: float
    end_r: float


_O = (0.0, 0.0, 0.0)
#: What of the arm moves, as bars that contain it.
_PARTS = (
    _Part(("upper_arm", _O), ("lower_arm", _O), 0.035, 0.035),
    _Part(("lower_arm", _O), ("wrist", _O), 0.035, 0.035),
    _Part(("wrist", _O), (HAND, _O), 0.035, HAND_R),
    _Part((HAND, _O), (HAND, TIP), HAND_R, TIP_R),
    _Part((JAW, _O), (JAW, JAW_TIP), 0.015, TIP_R),
)


class _Link(NamedTuple):
    """A body of the model: its parent, its frame in that of the parent (4, 4), and the joint that turns it around its
    z axis, if there is one."""

    parent: str
    frame: Array
    joint: str


class Kinematics:
    """The chain of the model's bodies. `lowest` and `highest` are the limits of the joints."""

    def __init__(self, model: Path = MODEL) -> None:
        root = ET.parse(model).getroot()
        self._links: dict[str, _Link] = {}
        ranges: dict[str, tuple[float, float]] = {}
        for body in root.findall("worldbody/body"):
            self._read(body, "", ranges)
        self._jaw_rad = ranges[GRIPPER]
        low, high = (tuple(math.degrees(ranges[name][side]) for name in JOINTS) for side in (0, 1))
        self.lowest, self.highest = ArmPose._make((*low, 0.0)), ArmPose._make((*high, 100.0))

    def _read(self, body: Any, parent: str, ranges: dict[str, tuple[float, float]]) -> None:
        name, joint = body.get("name"), body.find("joint")
        if joint is not None:
            low, high = (float(v) for v in joint.get("range").split())
            ranges[joint.get("name")] = low, high
        frame = _frame(_numbers(body.get("pos", "0 0 0")), _numbers(body.get("quat", "1 0 0 0")))
        self._links[name] = _Link(parent, frame, joint.get("name") if joint is not None else "")
        for child in body.findall("body"):
            self._read(child, name, ranges)

    def radians(self, pose: ArmPose) -> dict[str, float]:
        """Return the angle of each joint of the model, the gripper's too."""
        closed, opened = self._jaw_rad
        angles = {name: math.radians(value) for name, value in zip(JOINTS, pose, strict=False)}
        return {**angles, GRIPPER: closed + pose.gripper / 100 * (opened - closed)}

    def pose(self, radians: Mapping[str, float]) -> ArmPose:
        """Return the pose of the joints of the model."""
        closed, opened = self._jaw_rad
        opening = 100 * (radians[GRIPPER] - closed) / (opened - closed)
        return ArmPose._make((*(math.degrees(radians[name]) for name in JOINTS), opening))

    def frames(self, pose: ArmPose) -> dict[str, Array]:
        """Return the frame (4, 4) of each body."""
        angles, found = self.radians(pose), dict[str, Array]()
        for name, link in self._links.items():
            frame = link.frame if not link.parent else found[link.parent] @ link.frame
            found[name] = frame @ _turn(angles[link.joint]) if link.joint else frame
        return found

    def points(self, pose: ArmPose) -> tuple[Array, Array]:
        """Return points along the arm (n, 3), and how thick the arm is around each: its radius (n,)."""
        frames = self.frames(pose)
        places, radii = [], []
        for part in _PARTS:
            start, end = (frames[body] @ (*at, 1.0) for body, at in (part.start, part.end))
            count = 2 + int(np.linalg.norm(end - start) / SPACING_M)
            shares = np.linspace(0.0, 1.0, count)[:, None]
            places.append(start[:3] + shares * (end - start)[:3])
            radii.append(np.linspace(part.start_r, part.end_r, count))
        return np.concatenate(places), np.concatenate(radii)

    def tip(self, pose: ArmPose) -> tuple[Array, Array]:
        """Return where the tip of the gripper is (3,), and the unit vector in which it points (3,)."""
        frame = self.frames(pose)[HAND]
        return (frame @ (*TIP, 1.0))[:3], -frame[:3, 2]


@cache
def so101() -> Kinematics:
    """The kinematics of the model of this package."""
    return Kinematics()


def _numbers(text: str) -> list[float]:
    return [float(number) for number in text.split()]


def _frame(position: list[float], quaternion: list[float]) -> Array:
    """A frame (4, 4) from its position and its quaternion (w, x, y, z)."""
    w, x, y, z = np.array(quaternion) / np.linalg.norm(quaternion)
    frame = np.eye(4)
    frame[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    frame[:3, 3] = position
    return frame


def _turn(angle_rad: float) -> Array:
    """A turn (4, 4) around the z axis."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
