"""A fake robot without physics, a disc that moves in a room, for tests and demonstrations, with injectable faults.

    [robots.spot]
    model = "fake"
    options = { time_scale = 10, room = [-3, 3, -3, 3], obstacles = [[2, 0, 0.3]], faults = { stale = true } }

`time_scale` is how much faster than real time it runs; with `inf`, steps take no time. It accelerates and coasts with a
time constant of 0.15 s, holds a command for one second as real robots do, and its odometry is exact. `things` are
balls that its camera shows, such as `[[2, 1, 0.3, "red"]]`: x, y and radius in metres, and a colour.
"""

from __future__ import annotations

import io
import math
import random
import threading
import time
from dataclasses import dataclass, fields, replace
from typing import Any

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError
from agentrob.model import ActionResult, Capabilities, Op, Outcome, Pose, Primitive, RobotState, StopResult
from agentrob.robots.control.controller import RATE_HZ, REST, Gait, Velocity, rotate, wrap
from agentrob.robots.control.step_runner import REST_LIMIT_S, run_step
from agentrob.robots.protocol import Watch, limits_of

TICK_S = 0.01
LAG_S = 0.15
HOLD_S = 1.0
#: A robot that runs faster than real time skips at most this much of its own time: on a busy machine it runs slower.
SKIP_S = 0.8
GESTURE_S = 2.0
RANGE_MAX_M = 8.0
OPTIONS = ("faults", "obstacles", "room", "things", "time_scale")
PICTURE_PX, PICTURE_FOV_DEG = (320, 240), 60.0


@dataclass
class Faults:
    """Faults that begin once the robot has moved `after_m` metres. May be changed while it runs."""

    after_m: float = 0.0
    stale: bool = False  # no new state arrives
    frozen: bool = False  # takes commands and does not move
    drops: float = 0.0  # this share of the commands is lost
    stop_s: float = LAG_S  # time constant of slowing down
    jump_m: float = 0.0  # the odometry jumps once by this much
    fallen: bool = False
    mode: str = ""  # somebody else put it into this mode
    ranges: str = "good"  # or missing, constant, zero
    unconfirmed: bool = False  # after a stop it creeps on
    battery_percent: float = 87.0


