"""The operations that need no declaration by a robot: how the house calls walking, turning, gestures and photos."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType

from agentrob.model.accounts import ActionClass
from agentrob.model.operations.declaration import BaseMotion, Choice, Number, Operation, Option, Quantity, Unit


class Op(StrEnum):
    """The names of the built-in operations (tools that a VLM sees are named `act_move`, …)."""

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

_ANY, _SIDES = tuple(Direction), (Direction.LEFT, Direction.RIGHT)
_LONGEST_M, _WIDEST_DEG, _FASTEST_MPS = 100.0, 3600.0, 10.0


def _directions(of: tuple[Direction, ...]) -> Choice:
    """A direction; its words are in the tables of the languages."""
    return Choice("direction", tuple(Option(direction.value, {"en": direction.value}) for direction in of))


#: How long gestures take is measured, the longer one where two robots do it (`docs/robots/gestures.md`).
_DECLARED = (
    Operation(
        Op.MOVE.value, ActionClass.MOVE, base_motion=BaseMotion.TRANSLATION, travel_m=_LONGEST_M,
        measured=(Quantity("distance_m", Unit.METRES),),
        arguments=(_directions(_ANY), Number("distance_m", Unit.METRES, 0.0, _LONGEST_M),
                   Number("speed_mps", Unit.METRES_PER_SECOND, 0.0, _FASTEST_MPS, optional=True)),
    ),
    Operation(
        Op.TURN.value, ActionClass.MOVE, base_motion=BaseMotion.ROTATION, travel_m=0.3,
        measured=(Quantity("degrees", Unit.DEGREES),),
        arguments=(_directions(_SIDES), Number("degrees", Unit.DEGREES, 0.0, _WIDEST_DEG)),
    ),
    Operation(Op.HELLO.value, ActionClass.GESTURE, takes_s=8.0, harmless=True),
    Operation(Op.HEART.value, ActionClass.GESTURE, takes_s=13.0, harmless=True),
    Operation(Op.CLAP.value, ActionClass.GESTURE, takes_s=6.0, harmless=True),
    Operation(Op.SHAKE.value, ActionClass.GESTURE, takes_s=8.0),
    Operation(Op.BACKFLIP.value, ActionClass.RISKY, takes_s=6.0, travel_m=1.0, consent="flip"),
    Operation(Op.SIT.value, ActionClass.GESTURE, takes_s=3.0),
    Operation(Op.STAND.value, ActionClass.GESTURE, takes_s=3.0),
    Operation(Op.STRETCH.value, ActionClass.GESTURE, takes_s=8.0),
    Operation(Op.GET_FRONT_IMAGE.value, ActionClass.PHOTO, takes_s=1.0, picture=True),
)  # fmt: skip
#: The built-in operations by name, in the order in which robots list them.
BUILT_IN: Mapping[str, Operation] = MappingProxyType({operation.name: operation for operation in _DECLARED})
#: The operation that "a photo" asks for.
PHOTO = next(Op(operation.name) for operation in _DECLARED if operation.picture)
#: How long a step of an operation is assumed to take of which nothing is known.
LONGEST_S = max(operation.takes_s for operation in _DECLARED)


_BY_NAME: Mapping[str, Op] = {op.value: op for op in Op}


def named(name: str) -> str:
    """Return the name of an operation, of a built-in one as its `Op`."""
    return _BY_NAME.get(name, name)


def undeclared(name: str) -> Operation:
    """Return what is assumed of an operation of this name that nobody declares here, as in the record of a robot that
    is gone: the worst."""
    words = " ".join(name.replace("_", " ").split())[:40] or "?"
    try:
        return Operation(name, ActionClass.RISKY, {"en": words}, takes_s=LONGEST_S)
    except ValueError:
        return Operation("unknown", ActionClass.RISKY, takes_s=LONGEST_S)
