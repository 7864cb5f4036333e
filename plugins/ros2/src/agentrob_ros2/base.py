"""A wheeled base in ROS 2: velocities out, odometry and scan in, over Cyclone DDS without a ROS installation."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Sequence
from typing import Any

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotError
from agentrob.model import (
    ActionResult,
    Capabilities,
    Direction,
    Op,
    Outcome,
    Posture,
    Primitive,
    RobotState,
    StopResult,
)
from agentrob.robots.control.clock import Clock, HostClock, StampClock
from agentrob.robots.control.controller import RATE_HZ, STOPPED_WINDOW_S, Gait, RestDetector, Velocity
from agentrob.robots.control.step_runner import REST_LIMIT_S, run_step
from agentrob.robots.diagnostics.findings import Finding
from agentrob.robots.protocol import Watch, limits_of
from agentrob_ros2 import messages
from agentrob_ros2.camera import Camera
from agentrob_ros2.going import Goer
from agentrob_ros2.navigation import GO, PLACE, Navigation, operation_of
from agentrob_ros2.network import Node, qos_of
from agentrob_ros2.options import Ros2Options, options_of
from agentrob_ros2.sensors import Sensors

log = logging.getLogger(__name__)

#: Faster than this it moves.
MOVING_MPS, MOVING_RPS = 0.02, 0.05
#: After its start it waits this long to be discovered by the base before a step is refused.
DISCOVERY_S = 3.0
#: An older state does not confirm a stop.
CONFIRMING_S = 0.5
#: A base that comes to rest after a stop moves on by more than this if it moved.
CAME_ON_M, CAME_ON_RAD = 0.02, 0.03
#: A zero velocity is sent again for this long after a stop: whatever else publishes, or was lost, is overwritten.
REPEAT_S = 0.5
#: While a goal of Nav2 ends, zero is sent this often, since its controller still publishes.
NAVIGATING_S = 0.01
#: A base that turns its wheels but cannot go sideways is steered back onto its line by this gain, in rad/s per m/s.
STEER_BACK = 2.0


class Ros2Base:
    """See `agentrob.robots.protocol.Robot`. Needs no robot to be there yet.

    Raises `ConfigError` for options that are not valid, `RobotUnreachable` when DDS cannot be opened on the interface.
    """

    model = "ros2"
    navigation_class: type[Navigation] = Navigation

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """Its capabilities by its options, without connecting."""
        options = options_of(settings)
        ops = {Op.MOVE, Op.TURN} | ({Op.GET_FRONT_IMAGE} if options.image.topic else set())
        ways = frozenset(Direction) if options.holonomic else frozenset({Direction.FORWARD, Direction.BACKWARD})
        try:
            declared = (operation_of(options),) if options.places else ()
        except ValueError as e:
            raise ConfigError(f"options of a ROS 2 base: places: {e}") from None
        limits = limits_of(settings)
        return Capabilities(cls.model, frozenset(ops), limits, ways, simulated=settings.simulated, declared=declared)

    @classmethod
    def examine(cls, settings: RobotConfig) -> Sequence[Finding]:
        """See `agentrob.robots.diagnostics.protocol.Examinable`."""
        from agentrob_ros2.examination import examine

        return examine(settings)

    def __init__(self, settings: RobotConfig) -> None:
        self.capabilities = self.describe(settings)
        self.options: Ros2Options = options_of(settings)
        self._gait = gait_of(self.options).at_most(settings.limits.speed_mps, math.radians(settings.limits.turn_dps))
        self._clock: Clock = StampClock() if self.options.use_sim_time else HostClock()
        self._node = Node(settings.domain, settings.interface, self.options.peers)
        command = self.options.cmd_vel
        self._command_topic = self.options.absolute(command.topic)
        self._kind: Any = messages.TwistStamped if command.stamped else messages.Twist
        self._writer = self._node.writer(self._command_topic, self._kind, qos_of(command))
        self._sensors = Sensors(self._node, self.options, self._clock)
        self._camera = Camera(self._node, self.options) if self.options.image.topic else None
        self._navigation = self.navigation_class(self._node, self.options) if self.options.places else None
        self._sending = threading.Lock()  # held for one write that does not block
        self._stops = 0
        self._stopped_step = -1  # the number of stops when the running step began
        self._walking = self._closed = False
        self._made_s = time.monotonic()

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        return self._sensors.state()

    def silence(self) -> str:
        """See `agentrob.robots.protocol.ExplainsSilence`."""
        return self._sensors.silence()

    def posture(self, *, joints: bool) -> Posture:
        """See `agentrob.robots.protocol.HasPosture`: a base has no joints and keeps its height."""
        state = self.state()
        return Posture(state.age_s, state.pose, 0.0)

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        if primitive.op is Op.GET_FRONT_IMAGE and self._camera is not None:
            return self._camera.photo(primitive)
        if primitive.op not in self.capabilities.ops:
            return refused(primitive, "unsupported", f"A {self.model} base cannot {primitive.op}.")
        if primitive.op is Op.MOVE and primitive.direction not in self.capabilities.move_directions:
            return refused(primitive, "unsupported", f"This base cannot move {primitive.direction}.")
        before = self._stops
        if deaf := self._deafness():
            return refused(primitive, "no_answer", deaf)
        attentive: Watch = lambda state: "stop" if self._stops != before else watch(state)  # noqa: E731
        if primitive.op == GO:
            return self._go(primitive, attentive)
        self._stopped_step, self._walking = before, True
        try:
            return run_step(self, primitive, self._gait, attentive)
        finally:
            self._walking = False

    def _go(self, primitive: Primitive, watch: Watch) -> ActionResult:
        assert self._navigation is not None
        name = primitive.value(PLACE)
        if name not in self.options.places:
            known = ", ".join(sorted(self.options.places))
            return refused(primitive, "invalid", f"There is no place {name!r}; places: {known}.")
        speed_mps, sensors = self.capabilities.limits.speed_mps, self._sensors
        goer = Goer(
            self._navigation, self.options, speed_mps, self.state, sensors.on_map, self.rest, sensors.ros_time_s
        )
        self._walking = True
        try:
            return goer.go(primitive, name, watch)
        finally:
            self._walking = False

    def stop(self) -> StopResult:
        """Publish zero velocity at once; then wait for rest, repeating it."""
        asked_s = time.monotonic()
        self._stops += 1
        sent = self._send(Velocity())
        self._cancel()
        latency_ms = round(1000 * (time.monotonic() - asked_s), 3)
        before, rest = self.state(), RestDetector(STOPPED_WINDOW_S)
        was_moving = self._walking or moving(before)
        while (now_s := time.monotonic()) < asked_s + REST_LIMIT_S:
            state = self.state()
            navigating = self._navigation is not None and self._navigation.busy
            fresh = state.pose is not None and state.age_s < CONFIRMING_S
            if fresh and state.pose and rest.update(now_s, state.pose) and not navigating:
                break
            time.sleep(NAVIGATING_S if navigating else 1 / RATE_HZ)
            if navigating or now_s < asked_s + REPEAT_S:
                self._send(Velocity())
        moved_m, turned_rad = rest.distance_m(before.pose), rest.turned_rad(before.pose)
        was_moving |= (moved_m or 0.0) > CAME_ON_M or abs(turned_rad or 0.0) > CAME_ON_RAD
        doubt = self._doubt(rest, sent)
        return StopResult(latency_ms, not doubt, was_moving, None if doubt else moved_m, doubt)

    def _deafness(self) -> str:
        """Why nobody receives its velocities; empty if somebody does. Waits while its own start is recent: others are
        discovered within a second."""
        while True:
            deaf = self._node.deafness(self._command_topic, self._kind, self.options.cmd_vel, self._writer)
            if not deaf or time.monotonic() > self._made_s + DISCOVERY_S:
                return deaf
            time.sleep(0.05)

    def _doubt(self, rest: RestDetector, sent: bool) -> str:
        """Why the base is not known to be at rest; empty if it is."""
        lost = "" if sent else f" Zero velocity could not be published on {self._command_topic}."
        if (age_s := self.state().age_s) >= CONFIRMING_S:
            age = "no state ever came" if math.isinf(age_s) else f"its state is {age_s:.1f} s old"
            return f"The robot did not confirm: {age}.{lost}"
        if not rest.reached:
            return f"The robot did not confirm: it still moved after {REST_LIMIT_S:g} s.{lost}"
        if self._navigation is not None and self._navigation.busy:
            return "The robot stands still, but its navigation did not confirm that it cancelled its goal."
        return ""

    def _cancel(self) -> None:
        """Cancel all goals of Nav2, also those of a driver that was killed."""
        if self._navigation is not None and not self._closed:
            try:
                self._navigation.cancel_all()
            except Exception as e:  # as in `_send`
                log.warning("the goals of %s could not be cancelled: %s", self._navigation.action, e)

    def look(self) -> bytes:
        """See `agentrob.robots.protocol.HasCamera`."""
        if self._camera is None:
            raise RobotError("this base has no camera: no image topic in its options")
        return self._camera.look()

    def close(self) -> None:
        self._send(Velocity())
        self._cancel()
        with self._sending:
            if not self._closed:
                self._closed = True
                self._node.close()

    # ------------------------------------------------------------ the body (agentrob.robots.control.step_runner.Body)
    def now_s(self) -> float:
        return self._clock.now_s()

    def wait_until(self, time_s: float) -> None:
        self._clock.wait_until(time_s)

    def command(self, velocity: Velocity) -> None:
        """Publish a velocity of the running step; nothing once it was stopped."""
        if not self.options.holonomic:
            velocity = steered(velocity)
        self._send(velocity, of_step=True)

    def rest(self) -> None:
        self._send(Velocity())

    def _send(self, velocity: Velocity, *, of_step: bool = False) -> bool:
        """Publish a velocity; False if nobody can have got it. One writer, so that zero is never overtaken by what
        was sent before it."""
        with self._sending:
            if self._closed or (of_step and self._stops != self._stopped_step):
                return False
            try:
                self._writer.write(self._message(velocity))
            except Exception as e:  # DDSException, also a timeout of a reliable subscriber that does not acknowledge
                log.warning("%s could not be published: %s", self._command_topic, e)
                return False
        return True

    def _message(self, velocity: Velocity) -> Any:
        forward, left, turn = (float(v) for v in velocity)
        twist = messages.Twist(messages.Vector3(forward, left, 0.0), messages.Vector3(0.0, 0.0, turn))
        if not self.options.cmd_vel.stamped:
            return twist
        now_s = self._sensors.ros_time_s()
        return messages.TwistStamped(messages.Header(messages.Time.of(now_s), self.options.cmd_vel.frame), twist)


class Ros2Sim(Ros2Base):
    """A simulated base of the demo: the same robot, with the topics of `agentrob_ros2.simulator`."""

    model = "ros2-sim"


def gait_of(options: Ros2Options) -> Gait:
    body = options.body
    least_rps = math.radians(body.least_turn_dps)
    return Gait(
        speed_mps=1.5,
        side_mps=1.5 if options.holonomic else 0.3,
        turn_rps=math.radians(90),
        speed_min_mps=body.least_speed_mps,
        turn_min_rps=least_rps,
        step_mps=body.least_speed_mps,
        step_rps=least_rps,
        coast_s=body.coast_s,
        coast_turn_s=body.coast_s,
        settle_s=0.4,
        stop_at_m=0.005,
        stop_at_rad=math.radians(0.5),
        accept_m=0.015,  # wheels stand still where they stop: no sway that a correction would chase
        accept_rad=math.radians(1.2),
    )


def steered(velocity: Velocity) -> Velocity:
    """The velocity of a base that cannot go sideways: it steers towards where it should have gone."""
    forward, left, turn = velocity
    back = STEER_BACK * left * (1.0 if forward >= 0 else -1.0) if abs(forward) > 0.02 else 0.0
    return Velocity(forward, 0.0, turn + max(-0.3, min(0.3, back)))


def moving(state: RobotState) -> bool:
    speed_mps = math.hypot(*state.velocity_mps) if state.velocity_mps else 0.0
    return speed_mps > MOVING_MPS or abs(state.yaw_rate_rps or 0.0) > MOVING_RPS


def refused(primitive: Primitive, word: str, message: str) -> ActionResult:
    """Result of a step that was not started."""
    now_s = time.monotonic()
    return ActionResult(primitive, Outcome.REFUSED, {}, word, message, now_s, now_s)
