"""A robot's capabilities and state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime

from agentrob.model.operations.built_in import BUILT_IN, Direction
from agentrob.model.operations.declaration import CLASS_WORDS, BaseMotion, Operation
from agentrob.model.plans import FIELDS, Primitive


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds of one robot (law 10). Beyond them a command is refused with the limit named."""

    speed_mps: float = 0.5
    turn_dps: float = 45.0
    step_m: float = 5.0
    step_deg: float = 360.0
    command_m: float = 10.0
    command_s: float = 60.0
    command_steps: int = 10


@dataclass(frozen=True, slots=True)
class Capabilities:
    """A robot's operations and limits, readable before it is connected. `model` is go2, g1, fake, …

    `ops` are the names of its operations: the built-in ones that it has, and those that it declares. `declared` are
    its own operations, and built-in ones that it does in a way of its own (`dataclasses.replace` of the built-in
    declaration: other times, free space or words, not another class or other arguments).

    Raises `ValueError` with a sentence for operations that nobody declares, and for declarations that do not fit.
    """

    model: str
    ops: frozenset[str]
    limits: Limits = Limits()
    move_directions: frozenset[Direction] = frozenset(Direction)
    simulated: bool = False
    declared: tuple[Operation, ...] = ()

    def __post_init__(self) -> None:
        names = [operation.name for operation in self.declared]
        if len(set(names)) < len(names):
            raise ValueError(f"an operation is declared twice: {', '.join(sorted(names))}")
        for operation in self.declared:
            _check_declaration(operation)
        object.__setattr__(self, "ops", frozenset(self.ops) | frozenset(names))
        if unknown := sorted(op for op in self.ops if op not in BUILT_IN and op not in names):
            raise ValueError(
                f"the operation {unknown[0]!r} is not built in: declare it (`declared`), "
                f"or use some of {', '.join(BUILT_IN)}"
            )

    @property
    def operations(self) -> tuple[Operation, ...]:
        """The declarations of all that it can do: the built-in ones first, its own in its order."""
        own = {operation.name: operation for operation in self.declared}
        built_in = [own.get(name, operation) for name, operation in BUILT_IN.items() if name in self.ops]
        return (*built_in, *(operation for name, operation in own.items() if name not in BUILT_IN))

    def operation(self, name: str) -> Operation | None:
        """Return the declaration of one of its operations; None if it has no such operation."""
        if name not in self.ops:
            return None
        return next((own for own in self.declared if own.name == name), BUILT_IN.get(name))

    def does(self, motion: BaseMotion) -> bool:
        """Return whether it has an operation that moves its base like this."""
        return any(operation.base_motion is motion for operation in self.operations)

    def can_do(self, step: Primitive) -> bool:
        """Return whether it has the operation of a step, and walks in its direction. Limits are another matter."""
        return step.op in self.ops and (not step.translates or step.direction in self.move_directions)

    def bound(self, step: Primitive) -> Primitive:
        """Return the step with this robot's own declaration of its operation."""
        own = next((own for own in self.declared if own.name == step.op), None)
        return step if own == step.declared else replace(step, declared=own)


def _check_declaration(operation: Operation) -> None:
    built_in = BUILT_IN.get(operation.name)
    if built_in is None:
        if taken := sorted({"op", *FIELDS} & {argument.name for argument in operation.arguments}):
            raise ValueError(
                f"the argument {taken[0]!r} of the operation {operation.name!r} is one of walking and turning: "
                f"name it otherwise, such as {operation.name}_{taken[0]}"
            )
        if operation.base_motion is not None:
            raise ValueError(
                f"the operation {operation.name!r} declares a base motion, which only the built-in walk and turn have: "
                "declare how far it travels (travel_m)"
            )
        if not operation.words:
            raise ValueError(f"the operation {operation.name!r} needs words that ask for it, at least in English (en)")
    elif _form(operation) != _form(built_in):
        raise ValueError(
            f"the operation {operation.name!r} is built in, as {CLASS_WORDS[built_in.action_class]}: declare it with "
            "the same class, arguments and base motion, or under another name"
        )


def _form(operation: Operation) -> tuple[object, ...]:
    """The parts of a built-in operation that a robot's own declaration of it may not change."""
    return operation.action_class, operation.arguments, operation.base_motion


@dataclass(frozen=True, slots=True)
class Pose:
    """Odometry: metres and radians in the robot's own odometry frame."""

    x_m: float
    y_m: float
    yaw_rad: float


#: Why a robot is locked when somebody asked for it; other reasons are sentences of its guard.
EMERGENCY_STOP = "an emergency stop"


@dataclass(frozen=True, slots=True)
class Lock:
    """An emergency stop that holds until the robot's owner releases it: who set it, why, and when by the clock of the
    robot's machine. `by` is empty and `at` None where that is not known; both texts are untrusted."""

    by: str
    why: str
    at: datetime | None = None


@dataclass(frozen=True, slots=True)
class RobotState:
    """The last known state of a robot. `None` means unknown, and unknown is never taken as good.

    `age_s`: age of the newest state message. `ranges_m`: front, left, back, right. `mode`: idle, walking, gesture,
    sitting, lying, damping, locked, fallen, unknown. `halted`: it refuses all motion, and `lock` says since when.
    """

    age_s: float
    pose: Pose | None = None
    velocity_mps: tuple[float, float] | None = None
    yaw_rate_rps: float | None = None
    mode: str = "unknown"
    battery_percent: float | None = None
    ranges_m: tuple[float | None, float | None, float | None, float | None] = (None, None, None, None)
    upright: bool | None = None
    homed: bool = False
    halted: bool = False
    error_code: int | None = None
    lock: Lock | None = None


@dataclass(frozen=True, slots=True)
class Posture:
    """How the robot holds its body now, by its own sensors, for the live view.

    `pose` is odometry in the frame of its home (x forward at home), None without a home or a position. `height_m` is
    that of the base. `tilt` is the base's attitude without its yaw, as a quaternion (w, x, y, z). `joints_rad` are in
    the order of the robot's motors, empty if they are not known.
    """

    age_s: float
    pose: Pose | None = None
    height_m: float | None = None
    tilt: tuple[float, float, float, float] | None = None
    joints_rad: tuple[float, ...] = ()


#: A driver whose robot holds a zone is heard ten times a second.
SILENT_S = 5.0


@dataclass(frozen=True, slots=True)
class Hindrance:
    """Why a robot may not move now in the room that it shares with others.

    `reason` is a stable word: `room_busy` (`robot` moves there, or waits and asked earlier), `room_blocked` (`robot`
    stands in the way), `robot_near` (it came near), `room_unreachable`, `room_lost`, `room_restless` (the robot itself
    has not come to rest). `doing` is the operation of `robot`, or `wait`; `silent_s` how long its driver has been
    silent. `sentence` is for people who read English.
    """

    reason: str
    sentence: str
    robot: str = ""
    doing: str = ""
    silent_s: float = 0.0

    @property
    def passes(self) -> bool:
        """Whether waiting helps: another robot moves there now, or this one is coming to rest."""
        return self.reason in ("room_busy", "room_restless")

    @property
    def silent(self) -> bool:
        """Whether the other robot's driver has not been heard for so long that it may be dead."""
        return self.silent_s > SILENT_S
