"""Convert units of length, angle and speed to metres, degrees and metres per second. Pure."""

from __future__ import annotations

import math
from enum import StrEnum


class Unit(StrEnum):
    """Units that a model may name. We convert them ourselves, because small models write 50 m for 50 cm."""

    M = "m"
    CM = "cm"
    MM = "mm"
    KM = "km"
    FT = "ft"
    IN = "in"
    YD = "yd"
    DEG = "deg"
    RAD = "rad"
    TURN = "turn"


class SpeedUnit(StrEnum):
    MPS = "m/s"
    CMPS = "cm/s"
    FTPS = "ft/s"
    KMPH = "km/h"
    MPH = "mph"


METRES: dict[Unit, float] = {
    Unit.M: 1.0,
    Unit.CM: 0.01,
    Unit.MM: 0.001,
    Unit.KM: 1000.0,
    Unit.FT: 0.3048,
    Unit.IN: 0.0254,
    Unit.YD: 0.9144,
}
DEGREES: dict[Unit, float] = {Unit.DEG: 1.0, Unit.RAD: math.degrees(1.0), Unit.TURN: 360.0}
MPS: dict[SpeedUnit, float] = {
    SpeedUnit.MPS: 1.0,
    SpeedUnit.CMPS: 0.01,
    SpeedUnit.FTPS: 0.3048,
    SpeedUnit.KMPH: 1 / 3.6,
    SpeedUnit.MPH: 0.44704,
}


def metres(amount: float, unit: Unit) -> float | None:
    """Return metres, None if the unit is not a length."""
    factor = METRES.get(unit)
    return None if factor is None else amount * factor


def degrees(amount: float, unit: Unit) -> float | None:
    """Return degrees, None if the unit is not an angle."""
    factor = DEGREES.get(unit)
    return None if factor is None else amount * factor


def same(one: float, other: float) -> bool:
    """Return whether two amounts are equal within one per cent, for rounding in conversions (0.61 m for 2 ft)."""
    return abs(one - other) <= 0.01 * max(abs(one), abs(other)) + 1e-9
