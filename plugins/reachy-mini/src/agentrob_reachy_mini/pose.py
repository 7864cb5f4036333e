"""How Reachy Mini holds its head, antennas and body, and the bounds that AgentRob keeps it in.

Angles are radians, counter-clockwise as seen from above, in the frame of its foot, as its daemon has them; a positive
pitch looks down and a positive roll tilts the head to its right.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from agentrob.robots.control.controller import wrap

#: The maker's limits: head pitch and roll 40°, body 160°, head against body 65°. AgentRob keeps 5° inside them, since
#: the daemon accepts what is beyond and goes somewhere else.
HEAD_PITCH_DEG = HEAD_ROLL_DEG = 35.0
HEAD_YAW_DEG = 60.0  # against the body
BODY_YAW_DEG = 155.0
ANTENNA_DEG = 120.0
HEAD_UP_M = 0.01
#: What is measured beyond this is not an angle of this robot in radians.
MOST_PLAUSIBLE_RAD = 3.3
MOST_PLAUSIBLE_TILT_RAD = math.radians(60)
#: The highest speed of a minimum-jerk motion is so many times its average.
PEAK = 1.875
LEAST_S = 0.25


class BodyPose(NamedTuple):
    """Measured, or to be reached. `head_yaw` is absolute, `head_up_m` the height of the head above its middle one."""

    head_yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    body_yaw: float = 0.0
    right_antenna: float = 0.0
    left_antenna: float = 0.0
    head_up_m: float = 0.0

    @property
    def neck_yaw(self) -> float:
        """The yaw of the head against the body."""
        return wrap(self.head_yaw - self.body_yaw)


class Speeds(NamedTuple):
    """The highest speeds of a motion, in degrees per second."""

    head_dps: float
    body_dps: float
    antennas_dps: float


class OutOfReach(ValueError):
    """A pose is outside the bounds; the message is a sentence that names the bound."""


def checked(pose: BodyPose) -> BodyPose:
    """Return the pose. Raises `OutOfReach` if it is not finite or outside the bounds, as degrees taken for radians
    are."""
    for what, value, most_deg in (
        ("pitch of its head", pose.pitch, HEAD_PITCH_DEG),
        ("roll of its head", pose.roll, HEAD_ROLL_DEG),
        ("turn of its head against its body", pose.head_yaw - pose.body_yaw, HEAD_YAW_DEG),
        ("turn of its body", pose.body_yaw, BODY_YAW_DEG),
        ("angle of its right antenna", pose.right_antenna, ANTENNA_DEG),
        ("angle of its left antenna", pose.left_antenna, ANTENNA_DEG),
    ):
        degrees = math.degrees(value)
        if not abs(degrees) <= most_deg + 0.01:
            raise OutOfReach(f"The {what} would be {degrees:.0f}°; it may be from -{most_deg:g}° to {most_deg:g}°.")
    if not abs(pose.head_up_m) <= HEAD_UP_M + 1e-6:
        raise OutOfReach(f"Its head would be {pose.head_up_m:g} m high; it may be from -{HEAD_UP_M} to {HEAD_UP_M} m.")
    return pose


def within(pose: BodyPose) -> BodyPose:
    """Return the nearest pose inside the bounds: where a motion that keeps some axes begins."""
    body = _clip(pose.body_yaw, BODY_YAW_DEG)
    return BodyPose(
        body + _clip(pose.neck_yaw, HEAD_YAW_DEG),
        _clip(pose.pitch, HEAD_PITCH_DEG),
        _clip(pose.roll, HEAD_ROLL_DEG),
        body,
        _clip(pose.right_antenna, ANTENNA_DEG),
        _clip(pose.left_antenna, ANTENNA_DEG),
        max(-HEAD_UP_M, min(HEAD_UP_M, pose.head_up_m)),
    )


def implausible(pose: BodyPose) -> str:
    """Return why a measured pose is not one of this robot's, as a sentence; empty if it is."""
    tilted = ("head pitch", pose.pitch), ("head roll", pose.roll)
    turned = ("head yaw", pose.head_yaw), ("body yaw", pose.body_yaw)
    antennas = ("right antenna", pose.right_antenna), ("left antenna", pose.left_antenna)
    for name, value in (*tilted, *turned, *antennas):
        most_rad = MOST_PLAUSIBLE_TILT_RAD if (name, value) in tilted else MOST_PLAUSIBLE_RAD
        if not abs(value) <= most_rad:
            return f"Its daemon says that the {name} is {value:g} rad: are these degrees? They must be radians."
    return ""


def seconds_between(a: BodyPose, b: BodyPose, speeds: Speeds) -> float:
    """Return how long a minimum-jerk motion takes that keeps the speeds."""
    head_deg = math.degrees(max(abs(b.head_yaw - a.head_yaw), abs(b.pitch - a.pitch), abs(b.roll - a.roll)))
    body_deg = math.degrees(abs(b.body_yaw - a.body_yaw))
    # the head turns along with the body, which is slower
    neck_deg = math.degrees(max(abs(b.neck_yaw - a.neck_yaw), abs(b.pitch - a.pitch), abs(b.roll - a.roll)))
    head_s = (neck_deg if body_deg else head_deg) / speeds.head_dps
    antennas = max(abs(b.right_antenna - a.right_antenna), abs(b.left_antenna - a.left_antenna))
    antennas_s = math.degrees(antennas) / speeds.antennas_dps
    return max(LEAST_S, PEAK * max(head_s, body_deg / speeds.body_dps, antennas_s))


def apart_rad(a: BodyPose, b: BodyPose) -> float:
    """Return the largest difference of their angles."""
    return max(abs(x - y) for x, y in zip(a[:6], b[:6], strict=True))


def _clip(angle: float, most_deg: float) -> float:
    return max(-math.radians(most_deg), min(math.radians(most_deg), angle))
