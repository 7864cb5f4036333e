"""What a robot can be asked to do: operations, steps and plans."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any


class Op(StrEnum):
    """The operations of robots, as data calls them (tools that a VLM sees are named `act_move`, …)."""

    MOVE = "move"
    TURN = "turn"
    HELLO = "hello"
    HEART = "heart"
    CLAP = "clap"
    SHAKE = "shake"
    BACKFLIP = "backflip"
    SIT = "sit"
    STAND = "stand"
    STRETCH = "stretch"
    GET_FRONT_IMAGE = "get_front_image"


class Direction(StrEnum):
    """Of a move: all four. Of a turn: left (counter-clockwise) or right."""

    FORWARD = "forward"
    BACKWARD = "backward"
    LEFT = "left"
    RIGHT = "right"

    @property
    def unit_vector(self) -> tuple[float, float]:
        """(forward, left) in the robot's frame."""
        return _UNIT_VECTORS[self]


_UNIT_VECTORS = {
    Direction.FORWARD: (1.0, 0.0),
    Direction.BACKWARD: (-1.0, 0.0),
    Direction.LEFT: (0.0, 1.0),
    Direction.RIGHT: (0.0, -1.0),
}


@dataclass(frozen=True, slots=True)
class Primitive:
    """One step for a robot.

    `move` has `direction`, `distance_m` and perhaps `speed_mps`; `turn` has `direction` and `degrees`; the others have
    nothing. Distances and degrees are positive.
    """

    op: Op
    direction: Direction | None = None
    distance_m: float | None = None
    degrees: float | None = None
    speed_mps: float | None = None

    def asked(self) -> dict[str, Any]:
        """What is asked, as data: only the fields that this operation has."""
        fields = asdict(self)
        return {k: (str(v) if isinstance(v, StrEnum) else v) for k, v in fields.items() if k != "op" and v is not None}

    @property
    def moves(self) -> bool:
        """Whether the robot's body moves at all."""
        return self.op is not Op.GET_FRONT_IMAGE


@dataclass(frozen=True, slots=True)
class Plan:
    """Steps in order. `notes` are assumptions the reply must state ("turn left" was taken as 90°)."""

    steps: tuple[Primitive, ...] = ()
    notes: tuple[str, ...] = ()

    def as_data(self) -> list[dict[str, Any]]:
        """The steps as data: each operation with what is asked of it."""
        return [{"op": str(step.op), **step.asked()} for step in self.steps]

    @property
    def distance_m(self) -> float:
        """Sum of all moves."""
        return sum(s.distance_m or 0.0 for s in self.steps)

    @property
    def moves(self) -> bool:
        return any(s.moves for s in self.steps)
