"""Tracks range readings: which sides are free, blocked or unknown (law 8). Pure arithmetic.

Readings are in the order front, left, back, right. Whether a Go2 counts them from its middle or from its outline is not
verified; here they are taken as from the middle, which keeps the greater distance.
"""

from __future__ import annotations

import math
import re

from agentrob.model import Direction, Op, Primitive, RobotState
from agentrob.robots.protocol import BODY_RADIUS_M

#: A reading must have changed within this time: a working sensor always shows some noise.
WINDOW_S = 1.0
#: A state older than this carries no new reading.
FRESH_S = 0.2
#: How many readings are needed before any is trusted, and how many are kept.
SAMPLES, MOST_SAMPLES = 5, 100
#: From the middle of the body to its hull: front, left, back, right (Go2).
HULL_M = (0.35, 0.16, 0.35, 0.16)
#: Free space between hull and obstacle after the robot has come to rest.
MARGIN_M = 0.15
#: Free space at the flanks of a moving body.
FLANK_M = 0.05
#: A body moves on for about this long after an obstacle appears (measured: coasting 0.25 s, sensing and sending 0.1 s).
STOPPING_S = 0.35

SIDES = {Direction.FORWARD: 0, Direction.LEFT: 1, Direction.BACKWARD: 2, Direction.RIGHT: 3}
NAMES = ("ahead", "to the left", "behind", "to the right")
_OBSTACLE = "Something is {distance} m {side}; this step needs {needed} m there."
_AMOUNT = r"(\d+\.\d+)"
_OBSTACLE_READ = re.compile(
    re.escape(_OBSTACLE)
    .replace(r"\{distance\}", _AMOUNT)
    .replace(r"\{needed\}", _AMOUNT)
    .replace(r"\{side\}", f"({'|'.join(NAMES)})")
)


def needed_m(side: int, speed_mps: float) -> float:
    """How far an obstacle must be away while moving towards it."""
    return HULL_M[side] + MARGIN_M + speed_mps * STOPPING_S


class RangeMonitor:
    """Keeps one second of readings. A thread may read while another updates: the tuple is replaced, never changed."""

    def __init__(self) -> None:
        self._seen: tuple[tuple[float, tuple[float | None, ...]], ...] = ()

    def update(self, now_s: float, state: RobotState) -> None:
        """Add the readings of a state; an old state repeats earlier readings and is not added."""
        kept = tuple(s for s in self._seen[-MOST_SAMPLES:] if s[0] >= now_s - WINDOW_S)
        self._seen = (*kept, (now_s, state.ranges_m)) if state.age_s < FRESH_S else kept

    @property
    def enough(self) -> bool:
        return len(self._seen) >= SAMPLES

    @property
    def settled(self) -> bool:
        """Whether a full window was recorded: waiting longer will not make an unknown side known."""
        return self.enough and self._seen[-1][0] - self._seen[0][0] >= 0.8 * WINDOW_S

    def known(self) -> tuple[float | None, ...]:
        """The newest reading of each side; None when it is missing, zero, or did not change within the window."""
        if not self.enough:
            return (None,) * 4
        return tuple(self._known(side) for side in range(4))

    def _known(self, side: int) -> float | None:
        values = [ranges[side] for _, ranges in self._seen]
        last = values[-1]
        if last is None or not math.isfinite(last) or last <= 0.0 or len(set(values)) == 1:
            return None
        return last

    def unknown(self, primitive: Primitive) -> bool:
        """Whether a side that this step needs is not known."""
        return any(self.known()[side] is None for side in sides(primitive))

    def obstacle(self, primitive: Primitive, speed_mps: float) -> str | None:
        """Return what is too near for this step at this speed, or None."""
        known = self.known()
        for side, limit_m in clearances(primitive, speed_mps):
            if (distance_m := known[side]) is not None and distance_m < limit_m:
                return _OBSTACLE.format(distance=f"{distance_m:.2f}", side=NAMES[side], needed=f"{limit_m:.2f}")
        return None


def obstacle_in(sentence: str) -> tuple[Direction, str, str] | None:
    """Read a sentence of `RangeMonitor.obstacle`, to say it in another language: the side, how far the obstacle is, and
    how far it must be, in metres. None for another sentence."""
    if (found := _OBSTACLE_READ.fullmatch(sentence)) is None:
        return None
    side = next(direction for direction, place in SIDES.items() if NAMES[place] == found[2])
    return side, found[1], found[3]


def clearances(primitive: Primitive, speed_mps: float) -> tuple[tuple[int, float], ...]:
    """Required distance per side: for a move ahead and, less, at both flanks (a wall met at a flat angle).

    An operation that the robot declares needs what it declares on each side, and if it leaves its place as much as a
    move there, since nobody knows which way it goes.
    """
    if not primitive.walks:
        free_m, leaves = primitive.operation.free_space_m, primitive.travel_m > 0
        return tuple((s, max(free_m, needed_m(s, speed_mps) if leaves else 0.0)) for s in sides(primitive))
    if primitive.op is not Op.MOVE:
        return tuple((side, turn_radius_m(primitive)) for side in sides(primitive))
    side = SIDES[primitive.direction or Direction.FORWARD]
    flanks = ((side + 1) % 4, (side + 3) % 4)
    return (side, needed_m(side, speed_mps)), *((flank, HULL_M[flank] + FLANK_M) for flank in flanks)


def sides(primitive: Primitive) -> tuple[int, ...]:
    """The sides that must be free: in the direction of a move, all around for a turn and for an operation that declares
    that it needs free space or leaves its place, none for another gesture."""
    if primitive.op is Op.MOVE:
        return (SIDES[primitive.direction or Direction.FORWARD],)
    if primitive.op is Op.TURN:
        return (0, 1, 2, 3) if turn_radius_m(primitive) > 0 else ()
    around = primitive.operation.free_space_m > 0 or primitive.travel_m > 0
    return (0, 1, 2, 3) if around else ()


def turn_radius_m(primitive: Primitive) -> float:
    """How far everything must be for a turn: farther than the body's corners. A robot that turns on a foot that stays
    declares its turn with `travel_m` 0, and its own `free_space_m` then counts."""
    return primitive.operation.free_space_m if primitive.turns_in_place else BODY_RADIUS_M
