"""A kinematic rover with two driven wheels: the example of a third-party robot (docs/robots/add-a-robot.md).

It drives and turns in its own empty room of 8 m x 8 m. It has no DDS, camera or arms.
"""

from __future__ import annotations

import math
import random
import threading
import time

from agentrob import (
    RATE_HZ,
    REST_LIMIT_S,
    ActionResult,
    Capabilities,
    ConfigError,
    Direction,
    Gait,
    Op,
    Outcome,
    Pose,
    Primitive,
    RobotConfig,
    RobotState,
    StopResult,
    Velocity,
    Watch,
    limits_of,
    run_step,
    wrap,
)

TRACK_M = 0.4  # between the wheels
WHEEL_MPS = 0.8  # maximum of a wheel
LAG_S = 0.12  # a wheel follows its motor with this time constant
HOLD_S = 0.5  # a command expires after this time, so that the rover stops if its driver dies
WALL_M = 4.0  # distance from the middle of the room
TICK_S = 0.01
GAIT = Gait(speed_mps=0.6, turn_rps=1.2, coast_s=LAG_S, coast_turn_s=LAG_S, settle_s=0.4)


class Rover:
    """See `agentrob.robots.protocol.Robot`."""

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """Its capabilities, without creating a rover: it cannot move sideways."""
        ahead = frozenset({Direction.FORWARD, Direction.BACKWARD})
        return Capabilities("rover", frozenset({Op.MOVE, Op.TURN}), limits_of(settings), ahead, simulated=True)

    def __init__(self, settings: RobotConfig) -> None:
        if settings.options:
            raise ConfigError(f"a rover has no options (found: {', '.join(sorted(settings.options))})")
        self.capabilities = self.describe(settings)
        limits = self.capabilities.limits
        self._gait = GAIT.at_most(limits.speed_mps, math.radians(limits.turn_dps))
        self._lock = threading.Lock()
        self._pose, self._moved_s, self._stops = Pose(0.0, 0.0, 0.0), self.now_s(), 0
        self._wheels, self._wanted, self._until_s = (0.0, 0.0), (0.0, 0.0), -math.inf  # m/s, left and right
        self._random = random.Random(7)

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        with self._lock:
            self._roll()
            speed, turning = self._speeds()
            return RobotState(
                age_s=0.0,
                pose=self._pose,
                velocity_mps=(speed, 0.0),
                yaw_rate_rps=turning,
                mode="walking" if self._rolling() else "idle",
                ranges_m=(self._beam(0.0), self._beam(math.pi / 2), self._beam(math.pi), self._beam(-math.pi / 2)),
                upright=True,
            )

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        if primitive.op not in self.capabilities.ops or primitive.direction in self._impossible(primitive.op):
            now_s, message = (
                time.monotonic(),
                f"A rover cannot {primitive.op} {primitive.direction or ''}".strip() + ".",
            )
            return ActionResult(primitive, Outcome.REFUSED, {}, "unsupported", message, now_s, now_s)
        before = self._stops
        return run_step(self, primitive, self._gait, lambda state: "stop" if self._stops != before else watch(state))

    def stop(self) -> StopResult:
        asked_s = self.now_s()
        self._stops += 1
        before = self.state()
        self.rest()
        latency_ms = 1000 * (self.now_s() - asked_s)
        while (state := self.state()).mode != "idle" and self.now_s() < asked_s + REST_LIMIT_S:
            self.wait_until(self.now_s() + 1 / RATE_HZ)
        assert before.pose is not None
        assert state.pose is not None
        coasted_m = math.hypot(state.pose.x_m - before.pose.x_m, state.pose.y_m - before.pose.y_m)
        return StopResult(latency_ms, state.mode == "idle", before.mode != "idle", round(coasted_m, 4))

    def close(self) -> None:
        self.rest()

    # ------------------------------------------------------------ the body (agentrob.robots.control.step_runner.Body)
    def now_s(self) -> float:
        return time.monotonic()

    def command(self, velocity: Velocity) -> None:
        """Convert forward and turning velocity to the speeds of both wheels; sideways is ignored."""
        left = velocity.forward_mps - velocity.turn_rps * TRACK_M / 2
        right = velocity.forward_mps + velocity.turn_rps * TRACK_M / 2
        slower = max(abs(left) / WHEEL_MPS, abs(right) / WHEEL_MPS, 1.0)
        with self._lock:
            self._roll()
            self._wanted, self._until_s = (left / slower, right / slower), self.now_s() + HOLD_S

    def rest(self) -> None:
        self.command(Velocity())

    def wait_until(self, time_s: float) -> None:
        time.sleep(max(0.0, time_s - self.now_s()))

    # ------------------------------------------------------------ kinematics; call with the lock held
    def _roll(self) -> None:
        """Advance wheels and pose to the current time."""
        now_s = self.now_s()
        if not self._rolling() and (now_s > self._until_s or self._wanted == (0.0, 0.0)):
            self._moved_s = now_s
        while self._moved_s < now_s:
            seconds = min(TICK_S, now_s - self._moved_s)
            self._moved_s += seconds
            wanted = self._wanted if self._moved_s < self._until_s else (0.0, 0.0)
            a = 1.0 - math.exp(-seconds / LAG_S)
            left, right = (v + a * (w - v) for v, w in zip(self._wheels, wanted, strict=True))
            self._wheels = left, right
            (speed, turning), (x, y, yaw) = self._speeds(), (self._pose.x_m, self._pose.y_m, self._pose.yaw_rad)
            x = max(-WALL_M, min(WALL_M, x + speed * seconds * math.cos(yaw)))
            y = max(-WALL_M, min(WALL_M, y + speed * seconds * math.sin(yaw)))
            self._pose = Pose(x, y, wrap(yaw + turning * seconds))

    def _speeds(self) -> tuple[float, float]:
        """Forward velocity in m/s and counter-clockwise turn rate in rad/s, from the current wheel speeds."""
        left, right = self._wheels
        return (left + right) / 2, (right - left) / TRACK_M

    def _rolling(self) -> bool:
        return max(map(abs, self._wheels)) > 0.005

    def _beam(self, side_rad: float) -> float:
        """Metres to the wall on one side, with a millimetre of sensor noise."""
        dx, dy = math.cos(self._pose.yaw_rad + side_rad), math.sin(self._pose.yaw_rad + side_rad)
        ways = [
            (math.copysign(WALL_M, d) - p) / d for d, p in ((dx, self._pose.x_m), (dy, self._pose.y_m)) if abs(d) > 1e-9
        ]
        return max(0.01, min(ways) + self._random.gauss(0, 0.001))

    def _impossible(self, op: Op) -> frozenset[Direction]:
        return frozenset(Direction) - self.capabilities.move_directions if op is Op.MOVE else frozenset()
