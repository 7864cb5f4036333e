"""Faults that the room makes on request, for trying out a guard: `POST /faults` on the room's HTTP server.

    {"robot": "go2", "ranges": "missing", "silent": true, "jump_m": [1.0, 0.0], "box_m": [0.5, -0.2]}

All keys may be left out, and what is left out is well again: `{}` heals everything. `ranges` are `good`, `missing` (not
a number), `zero`, or `constant` (they stay what they are now). `silent`: the robot does all it is told, but sends no
state. `jump_m`: its odometry jumps once by this much along its own x and y. `box_m`: a box 40 cm wide and 60 cm high
stands on this place of the room from now on.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from agentrob.errors import SimError

RANGES = ("good", "missing", "zero", "constant")
KEYS = ("robot", "ranges", "silent", "jump_m", "box_m")


@dataclass(frozen=True, slots=True)
class Faults:
    """See the module's text."""

    robot: str
    ranges: str = "good"
    silent: bool = False
    jump_m: tuple[float, float] = (0.0, 0.0)
    box_m: tuple[float, float] | None = None


def read(data: Any, robots: Collection[str], size_m: tuple[float, float]) -> Faults:
    """What was asked for in a room of this length and width. Raises `SimError` that says what would be valid."""
    if not isinstance(data, Mapping):
        raise SimError(f"faults are a JSON object; valid keys: {', '.join(KEYS)}")
    if unknown := sorted(set(data) - set(KEYS)):
        raise SimError(f"{unknown[0]!r} is no fault; valid: {', '.join(KEYS)}")
    robot, ranges, silent = data.get("robot", min(robots)), data.get("ranges", "good"), data.get("silent", False)
    if robot not in robots:
        raise SimError(f"no robot {robot!r} in this world; there are: {', '.join(sorted(robots))}")
    if ranges not in RANGES:
        raise SimError(f"ranges cannot be {ranges!r}; valid: {', '.join(RANGES)}")
    if not isinstance(silent, bool):
        raise SimError("'silent' must be true or false")
    box_m = _pair(data["box_m"], "box_m") if data.get("box_m") is not None else None
    x_m, y_m = (edge / 2 for edge in size_m)
    if box_m is not None and not (abs(box_m[0]) < x_m and abs(box_m[1]) < y_m):
        raise SimError(f"'box_m' must be in the room: x within {x_m:g} m, y within {y_m:g} m")
    return Faults(robot, ranges, silent, _pair(data.get("jump_m", (0.0, 0.0)), "jump_m"), box_m)


def _pair(value: Any, name: str) -> tuple[float, float]:
    try:
        x, y = (float(v) for v in value)
    except (TypeError, ValueError):
        x = y = math.nan
    if not (abs(x) < 100 and abs(y) < 100):
        raise SimError(f"{name!r} must be two numbers of metres, x and y")
    return x, y
