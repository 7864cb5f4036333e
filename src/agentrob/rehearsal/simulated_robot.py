"""A robot in simulated time, for the guard and the control loop of the real driver. No clock, network or thread."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np

from agentrob.model import ActionResult, Capabilities, Op, Outcome, Pose, Primitive, RobotState, StopResult
from agentrob.rehearsal.geometry import in_frame
from agentrob.rehearsal.motions import Motions
from agentrob.robots.control.controller import RATE_HZ, Velocity
from agentrob.robots.control.step_runner import run_step
from agentrob.robots.protocol import Watch
from agentrob.robots.unitree.robot import UPRIGHT
from agentrob.sim.bodies.sensors import VELOCITY_NOISE_MPS, Odometry
from agentrob.sim.world.legged import PERIOD_S
from agentrob.sim.world.world import World

#: From the body to the driver and back: the age of odometry when a command takes effect.
LAG_S = 0.04
#: A gesture that takes longer does not end: the driver gives up, too.
GESTURE_LIMIT_S = 20.0
#: What a picture takes: it moves nothing.
PICTURE_S = 0.5


class SimulatedRobot:
    """See `agentrob.robots.protocol.Robot` and `agentrob.robots.control.step_runner.Body`.

    `start` is where it stands in the frame of its home: its odometry counts from there. `on_tick` is called after each
    period of the world.
    """

    def __init__(
        self,
        motions: Motions,
        world: World,
        capabilities: Capabilities,
        start: Pose,
        rng: np.random.Generator,
        battery_percent: float | None,
        on_tick: Callable[[], None],
    ) -> None:
        self.capabilities = capabilities
        limits = capabilities.limits
        self._gait = motions.gait.at_most(limits.speed_mps, math.radians(limits.turn_dps))
        self._motions, self._world, self._start, self._rng = motions, world, start, rng
        self._battery_percent, self._on_tick = battery_percent, on_tick
        self._odometry = Odometry(motions.body, rng, noisy=True)
        self._poses = deque([self._odometry.read()], maxlen=round(LAG_S / PERIOD_S) + 1)
        self._sensed: tuple[float, RobotState] | None = None

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        """The state of now, with the odometry of a moment ago. Sensors are read once a period, if anybody asks."""
        if self._sensed is None or self._sensed[0] != self.now_s():
            self._sensed = self.now_s(), self._sense()
        return self._sensed[1]

    def _sense(self) -> RobotState:
        body, motions = self._motions.body, self._motions
        upright = body.upright > UPRIGHT or motions.flipping
        vx, vy, turning = body.heading_velocity() + self._rng.normal(0, VELOCITY_NOISE_MPS, 3)
        return RobotState(
            age_s=LAG_S,
            pose=in_frame(self._start, Pose(*self._poses[0])),
            velocity_mps=(float(vx), float(vy)),
            yaw_rate_rps=float(turning),
            mode=motions.mode if upright else "fallen",
            battery_percent=self._battery_percent,
            ranges_m=motions.ranges_m(),
            upright=upright,
        )

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        if primitive.op in (Op.MOVE, Op.TURN):
            if self._motions.mode in ("sitting", "lying", "damping"):
                message = f"The robot is {self._motions.mode}; it must stand up first."
                return ActionResult(primitive, Outcome.REFUSED, reason="posture", message=message)
            return run_step(self, primitive, self._gait, watch)
        if primitive.op is Op.GET_FRONT_IMAGE:
            self.wait_until(self.now_s() + PICTURE_S)
            return ActionResult(primitive, Outcome.DONE)
        return self._gesture(primitive, watch)

    def stop(self) -> StopResult:
        self._motions.rest()
        return StopResult(0.0, confirmed=False)

    def close(self) -> None:
        self.rest()

    # ------------------------------------------------------------ the body of the control loop
    def now_s(self) -> float:
        return float(self._world.time_s)

    def command(self, velocity: Velocity) -> None:
        self._motions.walk(velocity)

    def rest(self) -> None:
        self._motions.rest()

    def wait_until(self, time_s: float) -> None:
        while self.now_s() < time_s - 1e-6:
            self._motions.tick()
            self._world.tick()
            self._odometry.update()
            self._poses.append(self._odometry.read())
            self._on_tick()

    def wait(self, seconds: float) -> None:
        self.wait_until(self.now_s() + seconds)

    # ------------------------------------------------------------ gestures
    def _gesture(self, primitive: Primitive, watch: Watch) -> ActionResult:
        for call in self._motions.calls(Op(primitive.op)):
            reason, code = self._wait_for(call, watch)
            if reason:
                self._motions.rest()
                return ActionResult(primitive, Outcome.STOPPED, reason=reason)
            if code:
                message = f"The robot would answer with the error {code}."
                return ActionResult(primitive, Outcome.FAILED, reason="robot_error", message=message)
        return ActionResult(primitive, Outcome.DONE, animated=primitive.op is Op.BACKFLIP)

    def _wait_for(self, call: float | Callable[[Callable[..., None]], None], watch: Watch) -> tuple[str, int]:
        """Wait for the answer of a call; return the watch's reason to end it, and the code of the answer."""
        codes: list[int] = []
        until_s = self.now_s() + (call if isinstance(call, float) else GESTURE_LIMIT_S)
        if callable(call):
            call(lambda code, *_: codes.append(code))
        while not codes and self.now_s() < until_s:
            if reason := watch(self.state()):
                return reason, 0
            self.wait(1 / RATE_HZ)
        late = 3104  # the SDK's word for an answer that does not come
        return "", codes[0] if codes else 0 if isinstance(call, float) else late
