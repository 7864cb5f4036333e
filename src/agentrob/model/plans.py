"""Steps and plans: the motions that a robot is to make."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

from agentrob.model.accounts import ActionClass
from agentrob.model.operations.built_in import BUILT_IN, Direction, Op, named, undeclared
from agentrob.model.operations.declaration import MOST_ARGUMENTS, BaseMotion, Operation, Value, check_name

#: The arguments of walking and turning, which are fields of a step.
FIELDS = ("direction", "distance_m", "degrees", "speed_mps")


@dataclass(frozen=True, slots=True)
class Primitive:
    """One step for a robot.

    `move` has `direction`, `distance_m` and perhaps `speed_mps`; `turn` has `direction` and `degrees`; an operation
    that a robot declares has `arguments`, as pairs (name, value); the others have nothing. Distances and degrees are
    positive. `declared` is the declaration of an operation that is not built in, as far as it is known; it does
    not belong to what is asked.
    """

    op: str
    direction: Direction | None = None
    distance_m: float | None = None
    degrees: float | None = None
    speed_mps: float | None = None
    arguments: tuple[tuple[str, Value], ...] = ()
    declared: Operation | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.op, Op):  # a built-in operation is its `Op`, also where it was read from data
            check_name(self.op, "operation")
            object.__setattr__(self, "op", named(self.op))

    @property
    def operation(self) -> Operation:
        """The declaration of the operation; where it is not known, the worst is assumed."""
        return self.declared or BUILT_IN.get(self.op) or undeclared(self.op)

    @property
    def base_motion(self) -> BaseMotion | None:
        """How it carries the base along a path that is known; None if it does not, or nobody knows how."""
        return self.operation.base_motion

    @property
    def translates(self) -> bool:
        """Whether it goes straight: `direction`, `distance_m` and perhaps `speed_mps` say how."""
        return self.base_motion is BaseMotion.TRANSLATION

    @property
    def rotates(self) -> bool:
        """Whether it turns on the spot: `direction` and `degrees` say how."""
        return self.base_motion is BaseMotion.ROTATION

    @property
    def walks(self) -> bool:
        """Whether it is a walk or a turn, whose path is known."""
        return self.base_motion is not None

    @property
    def well_formed(self) -> bool:
        """Whether the fields that belong to its motion are set, and no others, and amounts are positive and finite: a
        negative walk would extend a mandate. `Operation.objection` checks arguments."""
        if self.translates:
            valid_speed = self.speed_mps is None or _positive(self.speed_mps)
            return self.direction is not None and self.degrees is None and _positive(self.distance_m) and valid_speed
        if self.rotates:
            to_a_side = self.direction in (Direction.LEFT, Direction.RIGHT)
            return to_a_side and self.distance_m is None and self.speed_mps is None and _positive(self.degrees)
        return replace(self, arguments=()) == Primitive(self.op)

    @property
    def turns_in_place(self) -> bool:
        """Whether it is a turn by a robot that declares that its turns do not take it from its place at all: its foot
        stays, and a turn needs no more space than it declares."""
        return self.rotates and self.declared is not None and self.declared.most_travel_m == 0

    @property
    def travel_m(self) -> float:
        """How far at most it takes the robot, as limits and mandates count it: what is asked of a walk, what is
        declared of an operation of the robot's own."""
        if self.op in BUILT_IN:
            return self.distance_m or 0.0
        leaves = self.operation.action_class in (ActionClass.MOVE, ActionClass.RISKY)
        return self.operation.most_travel_m if leaves else 0.0

    def value(self, name: str) -> Any:
        """Return what an argument of this name is set to; None if it is not set."""
        return getattr(self, name) if name in FIELDS else dict(self.arguments).get(name)

    def asked(self) -> dict[str, Any]:
        """The step as data, with only the fields that its operation has."""
        fields = {name: getattr(self, name) for name in FIELDS} | dict(self.arguments)
        return {k: (str(v) if isinstance(v, StrEnum) else v) for k, v in fields.items() if v is not None}

    @property
    def moves(self) -> bool:
        """Whether the robot's body moves at all."""
        return self.operation.moves


def _positive(amount: float | None) -> bool:
    return amount is not None and math.isfinite(amount) and amount > 0


def walk(direction: Direction, distance_m: float | None, speed_mps: float | None = None) -> Primitive:
    """Return a walk straight ahead, back or sideways; without a speed the robot takes its own."""
    return Primitive(Op.MOVE, direction, distance_m=distance_m, speed_mps=speed_mps)


def turn(direction: Direction, degrees: float | None) -> Primitive:
    """Return a turn on the spot, to the left (counter-clockwise) or to the right."""
    return Primitive(Op.TURN, direction, degrees=degrees)


def step_of(data: Mapping[str, Any]) -> Primitive:
    """Read a step as `Plan.as_data` and records have it: what is not a field of walking is an argument.

    Raises `ValueError` if it is not a step.
    """
    direction = data.get("direction")
    amounts = {name: data.get(name) for name in FIELDS[1:]}
    arguments = {k: v for k, v in data.items() if k not in ("op", *FIELDS)}
    for name, value in (*amounts.items(), *arguments.items()):
        is_choice = isinstance(value, str) and name in arguments
        if not is_choice and value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise ValueError(f"{name} must be a number (found {str(value)[:40]!r})")
    if not isinstance(data.get("op"), str) or len(arguments) > MOST_ARGUMENTS:
        raise ValueError(f"a step needs an operation and at most {MOST_ARGUMENTS} arguments")
    pairs = tuple((str(k), v if isinstance(v, str) else float(v)) for k, v in arguments.items() if v is not None)
    return Primitive(data["op"], None if direction is None else Direction(direction), **amounts, arguments=pairs)


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
        return sum(s.travel_m for s in self.steps)

    @property
    def moves(self) -> bool:
        return any(s.moves for s in self.steps)
