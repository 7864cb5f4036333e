"""Requests for previews in the shipped room."""

from __future__ import annotations

import math
from typing import Any

from agentrob.model import Direction, Op, Plan, Pose, Primitive
from agentrob.rehearsal.preview import PreviewRequest
from agentrob.wiring.app import simulated_robot

F, B, L, R = Direction


def walk(metres: float, direction: Direction = F, **more: Any) -> Primitive:
    return Primitive(Op.MOVE, direction, distance_m=metres, **more)


def turn(degrees: float, direction: Direction = L) -> Primitive:
    return Primitive(Op.TURN, direction, degrees=degrees)


def request(*steps: Primitive, model: str = "go2", **changed: Any) -> PreviewRequest:
    """A robot at its home in the room."""
    settings = simulated_robot(model, 0).model_copy(update=changed.pop("settings", {}))
    (x_m, y_m), facing = settings.map.home_at_m, math.radians(settings.map.home_facing_deg)
    home = Pose(x_m, y_m, facing)
    given: dict[str, Any] = {"start": home, "home": home, "least_runs": 2, "most_runs": 2, **changed}
    return PreviewRequest(model, settings, Plan(tuple(steps)), **given)
