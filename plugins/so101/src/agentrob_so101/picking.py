"""Where the red cube lies, by the picture of the simulated arm's camera, and the poses that lead the gripper around it.

The camera of the simulation stands in a known place. That of a real arm does not, so a real arm does not offer this.
"""

from __future__ import annotations

import io
import math
from typing import NamedTuple

import numpy as np

from agentrob_so101.kinematics import HAND, Array, so101
from agentrob_so101.pose import ArmPose

#: The cube: its edge in metres.
CUBE_M = 0.030
#: The camera: where it is, what it looks at (metres from the arm's foot), its vertical field of view, its picture.
CAMERA_M, LOOKS_AT_M, FOV_DEG, PICTURE_PX = (0.86, -0.50, 0.62), (0.06, 0.0, 0.18), 46.0, (640, 480)
#: Red in a picture: at least so bright, and so many times as much as green and blue.
RED, REDDER, LEAST_PIXELS = 80, 2.2, 40
#: Whatever way it is turned, the cube looks about as large as a cylinder of this radius.
AROUND_M = 0.55 * CUBE_M
#: Beyond this nothing can be grasped: metres from the axis of the pan joint.
NEAREST_M, FARTHEST_M = 0.12, 0.29
#: Where the axis of the pan joint is: x in metres.
AXIS_M = 0.0388
#: Between the open jaws: from the frame of the hand, in metres.
GRASP_M = (0.022, -0.0002, -0.098)
#: How high that place is while it grasps and before, how steep the gripper comes down, and how far it is open.
LOW_M, HIGH_M, STEEP_DEG, OPEN = 0.016, 0.075, (90.0, 80.0, 70.0, 60.0), 60.0
_ITERATIONS, _GOOD_M = 60, 1e-4


class Grasp(NamedTuple):
    """The poses above the cube and around it."""

    above: ArmPose
    around: ArmPose


def locate(jpeg: bytes) -> tuple[float, float] | None:
    """Return where the red cube lies on the table, in metres from the arm's foot; None if it is not seen."""
    from PIL import Image

    with Image.open(io.BytesIO(jpeg)) as image:
        picture = np.asarray(image.convert("RGB").resize(PICTURE_PX), dtype=np.float64)
    red = (picture[..., 0] > RED) & (picture[..., 0] > REDDER * picture[..., 1:].max(axis=2))
    spot = _largest({(int(row), int(column)) for row, column in zip(*np.nonzero(red), strict=True)})
    if len(spot) < LEAST_PIXELS:
        return None
    rows, columns = np.array(sorted(spot)).T
    seen = _middle(columns, rows)
    place = np.array([LOOKS_AT_M[0] + 0.15, LOOKS_AT_M[1]])
    for _ in range(_ITERATIONS):
        missed = seen - _shown(place)
        if np.abs(missed).max() < 0.01:
            return float(place[0]), float(place[1])
        step_m = 1e-4
        slope = np.stack([(_shown(place + step_m * one) - _shown(place)) / step_m for one in np.eye(2)], axis=1)
        place = place + np.clip(np.linalg.solve(slope, missed), -0.1, 0.1)
    return None


def _largest(pixels: set[tuple[int, int]]) -> set[tuple[int, int]]:
    """The largest of the spots that pixels form (row, column): an edge of the arm may have single red ones."""
    largest: set[tuple[int, int]] = set()
    while len(pixels) > len(largest):
        spot = {pixels.pop()}
        edge = list(spot)
        while edge:
            row, column = edge.pop()
            beside = {(row + down, column + right) for down in (-1, 0, 1) for right in (-1, 0, 1)} & pixels
            pixels -= beside
            spot |= beside
            edge += beside
        largest = max(largest, spot, key=len)
    return largest


def grasp(x_m: float, y_m: float) -> Grasp | None:
    """Return how to grasp something at a place on the table, as steep as possible; None if it is out of reach."""
    if not NEAREST_M <= math.hypot(x_m - AXIS_M, y_m) <= FARTHEST_M:
        return None
    for steep_deg in STEEP_DEG:
        above, around = (_reaching(x_m, y_m, high_m, steep_deg) for high_m in (HIGH_M, LOW_M))
        if above is not None and around is not None:
            return Grasp(above, around)
    return None


def _reaching(x_m: float, y_m: float, z_m: float, steep_deg: float) -> ArmPose | None:
    """The pose in which the place between the jaws is at (x, y, z), with the gripper so steep; None if none is."""
    wanted = np.array([math.atan2(y_m, x_m - AXIS_M), math.hypot(x_m - AXIS_M, y_m), z_m])
    turned = np.array([-math.degrees(wanted[0]), 0.0, 40.0])  # pan, lift, elbow; the wrist makes it steep
    for _ in range(_ITERATIONS):
        missed = wanted - _reached(turned, steep_deg)
        if np.abs(missed).max() < _GOOD_M:
            pose = _posed(turned, steep_deg)
            fits = all(a <= v <= b for a, v, b in zip(so101().lowest, pose, so101().highest, strict=True))
            return pose if fits else None
        slope = np.stack([_reached(turned + one, steep_deg) - _reached(turned, steep_deg) for one in np.eye(3)], axis=1)
        try:
            turned = turned + np.clip(np.linalg.solve(slope, missed), -15.0, 15.0)
        except np.linalg.LinAlgError:
            return None
    return None


def _posed(turned: Array, steep_deg: float) -> ArmPose:
    pan, lift, elbow = (float(angle) for angle in turned)
    return ArmPose(pan, lift, elbow, steep_deg - lift - elbow, 0.0, OPEN)


def _reached(turned: Array, steep_deg: float) -> Array:
    """Where the place between the jaws is: direction and distance from the axis of the pan joint, and height (3,)."""
    x, y, z = (so101().frames(_posed(turned, steep_deg))[HAND] @ (*GRASP_M, 1.0))[:3]
    return np.array([math.atan2(y, x - AXIS_M), math.hypot(x - AXIS_M, y), z])


def camera_axes() -> Array:
    """The axes of the camera in columns (3, 3): to the right, up, and back."""
    back = np.array(CAMERA_M) - np.array(LOOKS_AT_M)
    back /= np.linalg.norm(back)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back], axis=1)


def _shown(place: Array) -> Array:
    """The middle of what a cube at a place covers in the picture (2,): pixels to the right and down."""
    angles = np.linspace(0.0, 2 * math.pi, 24, endpoint=False)
    ring = np.stack([place[0] + AROUND_M * np.cos(angles), place[1] + AROUND_M * np.sin(angles)], axis=1)
    points = np.concatenate([np.column_stack([ring, np.full(len(ring), high)]) for high in (0.0, CUBE_M)])
    seen = (points - np.array(CAMERA_M)) @ camera_axes()
    width, height = PICTURE_PX
    focal = height / 2 / math.tan(math.radians(FOV_DEG) / 2)
    return _middle(width / 2 - focal * seen[:, 0] / seen[:, 2], height / 2 + focal * seen[:, 1] / seen[:, 2])


def _middle(columns: Array, rows: Array) -> Array:
    return np.array([(columns.min() + columns.max()) / 2, (rows.min() + rows.max()) / 2])
