"""Gestures of the Go2 as key poses, played in full physics.

A pose is the pitch of the body, the height of the rear hips and the positions of the feet; inverse kinematics gives the
joint angles. Legs are in the order FR, FL, RR, RL, each with joints hip, thigh, calf.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from agentrob.sim.bodies.go2_policy import STAND_RAD
from agentrob.sim.world.legged import Array

THIGH_M = CALF_M = 0.213
HIP_X_M = 0.1934  # from the body's middle to a hip, along x
FOOT_M = 0.022
THIGH_FRONT_RAD, THIGH_REAR_RAD, CALF_RAD = (-1.57, 3.49), (-0.52, 4.53), (-2.70, -0.86)
SHORTEST_LEG_M = 0.10

FIRM = 4.0  # stiffness while posing: the policy's own gains are soft
SOFT = 2.5  # stiffness when giving the body back to the policy

FRONT_RIGHT, FRONT_LEFT = 0, 1


def _leg(hip: tuple[float, float], foot: tuple[float, float], pitch: float, thigh_range: tuple[float, float]) -> Array:
    """Thigh and calf angle for a hip and a foot in world (x, z), the body pitched nose up by `pitch`."""
    dx, dz = foot[0] - hip[0], hip[1] - foot[1]
    reach = min(max(math.hypot(dx, dz), SHORTEST_LEG_M), THIGH_M + CALF_M - 0.03)
    knee = (THIGH_M**2 + CALF_M**2 - reach**2) / (2 * THIGH_M * CALF_M)
    calf = -(math.pi - math.acos(max(-1.0, min(1.0, knee))))
    calf = max(CALF_RAD[0], min(CALF_RAD[1], calf))
    to_foot = math.atan2(-dx, dz)
    thigh = to_foot + math.atan2(CALF_M * math.sin(-calf), THIGH_M + CALF_M * math.cos(calf)) + pitch
    return np.array([max(thigh_range[0], min(thigh_range[1], thigh)), calf])


def pose(
    pitch: float, rear_hip_m: float, rear_foot_m: float, front_foot_m: float, hips: Sequence[float] = (0, 0, 0, 0)
) -> Array:
    """Joints (12, rad) of a symmetric pose on level ground.

    `pitch` rad nose up, `rear_hip_m` height of the rear hips, feet as x relative to the hip above them.
    """
    front_hip = (2 * HIP_X_M * math.cos(pitch), rear_hip_m + 2 * HIP_X_M * math.sin(pitch))
    front = _leg(front_hip, (front_hip[0] + front_foot_m, FOOT_M), pitch, THIGH_FRONT_RAD)
    rear = _leg((0.0, rear_hip_m), (rear_foot_m, FOOT_M), pitch, THIGH_REAR_RAD)
    return np.array([hips[0], *front, hips[1], *front, hips[2], *rear, hips[3], *rear])


SIT = pose(0.75, 0.14, 0.04, 0.02, (-0.05, 0.05, -0.15, 0.15))
# On three feet: the remaining fore foot moves under the middle and the hind feet apart, or it would tip over.
SIT_RIGHT_FREE = pose(0.75, 0.16, 0.05, 0.06, (-0.05, -0.30, -0.30, 0.30))
SIT_LEFT_FREE = pose(0.75, 0.16, 0.05, 0.06, (0.30, 0.05, -0.30, 0.30))
HALF_SIT = pose(0.35, 0.24, 0.0, 0.0)  # going through it keeps the feet from sliding
LIE = np.array([0.0, 1.30, -2.65, 0.0, 1.30, -2.65, -0.2, 1.36, -2.65, 0.2, 1.36, -2.65])
BOW = pose(-0.28, 0.34, 0.0, 0.18)


def raise_paw(base: Array, leg: int, hip: float, thigh: float, calf: float) -> Array:
    lifted = base.copy()
    lifted[3 * leg : 3 * leg + 3] = hip, thigh, calf
    return lifted


@dataclass(frozen=True, slots=True)
class Frame:
    """Take `seconds` to reach a pose, or follow `drawn(t)` for that long."""

    seconds: float
    pose: Array | None = None
    drawn: Callable[[float], Array] | None = None
    stiffness: float = FIRM

    def at(self, t: float, came_from: Array) -> Array:
        if self.drawn is not None:
            return self.drawn(t)
        assert self.pose is not None
        done = (1 - math.cos(math.pi * min(1.0, t / self.seconds))) / 2
        return came_from + (self.pose - came_from) * done


class Motion:
    """Frames one after another, from given joints: a `go2.Player` of `seconds` length."""

    def __init__(self, start: Array, frames: Sequence[Frame]) -> None:
        self._start = start
        self._frames = tuple(frames)
        self.seconds = sum(f.seconds for f in frames)

    def __call__(self, t: float) -> tuple[Array, float] | None:
        came_from = self._start
        for frame in self._frames:
            if t < frame.seconds:
                return frame.at(t, came_from), frame.stiffness
            came_from = frame.at(frame.seconds, came_from)
            t -= frame.seconds
        return None


TO_STAND = (Frame(1.2, STAND_RAD), Frame(0.3, STAND_RAD, stiffness=SOFT))
TO_SIT = (Frame(0.6, HALF_SIT), Frame(0.7, SIT))
SIT_TO_STAND = (Frame(0.6, HALF_SIT), Frame(0.6, STAND_RAD), Frame(0.3, STAND_RAD, stiffness=SOFT))


def hello(joints: Array) -> Motion:
    """Sit back, lift the right fore paw, wave it, stand up."""
    up = raise_paw(SIT_RIGHT_FREE, FRONT_RIGHT, -0.15, -0.35, -1.35)
    seconds = 2.4

    def wave(t: float) -> Array:
        swing = min(1.0, t / 0.3, (seconds - t) / 0.3)
        phase = 2 * math.pi * 1.4 * t
        paw = up.copy()
        paw[0] += swing * 0.45 * math.sin(phase)
        paw[2] += swing * 0.25 * math.sin(phase + 1.2)
        return paw

    return Motion(
        joints,
        [
            *TO_SIT,
            Frame(0.4, SIT_RIGHT_FREE),
            Frame(0.2, SIT_RIGHT_FREE),
            Frame(0.7, up),
            Frame(seconds, drawn=wave),
            Frame(0.7, SIT_RIGHT_FREE),
            Frame(0.2, SIT_RIGHT_FREE),
            Frame(0.4, SIT),
            *SIT_TO_STAND,
        ],
    )


def heart(joints: Array) -> Motion:
    """Draw a heart in the air: the right fore paw its right half, then the left one the left half.

    Both paws at once would tip it over.
    """

    def half(leg: int, sit: Array) -> list[Frame]:
        outward = -1 if leg == FRONT_RIGHT else 1
        seconds = 2.2

        def draw(t: float) -> Array:
            a = math.pi * min(1.0, max(0.0, t / seconds))
            shown = min(1.0, t / 0.3, (seconds - t) / 0.3)
            side = math.sin(a) ** 3
            up = (13 * math.cos(a) - 5 * math.cos(2 * a) - 2 * math.cos(3 * a) - math.cos(4 * a)) / 16
            swing = (outward * 0.60 * side * shown, -0.30 - 0.45 * up * shown, -1.2 + 0.15 * up * shown)
            return raise_paw(sit, leg, *swing)

        rest = Frame(0.2, sit)
        return [Frame(0.7, sit), rest, Frame(0.6, draw(0.0)), Frame(seconds, drawn=draw), Frame(0.6, sit), rest]

    return Motion(
        joints,
        [
            *TO_SIT,
            *half(FRONT_RIGHT, SIT_RIGHT_FREE),
            Frame(0.5, SIT),
            *half(FRONT_LEFT, SIT_LEFT_FREE),
            Frame(0.4, SIT),
            *SIT_TO_STAND,
        ],
    )


def stretch(joints: Array) -> Motion:
    """Fore legs far forward, chest down, then stand."""
    return Motion(joints, [Frame(1.2, BOW), Frame(1.5, BOW), *TO_STAND])


def sit(joints: Array) -> Motion:
    """Sit back on the hind legs and stay there."""
    return Motion(joints, [*TO_SIT, Frame(0.3, SIT)])


def rise_from_sitting(joints: Array) -> Motion:
    """From sitting to standing."""
    return Motion(joints, SIT_TO_STAND)


def lie_down(joints: Array) -> Motion:
    """Fold the legs and lie on the belly."""
    return Motion(joints, [Frame(1.6, LIE), Frame(0.3, LIE)])


def stand(joints: Array) -> Motion:
    """From any of these poses, also half way, back to standing: all feet down first."""
    return Motion(joints, [Frame(0.4, joints), *TO_STAND])


def rise(joints: Array) -> Motion:
    """From lying or limp to standing: fold the legs under the body first."""
    return Motion(joints, [Frame(0.8, LIE), *TO_STAND])
