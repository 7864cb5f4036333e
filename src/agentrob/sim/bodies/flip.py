"""The Go2's backflip: an animation, not physics, and whether there is room for it.

The walking policy cannot flip, so the whole body follows key frames: crouch, up and over backwards, land. It would pass
through objects, so nothing may be near. Once in the air it cannot be interrupted, as on a real robot.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from agentrob.sim.world import room
from agentrob.sim.world.legged import Array, Legged
from agentrob.sim.world.world import FIRST_ROBOT_GROUP, MOST_ROBOTS

SECONDS = 1.6
RISE_M, CROUCH_M = 0.40, 0.13  # the middle of the body: up from where it stands, and down from there before and after
AIRBORNE = (0.22, 0.78)  # of the time
CROUCHED_RAD: Array = np.array([0, 1.25, -2.3] * 4)
TUCKED_RAD: Array = np.array([0, 1.3, -2.5] * 4)

Groups = NDArray[np.uint8]  # (6,) which groups of shapes rays meet

#: Nothing but the floor may be within this around the body's middle and above the floor.
AROUND_M, ABOVE_M = 0.85, 1.4
HEIGHTS_M = (0.10, 0.30, 0.60, 0.90, 1.20)
DIRECTIONS = 36


def _passed(u: float, begin: float, end: float) -> float:
    """Smoothstep: 0 before `begin`, 1 after `end`, smooth in between."""
    return (1 - math.cos(math.pi * min(1.0, max(0.0, (u - begin) / (end - begin))))) / 2


class Flight:
    """From a standing pose: for each time the rise (m), the pitch (rad, nose down is positive) and the joints."""

    seconds = SECONDS

    def __init__(self, start: Array) -> None:
        self._start = start

    def __call__(self, t: float) -> tuple[float, float, Array] | None:
        u = t / SECONDS
        if u >= 1:
            return None
        takes_off, lands = AIRBORNE
        crouch = _passed(u, 0, 0.18) - _passed(u, 0.18, takes_off + 0.04)
        crouch += _passed(u, lands - 0.02, lands + 0.04) - _passed(u, lands + 0.04, 1)
        tuck = _passed(u, takes_off + 0.04, 0.38) - _passed(u, 0.62, lands - 0.02)
        air = min(1.0, max(0.0, (u - takes_off) / (lands - takes_off)))
        joints = self._start + crouch * (CROUCHED_RAD - self._start) + tuck * (TUCKED_RAD - self._start)
        rise_m = RISE_M * 4 * air * (1 - air) - CROUCH_M * crouch
        return rise_m, -2 * math.pi * air * air * (3 - 2 * air), joints

    @staticmethod
    def airborne(t: float) -> bool:
        return AIRBORNE[0] <= t / SECONDS <= AIRBORNE[1]


def clear(body: Legged) -> bool:
    """Whether nothing is near, including other robots; casts rays to all sides at several heights, and upwards."""
    groups = np.zeros(6, np.uint8)
    groups[[room.ROOM_GROUP, room.NEAR_WALL_GROUP]] = 1
    groups[FIRST_ROBOT_GROUP : FIRST_ROBOT_GROUP + MOST_ROBOTS] = 1
    groups[int(body.model.geom_group[np.flatnonzero(body.geoms)].max())] = 0
    angles = np.linspace(0, 2 * math.pi, DIRECTIONS, endpoint=False)
    around = np.stack([np.cos(angles), np.sin(angles), np.zeros(DIRECTIONS)], axis=1)
    x, y = body.xy_m
    if any(_nearest_m(body, groups, np.array([x, y, z]), around) < AROUND_M for z in HEIGHTS_M):
        return False
    up = np.array([[0.0, 0.0, 1.0]])
    corners = [(x + dx, y + dy) for dx in (-0.3, 0.0, 0.3) for dy in (-0.3, 0.0, 0.3)]
    return all(_nearest_m(body, groups, np.array([*at, 0.1]), up) > ABOVE_M - 0.1 for at in corners)


def _nearest_m(body: Legged, groups: Groups, origin: Array, rays: Array) -> float:
    """Metres to the nearest hit of any of the unit vectors (n, 3); infinity without a hit."""
    count = len(rays)
    hits, distances = np.zeros(count, np.int32), np.zeros(count)
    mujoco.mj_multiRay(
        body.model, body.data, origin, rays.ravel(), groups, True, -1, hits, distances, None, count, 5.0
    )  # fmt: skip
    return float(np.where(distances < 0, math.inf, distances).min())
