"""Injects faults into the simulation on request, to test a guard: `POST /faults` on the room's HTTP server.

    {"robot": "go2", "ranges": "missing", "silent": true, "jump_m": [1.0, 0.0], "box_m": [0.5, -0.2]}

All keys are optional. A request replaces all faults of its robot (the Go2 by default); `{}` ends all faults of all
robots.

- `ranges`: `good`, `missing` (NaN), `zero`, or `constant` (frozen at their current values).
- `silent`: the robot obeys commands but publishes no state.
- `jump_m`: its odometry jumps once by this much along its own x and y. `lost`: its odometry is NaN.
- `drops`: this share of the requests to its motion service is lost; with 1 it is frozen and answers none.
- `unplugged`: the robot receives and sends nothing, as if its cable was pulled.
- `camera`: `good`, `dead` (answers with an error), or `black`.
- `battery_percent`: the charge that its battery reports.
- `clock_s`: its own clock, which stamps its states, jumps once by this much.
- `push_mps`: it is pushed once, forward and to the left. `tip`: it is tipped onto its back.
- `box_m`: a box 40 cm wide and 60 cm high appears at this place of the room.

A G1 has no ranges and no battery.
"""

from __future__ import annotations

import io
import math
import random
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from agentrob.errors import SimError

if TYPE_CHECKING:
    from agentrob.sim.world.legged import Legged

_WORDS = {"ranges": ("good", "missing", "zero", "constant"), "camera": ("good", "dead", "black")}
_SWITCHES, _PAIRS = ("silent", "lost", "unplugged", "tip"), ("jump_m", "push_mps", "box_m")
_BOUNDS = {"drops": (0.0, 1.0), "battery_percent": (0.0, 100.0), "clock_s": (-1e6, 1e6)}
KEYS = (
    "robot", "ranges", "silent", "jump_m", "lost", "drops", "unplugged", "camera", "battery_percent", "clock_s",
    "push_mps", "tip", "box_m",
)  # fmt: skip
#: A body is rolled at this rate, for at most this long, until the cosine of its tilt is below this: it lies on its back
#: then. From its side the legs of a Go2 that walks would push it upright again.
TIPPED, ROLL_RPS, TIP_S = -0.65, 7.0, 1.5
HARDEST_PUSH_MPS = 3.0


@dataclass(frozen=True, slots=True)
class Faults:
    """The faults of one robot; see the module docstring."""

    robot: str
    ranges: str = "good"
    silent: bool = False
    jump_m: tuple[float, float] = (0.0, 0.0)
    box_m: tuple[float, float] | None = None
    lost: bool = False
    drops: float = 0.0
    unplugged: bool = False
    camera: str = "good"
    battery_percent: float | None = None
    clock_s: float = 0.0
    push_mps: tuple[float, float] = (0.0, 0.0)
    tip: bool = False


def read(data: Any, robots: Collection[str], size_m: tuple[float, float]) -> Faults:
    """Parse the faults for a room of this length and width. Raises `SimError`, which says what is valid."""
    if not isinstance(data, Mapping):
        raise SimError(f"faults are a JSON object; valid keys: {', '.join(KEYS)}")
    if unknown := sorted(set(data) - set(KEYS)):
        raise SimError(f"unknown fault {unknown[0]!r}; valid: {', '.join(KEYS)}")
    robot = data.get("robot", "go2" if "go2" in robots else min(robots))
    if robot not in robots:
        raise SimError(f"unknown robot {robot!r}; robots in this world: {', '.join(sorted(robots))}")
    given = {key: _value(key, value) for key, value in data.items() if value is not None}
    faults = Faults(**{**given, "robot": robot})
    x_m, y_m = (edge / 2 for edge in size_m)
    if faults.box_m is not None and not (abs(faults.box_m[0]) < x_m and abs(faults.box_m[1]) < y_m):
        raise SimError(f"'box_m' must be in the room: x within {x_m:g} m, y within {y_m:g} m")
    if math.hypot(*faults.push_mps) > HARDEST_PUSH_MPS:
        raise SimError(f"'push_mps' must be at most {HARDEST_PUSH_MPS:g} m/s in all")
    return faults


def _value(key: str, value: Any) -> Any:
    """Validate one value."""
    if (valid := _WORDS.get(key)) is not None and value not in valid:
        raise SimError(f"{key} cannot be {value!r}; valid: {', '.join(valid)}")
    if key in _SWITCHES and not isinstance(value, bool):
        raise SimError(f"{key!r} must be true or false")
    if key in _BOUNDS:
        return _number(value, key, *_BOUNDS[key])
    return _pair(value, key) if key in _PAIRS else value


def _pair(value: Any, name: str) -> tuple[float, float]:
    try:
        x, y = (float(v) for v in value)
    except (TypeError, ValueError):
        x = y = math.nan
    if not (abs(x) < 100 and abs(y) < 100):
        raise SimError(f"{name!r} must be two numbers, forward and left (of a place: x and y)")
    return x, y


def _number(value: Any, name: str, least: float, most: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
        raise SimError(f"{name!r} must be a number from {least:g} to {most:g}")
    return float(value)


class FaultState:
    """Applies one robot's faults to its services and its body. `make` and `tick` run in the world's thread."""

    def __init__(self, body: Legged) -> None:
        self._body = body
        self._chance = random.Random(7)
        self._tipping_s = 0.0
        self.now = Faults(body.name)

    def make(self, faults: Faults) -> None:
        """Replace the faults; apply those that happen once."""
        self.now, body = faults, self._body
        vx, vy = faults.push_mps
        c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
        body.data.qvel[body.root_v] += c * vx - s * vy
        body.data.qvel[body.root_v + 1] += s * vx + c * vy
        self._tipping_s = TIP_S if faults.tip else 0.0

    def tick(self, period_s: float) -> None:
        """Roll a robot that is being tipped. Call once per period, before the physics."""
        if self._tipping_s <= 0:
            return
        tipped = self._body.upright <= TIPPED
        self._tipping_s = 0.0 if tipped else self._tipping_s - period_s
        # Over its left side; without an end of the roll it would sometimes go on over the back onto the feet.
        self._body.data.qvel[self._body.root_v + 3] = 0.0 if tipped else -ROLL_RPS

    def swallows(self) -> bool:
        """Decide whether a request to the motion service is lost. Call once per request."""
        return self.now.unplugged or self._chance.random() < self.now.drops

    @property
    def mute(self) -> bool:
        """Whether the robot publishes no state."""
        return self.now.silent or self.now.unplugged


def black_picture() -> bytes:
    """The picture of a covered camera: a black JPEG of the usual size."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.new("RGB", (640, 480)).save(buffer, "JPEG", quality=80)
    return buffer.getvalue()
