"""What a robot can do and what it says of itself."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from agentrob.model.plans import Direction, Op


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
    """What a robot can do, readable before it is connected. `model` is go2, g1, fake, …"""

    model: str
    ops: frozenset[Op]
    limits: Limits = Limits()
    move_directions: frozenset[Direction] = frozenset(Direction)
    simulated: bool = False


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
    """What is known of a robot now. `None` means unknown, and unknown is never taken as good.

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
