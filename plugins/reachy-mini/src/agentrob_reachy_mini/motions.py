"""The motion of each operation: the poses that it goes through, and the angle by which it is measured. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from agentrob.model import Direction, Op, Primitive
from agentrob_reachy_mini.operations import (
    ANGLE,
    ANTENNAS,
    CENTRE,
    GLANCE,
    GROOVE,
    LOOK_DOWN,
    LOOK_UP,
    NOD,
    SECONDS,
    SHAKE_HEAD,
    SIDE,
    SWAY,
    TILT,
    TOLERANCE_DEG,
)  # fmt: skip
from agentrob_reachy_mini.pose import PEAK, BodyPose, Speeds, checked, seconds_between, within

NOD_DEG, SHAKE_DEG, ANTENNA_DEG, GREET_DEG, SWAY_DEG, GROOVE_DEG = 15.0, 20.0, 40.0, 12.0, 12.0, 8.0
#: Half a cycle of a dance, in seconds.
BEAT_S = 0.75
BOB_M = 0.005
#: A gesture has been done if it was measured at this share of its size at least.
ENOUGH = 0.6


class Frame(NamedTuple):
    """A pose, and how long the motion to it takes."""

    pose: BodyPose
    seconds: float


@dataclass(frozen=True, slots=True)
class Motion:
    """Frames in order. `angle`: the measured angle of a pose in radians, positive in the direction of the motion.
    `asked_deg`: what it should be at the end, or with `peak` how far it should go from where it began. `name` is that
    of the measured quantity."""

    frames: tuple[Frame, ...]
    angle: Callable[[BodyPose], float]
    asked_deg: float
    name: str = ANGLE
    peak: bool = False

    def measured_deg(self, start: BodyPose, seen: Sequence[BodyPose]) -> float:
        """The angle measured from the poses that were seen, in degrees; 0 for none."""
        values = [math.degrees(self.angle(pose)) for pose in seen]
        if not values:
            return 0.0
        first = math.degrees(self.angle(start))
        return max(abs(value - first) for value in values) if self.peak else values[-1]

    def done(self, measured_deg: float) -> bool:
        if self.peak:
            return measured_deg >= ENOUGH * self.asked_deg
        return abs(measured_deg - self.asked_deg) <= TOLERANCE_DEG

    @property
    def seconds(self) -> float:
        return sum(frame.seconds for frame in self.frames)


def motion_of(step: Primitive, measured: BodyPose, speeds: Speeds) -> Motion:
    """Return what a step does from the pose that was measured. Raises `OutOfReach` if that leaves the bounds,
    `KeyError` for an operation that is no motion of its own."""
    return MOTIONS[step.op](step, within(measured), speeds)


def _turn(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    """The head goes along: otherwise the daemon keeps it where it is, and the body within reach of it."""
    sign = 1.0 if step.direction is Direction.LEFT else -1.0
    degrees = step.degrees or 0.0
    body = start.body_yaw + sign * math.radians(degrees)
    target = start._replace(body_yaw=body, head_yaw=body + start.neck_yaw)
    began = start.body_yaw
    return Motion(
        _path(start, [target], speeds), lambda pose: sign * (pose.body_yaw - began), degrees, "degrees"
    )  # fmt: skip


def _look(pitch_sign: float) -> Callable[[Primitive, BodyPose, Speeds], Motion]:
    def look(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
        degrees = float(step.value(ANGLE))
        target = _head(start, pitch=pitch_sign * math.radians(degrees))
        return Motion(_path(start, [target], speeds), lambda pose: pitch_sign * pose.pitch, degrees)

    return look


def _glance(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    sign, degrees = (1.0 if step.value(SIDE) == "left" else -1.0), float(step.value(ANGLE))
    target = _head(start, yaw=sign * math.radians(degrees))
    return Motion(_path(start, [target], speeds), lambda pose: sign * pose.neck_yaw, degrees)


def _tilt(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    sign, degrees = (-1.0 if step.value(SIDE) == "left" else 1.0), float(step.value(ANGLE))
    target = _head(start, roll=sign * math.radians(degrees))
    return Motion(_path(start, [target], speeds), lambda pose: sign * pose.roll, degrees)


def _centre(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    def off(pose: BodyPose) -> float:
        return max(abs(pose.neck_yaw), abs(pose.pitch), abs(pose.roll))

    return Motion(_path(start, [_head(start)], speeds), off, 0.0, "off_deg")


def _nod(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    """Down and up again; up and down where the head is low already."""
    way = 1.0 if start.pitch + math.radians(NOD_DEG) < math.radians(30) else -1.0
    low = start._replace(pitch=start.pitch + way * math.radians(NOD_DEG))
    return Motion(_path(start, [low, start], speeds), lambda pose: pose.pitch, NOD_DEG, "head_deg", peak=True)


def _shake(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    left, right = (_turned(start, sign * math.radians(SHAKE_DEG)) for sign in (1.0, -1.0))
    frames = _path(start, [left, right, start], speeds)
    return Motion(frames, lambda pose: pose.neck_yaw, SHAKE_DEG, "head_deg", peak=True)


def _antennas(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    a = math.radians(ANTENNA_DEG)
    out, back = start._replace(right_antenna=-a, left_antenna=a), start._replace(right_antenna=a, left_antenna=-a)
    frames = _path(start, [out, back, out, back, start], speeds)
    return Motion(frames, lambda pose: pose.right_antenna, ANTENNA_DEG, "antenna_deg", peak=True)


def _greet(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    """The head tilts, and the antennas wave."""
    tilted = _head(start, roll=math.radians(GREET_DEG))
    out, back = _spread(tilted, 50.0), _spread(tilted, 10.0)
    frames = _path(start, [out, back, out, back, start], speeds)
    return Motion(frames, lambda pose: pose.roll, GREET_DEG, "head_deg", peak=True)


def _sway(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    """From side to side in time, by roll and yaw of the head."""
    most = _most(SWAY_DEG, speeds)
    sides = [
        checked(_turned(_head(start, roll=sign * math.radians(most)), -sign * math.radians(most / 2)))
        for sign in (1.0, -1.0)
    ]
    return Motion(_in_time(step, start, sides, speeds), lambda pose: pose.roll, most, "head_deg", peak=True)


def _groove(step: Primitive, start: BodyPose, speeds: Speeds) -> Motion:
    """Up and down in time, the antennas in turn."""
    most = _most(GROOVE_DEG, speeds)
    most_antenna = math.radians(min(20.0, speeds.antennas_dps * BEAT_S / PEAK / 2))
    beats = [
        checked(
            _head(start, pitch=sign * math.radians(most))._replace(
                head_up_m=-sign * BOB_M, right_antenna=sign * most_antenna, left_antenna=sign * most_antenna
            )
        )
        for sign in (1.0, -1.0)
    ]
    return Motion(_in_time(step, start, beats, speeds), lambda pose: pose.pitch, most, "head_deg", peak=True)


MOTIONS: dict[str, Callable[[Primitive, BodyPose, Speeds], Motion]] = {
    Op.TURN: _turn, Op.HELLO: _greet, LOOK_UP: _look(-1.0), LOOK_DOWN: _look(1.0), GLANCE: _glance, TILT: _tilt,
    CENTRE: _centre, NOD: _nod, SHAKE_HEAD: _shake, ANTENNAS: _antennas, SWAY: _sway, GROOVE: _groove,
}  # fmt: skip


def _head(start: BodyPose, *, yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0) -> BodyPose:
    """The pose with its head so, against the body."""
    return start._replace(head_yaw=start.body_yaw + yaw, pitch=pitch, roll=roll, head_up_m=0.0)


def _turned(start: BodyPose, yaw: float) -> BodyPose:
    """The pose with its head turned by so much, as far as its neck allows."""
    return within(start._replace(head_yaw=start.head_yaw + yaw))


def _spread(start: BodyPose, degrees: float) -> BodyPose:
    return start._replace(right_antenna=-math.radians(degrees), left_antenna=math.radians(degrees))


def _most(degrees: float, speeds: Speeds) -> float:
    """So many degrees to either side, or as many as the head can do in a beat."""
    return min(degrees, speeds.head_dps * BEAT_S / PEAK / 2)


def _path(start: BodyPose, poses: Sequence[BodyPose], speeds: Speeds) -> tuple[Frame, ...]:
    frames, before = [], start
    for pose in poses:
        frames.append(Frame(checked(pose), seconds_between(before, pose, speeds)))
        before = pose
    return tuple(frames)


def _in_time(step: Primitive, start: BodyPose, beats: Sequence[BodyPose], speeds: Speeds) -> tuple[Frame, ...]:
    """The beats in turn, and back, in the seconds that were asked; longer where the speeds do not allow that."""
    into_s, out_s = seconds_between(start, beats[0], speeds), seconds_between(beats[1], start, speeds)
    beat_s = max(BEAT_S, seconds_between(beats[0], beats[1], speeds))
    left_s = float(step.value(SECONDS)) - into_s - out_s
    count = max(1, 2 * round((left_s / beat_s - 1) / 2) + 1)  # odd: it ends at the other side
    each_s = max(left_s / count, seconds_between(beats[0], beats[1], speeds))
    between = (Frame(beats[(i + 1) % 2], each_s) for i in range(count))
    return (Frame(beats[0], into_s), *between, Frame(start, out_s))