class FakeRobot:
    """See `agentrob.robots.protocol.Robot`. `commanded` is the fastest velocity it was ever commanded, for tests."""

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """Return its capabilities without constructing one."""
        return Capabilities("fake", frozenset(Op), limits_of(settings), simulated=True)

    def __init__(self, settings: RobotConfig) -> None:
        options = _checked(settings.options)
        self.capabilities = self.describe(settings)
        self.faults = Faults(**options.get("faults", {}))
        self._time_scale = float(options.get("time_scale", 1.0))
        self.room = tuple(float(v) for v in options.get("room", (-20, 20, -20, 20)))  # x_min, x_max, y_min, y_max
        self.obstacles = [tuple(float(v) for v in o) for o in options.get("obstacles", ())]  # x, y, radius
        self.things = [(float(x), float(y), float(r), str(c)) for x, y, r, c in options.get("things", ())]
        self.commanded = REST
        limits = self.capabilities.limits
        self._gait = Gait(gain_speed=3.0, gain_turn=4.0, coast_s=LAG_S, coast_turn_s=LAG_S, settle_s=0.4).at_most(
            limits.speed_mps, math.radians(limits.turn_dps)
        )
        self._lock = threading.RLock()
        self._epoch_s, self._virtual_s = time.monotonic(), 0.0  # a moment, and what its own clock said then
        self._pose, self._velocity, self._goal = Pose(0, 0, 0), REST, (REST, -math.inf)
        self._walked_m, self._jumped, self._stops, self._mode = 0.0, False, 0, "idle"
        self._body_s = 0.0  # up to when the body's motion is computed
        self._frozen_state: RobotState | None = None
        self._stale_since_s = 0.0
        self._random = random.Random(7)

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        with self._lock:
            self._advance()
            state = self._seen()
            if not (self.faults.stale and self._faulty):
                self._frozen_state = None
                return state
            if self._frozen_state is None:
                self._frozen_state, self._stale_since_s = state, self.now_s()
            return replace(self._frozen_state, age_s=self.now_s() - self._stale_since_s)

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        before = self._stops
        attentive: Watch = lambda state: "stop" if self._stops != before else watch(state)  # noqa: E731
        if primitive.op in (Op.MOVE, Op.TURN):
            return run_step(self, primitive, self._gait, attentive)
        if primitive.op is Op.GET_FRONT_IMAGE:
            now_s = time.monotonic()
            return ActionResult(primitive, Outcome.DONE, {}, started_s=now_s, ended_s=now_s, image=self._picture())
        return self._gesture(primitive, attentive)

    def look(self) -> bytes:
        return self._picture()

    def stop(self) -> StopResult:
        asked_s = time.monotonic()
        self._stops += 1
        was_moving = self._moving()
        self.rest()
        latency_ms = 1000 * (time.monotonic() - asked_s)
        start, end_s = self._pose, self.now_s() + REST_LIMIT_S
        while self._moving() and self.now_s() < end_s:
            self.wait_until(self.now_s() + 1 / RATE_HZ)
        confirmed = not self._moving() and self.state().age_s < 0.5
        coasted_m = math.hypot(self._pose.x_m - start.x_m, self._pose.y_m - start.y_m)
        message = "" if confirmed else "The robot's own state does not show that it came to rest."
        return StopResult(latency_ms, confirmed, was_moving, round(coasted_m, 4) if confirmed else None, message)

    def close(self) -> None:
        self.rest()

    # ------------------------------------------------------------ the body (agentrob.robots.control.step_runner.Body)
    def now_s(self) -> float:
        with self._lock:
            if math.isinf(self._time_scale):
                return self._virtual_s
            before_s, self._epoch_s = self._epoch_s, time.monotonic()
            passed_s = (self._epoch_s - before_s) * self._time_scale
            self._virtual_s += min(passed_s, SKIP_S) if self._time_scale > 1 else passed_s
            return self._virtual_s

    def command(self, velocity: Velocity) -> None:
        with self._lock:
            if self._random.random() < self.faults.drops and self._faulty:
                return
            self.commanded = Velocity(*(max(abs(a), b) for a, b in zip(velocity, self.commanded, strict=True)))
            self._advance()
            self._goal = velocity, self.now_s() + HOLD_S

    def rest(self) -> None:
        with self._lock:
            self._advance()
            self._goal = REST, math.inf

    def wait_until(self, time_s: float) -> None:
        if math.isinf(self._time_scale):
            with self._lock:
                self._virtual_s = max(self._virtual_s, time_s)
                self._advance()
        else:
            time.sleep(max(0.0, (time_s - self.now_s()) / self._time_scale))

    # ------------------------------------------------------------ for tests and demonstrations
    @property
    def pose(self) -> Pose:
        """Its actual pose."""
        with self._lock:
            self._advance()
            return self._pose

    @property
    def time_scale(self) -> float:
        """How much faster than real time it runs; its own clock stays continuous when this changes."""
        return self._time_scale

    @time_scale.setter
    def time_scale(self, scale: float) -> None:
        with self._lock:
            self.now_s()  # up to now it ran at the former scale
            self._epoch_s, self._time_scale = time.monotonic(), scale

    def carry(self, pose: Pose) -> None:
        """Move it to another pose at once, so that its odometry jumps."""
        with self._lock:
            self._advance()
            self._pose = pose

    # ------------------------------------------------------------ arithmetic
    @property
    def _faulty(self) -> bool:
        return self._walked_m >= self.faults.after_m

    def _advance(self) -> None:
        """Compute the body's motion up to now."""
        now_s = self.now_s()
        t_s = self._body_s
        if self._resting(t_s):
            t_s = now_s  # a body at rest stays at rest: no need to count the ticks
        while t_s < now_s:
            dt = min(TICK_S, now_s - t_s)
            t_s += dt
            self._tick(t_s, dt)
        self._body_s = t_s

    def _resting(self, t_s: float) -> bool:
        return max(map(abs, self._velocity)) < 1e-4 and (self._goal[0] == REST or t_s > self._goal[1])

    def _tick(self, t_s: float, dt: float) -> None:
        goal, until_s = self._goal
        if t_s > until_s or (self.faults.frozen and self._faulty):
            goal = REST
        if goal == REST and self.faults.unconfirmed:
            goal = Velocity(0.1)
        lag_s = max(self.faults.stop_s, 0.01) if goal == REST else LAG_S
        a = 1.0 - math.exp(-dt / lag_s)
        self._velocity = Velocity(*(v + a * (g - v) for v, g in zip(self._velocity, goal, strict=True)))
        if max(map(abs, self._velocity)) < 1e-3 and goal == REST:
            self._velocity = REST
        dx, dy = rotate(self._velocity.forward_mps * dt, self._velocity.left_mps * dt, self._pose.yaw_rad)
        x, y = self._pose.x_m + dx, self._pose.y_m + dy
        if self._hits(x, y):
            x, y = self._pose.x_m, self._pose.y_m
        self._walked_m += math.hypot(x - self._pose.x_m, y - self._pose.y_m)
        if self.faults.jump_m and self._faulty and not self._jumped:
            self._jumped, x = True, x + self.faults.jump_m
        self._pose = Pose(x, y, wrap(self._pose.yaw_rad + self._velocity.turn_rps * dt))

    def _hits(self, x: float, y: float) -> bool:
        x_min, x_max, y_min, y_max = self.room
        return not (x_min < x < x_max and y_min < y < y_max) or any(
            math.hypot(x - ox, y - oy) < radius for ox, oy, radius in self.obstacles
        )

    def _moving(self) -> bool:
        with self._lock:
            self._advance()
            return math.hypot(*self._velocity[:2]) > 0.02 or abs(self._velocity.turn_rps) > 0.05

    def _seen(self) -> RobotState:
        fallen = self.faults.fallen and self._faulty
        mode = self.faults.mode if self.faults.mode and self._faulty else self._mode
        if mode == "idle" and max(map(abs, self._velocity)) > 0.02:
            mode = "walking"
        return RobotState(
            age_s=0.01,
            pose=self._pose,
            velocity_mps=self._velocity[:2],
            yaw_rate_rps=self._velocity.turn_rps,
            mode="fallen" if fallen else mode,
            battery_percent=self.faults.battery_percent if self._faulty else 87.0,
            ranges_m=self._ranges(),
            upright=not fallen,
            error_code=0,
        )

    def _ranges(self) -> tuple[float | None, float | None, float | None, float | None]:
        kind = self.faults.ranges if self._faulty else "good"
        if kind == "missing":
            return None, None, None, None
        if kind in ("constant", "zero"):
            value = 2.5 if kind == "constant" else 0.0
            return value, value, value, value
        front, left, back, right = (self._beam(self._pose.yaw_rad + k * math.pi / 2) for k in range(4))
        return front, left, back, right

    def _beam(self, angle_rad: float) -> float:
        """Distance from the centre along a ray, with a millimetre of noise as any sensor has."""
        dx, dy = math.cos(angle_rad), math.sin(angle_rad)
        x_min, x_max, y_min, y_max = self.room
        hits = [RANGE_MAX_M]
        if abs(dx) > 1e-9:
            hits.append(((x_max if dx > 0 else x_min) - self._pose.x_m) / dx)
        if abs(dy) > 1e-9:
            hits.append(((y_max if dy > 0 else y_min) - self._pose.y_m) / dy)
        for ox, oy, radius in self.obstacles:
            along, across = rotate(ox - self._pose.x_m, oy - self._pose.y_m, -angle_rad)
            if along > 0 and abs(across) < radius + 0.2:  # a beam as wide as the body
                hits.append(along - math.sqrt(max(0.0, radius**2 - across**2)))
        return max(0.01, min(hits) + self._random.gauss(0, 0.001))

    def _gesture(self, primitive: Primitive, watch: Watch) -> ActionResult:
        started_s, end_s, reason = time.monotonic(), self.now_s() + GESTURE_S, None
        if reason := watch(self.state()):
            end_s = 0.0
        self._mode = "gesture"
        while self.now_s() < end_s and not reason:
            self.wait_until(min(end_s, self.now_s() + 1 / RATE_HZ))
            reason = watch(self.state())
        self._mode = "idle"
        outcome = Outcome.STOPPED if reason else Outcome.DONE
        name = str(primitive.op).capitalize()
        message = f"{name}: stopped ({reason.replace('_', ' ')})." if reason else f"{name}: done."
        return ActionResult(
            primitive,
            outcome,
            {},
            reason or "",
            message,
            started_s,
            time.monotonic(),
            animated=primitive.op is Op.BACKFLIP,
        )

    def _picture(self) -> bytes:
        """A JPEG, 320x240: a sky that turns with the robot, a floor, and where it stands."""
        from PIL import Image, ImageDraw

        pose = self.pose
        image = Image.new("RGB", PICTURE_PX, (120 + int(60 * math.cos(pose.yaw_rad)), 150, 200))
        draw = ImageDraw.Draw(image)
        draw.rectangle((0, 130, 320, 240), fill=(110, 100, 90))
        for thing in sorted(self.things, key=lambda t: -math.dist(t[:2], (pose.x_m, pose.y_m))):
            _draw_ball(draw, pose, thing)
        place = f"fake robot  x {pose.x_m:.2f} m  y {pose.y_m:.2f} m  yaw {math.degrees(pose.yaw_rad):.0f} deg"
        draw.text((10, 215), place, fill=(255, 255, 255))
        buffer = io.BytesIO()
        image.save(buffer, "JPEG", quality=80)
        return buffer.getvalue()


def _draw_ball(draw: Any, pose: Pose, thing: tuple[float, float, float, str]) -> None:
    """Draw a ball (x, y, radius, colour) at the height of the camera, if it is in view."""
    width, height = PICTURE_PX
    focal_px = height / 2 / math.tan(math.radians(PICTURE_FOV_DEG) / 2)
    ahead_m, left_m = rotate(thing[0] - pose.x_m, thing[1] - pose.y_m, -pose.yaw_rad)
    if ahead_m > thing[2]:
        x, y, r = width / 2 - focal_px * left_m / ahead_m, height / 2, focal_px * thing[2] / ahead_m
        draw.ellipse((x - r, y - r, x + r, y + r), fill=thing[3])


def _checked(options: dict[str, Any]) -> dict[str, Any]:
    known = tuple(f.name for f in fields(Faults))
    faults = options.get("faults", {})
    for found, valid, where in ((options, OPTIONS, "options"), (faults, known, "options.faults")):
        if unknown := sorted(set(found) - set(valid)):
            raise ConfigError(f"{where}.{unknown[0]} is not an option of the fake robot; valid: {', '.join(valid)}")
    return options
