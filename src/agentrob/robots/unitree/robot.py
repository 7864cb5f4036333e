"""Base of the Unitree robots: stopping and waiting for rest, pictures, and the messages of results."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

from agentrob.errors import RobotError
from agentrob.model import ActionResult, Capabilities, Op, Outcome, Pose, Posture, Primitive, RobotState, StopResult
from agentrob.robots.control.clock import Clock, HostClock, StampClock
from agentrob.robots.control.controller import RATE_HZ, STOPPED_WINDOW_S, RestDetector, known, wrap
from agentrob.robots.control.gesture import Gesture
from agentrob.robots.control.odometry import OdometryMonitor
from agentrob.robots.control.step_runner import REST_LIMIT_S
from agentrob.robots.protocol import Watch
from agentrob.robots.unitree import sdk

#: Velocities and stops are sent without waiting for an answer: they must never block on a robot that is not there.
WRITE_TIMEOUT_S = 0.15
#: The slowest simulated world, in simulated per real second, whose robot's gestures are waited for to their end.
SLOWEST_WORLD = 0.2
#: A real camera answers in a tenth of a second; a simulated one is rendered by the processor, which may be busy.
IMAGE_TIMEOUT_S = 10.0
IMAGE_MAX_BYTES = 8 * 1024 * 1024
#: Cosine of the tilt below which it lies rather than stands (60 degrees).
UPRIGHT = 0.5
#: A standing robot sways a little; a robot that is faster than this moves.
MOVING_MPS, MOVING_RPS = 0.12, 0.25
#: A body that walks or turns advances by more than this in half a second, whatever its speed at one moment.
#: In simulation bodies at rest stay below 0.01 m/s and 0.02 rad/s, and a walk at 0.2 m/s or a turn at 0.5 rad/s above
#: 0.17 m/s or 0.41 rad/s, while the speed of single moments of such a turn falls to 0.04 rad/s.
ADVANCE_S, ADVANCE_MPS, ADVANCE_RPS = 0.5, 0.06, 0.1
#: A standing body does not advance this far during a stop.
STOP_ADVANCE_M, STOP_ADVANCE_RAD = 0.05, 0.06
#: While somebody asks for joint angles they are read this often, and for this long after the last question.
JOINTS_EVERY_S, JOINTS_FOR_S = 0.08, 1.5
#: An older state does not confirm a stop.
CONFIRMING_S = 0.5


class UnitreeRobot:
    """See `agentrob.robots.protocol.Robot`. A subclass defines how it stops and how it runs a step."""

    capabilities: Capabilities
    _video: Any
    #: Part of a message about a gesture that a stop has not ended yet.
    _unfinished = "has not ended its gesture yet"

    def __init__(self, *, simulated: bool = False) -> None:
        """The steps of a simulated robot are timed by the stamps of its states, which `_heard` takes."""
        self._clock: Clock = StampClock() if simulated else HostClock()
        self._stops = 0
        self._gesture: Gesture | None = None
        self._walking = False
        self._at_rest_since_s = -math.inf  # as the last confirmed stop saw it
        self._looking = threading.Lock()

    # ------------------------------------------------------------ of each kind
    def state(self) -> RobotState:
        raise NotImplementedError

    def _recent(self) -> tuple[tuple[float, Pose], ...]:
        """Poses of the last second as (monotonic seconds, pose), oldest first; empty if they are not recorded."""
        return ()

    def _do(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """Run a step that moves the body; called when no gesture is running."""
        raise NotImplementedError

    def _send_stop(self) -> bool:
        """Send a stop without waiting for an answer; False if it could not be sent."""
        raise NotImplementedError

    def _end_gesture(self) -> None:
        """End a gesture, in addition to `_send_stop`."""

    # ------------------------------------------------------------ the robot
    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        before = self._stops
        attentive: Watch = lambda state: "stop" if self._stops != before else watch(state)  # noqa: E731
        if primitive.op is Op.GET_FRONT_IMAGE:
            return self._image(primitive)
        if self._gesturing:
            return refused(primitive, "busy", "The robot has not finished its last gesture yet.")
        self._walking = primitive.op in (Op.MOVE, Op.TURN)
        try:
            return self._do(primitive, attentive)
        finally:
            self._walking = False

    def stop(self) -> StopResult:
        """Command zero velocity at once on a separate client that does not wait for an answer; then wait for rest."""
        asked_s = time.monotonic()
        self._stops += 1
        before, walking = self.state(), self._walking
        recent = tuple((at_s, pose) for at_s, pose in self._recent() if at_s >= self._at_rest_since_s)
        sent = self._send_stop()
        latency_ms = round(1000 * (time.monotonic() - asked_s), 3)
        rest, gesturing, odometry, jumped = RestDetector(STOPPED_WINDOW_S), self._gesturing, OdometryMonitor(), False
        odometry.update(time.monotonic(), before, asked_s)
        if gesturing:
            self._end_gesture()
        while (now_s := time.monotonic()) < asked_s + REST_LIMIT_S:
            state = self.state()
            jumped |= odometry.update(time.monotonic(), state, asked_s=now_s) is not None
            fresh = state.pose is not None and state.age_s < CONFIRMING_S
            if fresh and state.pose and rest.update(now_s, state.pose) and not self._gesturing:
                break
            time.sleep(1 / RATE_HZ)
            if now_s < asked_s + 0.5:
                self._send_stop()  # a velocity that was on its way meanwhile, or a lost sample
        start = None if jumped else before.pose  # from before a jump nothing is measured
        moved_m, turned_rad = rest.distance_m(start), rest.turned_rad(start)
        # within a stride the speed may be near zero for a moment, so progress counts too
        came_on = (moved_m or 0.0) > STOP_ADVANCE_M or abs(turned_rad or 0.0) > STOP_ADVANCE_RAD
        coming = is_advancing(recent)
        # a standing body sways: momentary speed counts only in our own walk, or if nothing else is known
        fast = (walking or coming is None) and is_moving(before)
        in_doubt = walking and coming is None
        was_moving = gesturing or came_on or coming is True or fast or in_doubt
        doubt = self._doubt(rest)
        if doubt and not sent:
            doubt += " The stop could not be written to the robot's network."
        if not doubt:
            self._at_rest_since_s = rest.since_s
        return StopResult(latency_ms, not doubt, was_moving, None if doubt else moved_m, doubt)

    def _doubt(self, rest: RestDetector) -> str:
        """Return why the robot is not known to be at rest; empty if it is."""
        if (age_s := self.state().age_s) >= CONFIRMING_S:
            age = "no state ever came" if math.isinf(age_s) else f"its state is {age_s:.1f} s old"
            return f"The robot did not confirm: {age}."
        if not rest.reached:
            return f"The robot did not confirm: it still moved after {REST_LIMIT_S:g} s."
        return f"The robot keeps its place, but {self._unfinished}." if self._gesturing else ""

    def look(self) -> bytes:
        """See `agentrob.robots.protocol.HasCamera`. It uses the camera's own client, so it never delays a step."""
        result = self._image(Primitive(Op.GET_FRONT_IMAGE))
        if result.image is None:
            raise RobotError(result.message or "the camera gave no picture")
        return result.image

    # ------------------------------------------------ the body's clock (agentrob.robots.control.step_runner.Body)
    def now_s(self) -> float:
        return self._clock.now_s()

    def wait_until(self, time_s: float) -> None:
        self._clock.wait_until(time_s)

    def _heard(self, came_s: float, message: Any) -> None:
        """Process a `SportModeState_` as it comes, in a DDS thread."""
        if isinstance(self._clock, StampClock):
            self._clock.take(came_s, message.stamp.sec + 1e-9 * message.stamp.nanosec)

    # ------------------------------------------------------------ steps
    def _begin_gesture(self, calls: Sequence[Callable[[], int]], watch: Watch, limit_s: float) -> Gesture:
        """A call of a real robot's SDK gives up by itself. One of a simulated robot's waits longer, and the robot's own
        clock tells when its answer is late."""
        simulated = isinstance(self._clock, StampClock)
        self._gesture = Gesture(
            calls, lambda: watch(self.state()), limit_s=limit_s if simulated else math.inf, now_s=self.now_s
        )
        return self._gesture

    @property
    def _gesturing(self) -> bool:
        """Whether the robot has not answered its last gesture (nor what ends it) yet."""
        return self._gesture is not None and self._gesture.running

    def _image(self, primitive: Primitive) -> ActionResult:
        started_s = time.monotonic()
        with self._looking:
            code, data = self._video.GetImageSample()
        if code:
            return failed(primitive, code, "No picture", started_s)
        image = bytes(data or ())
        if not (image.startswith(b"\xff\xd8") and len(image) <= IMAGE_MAX_BYTES):
            message = f"The camera sent {len(image)} bytes that are not a JPEG of at most 8 MiB."
            return ActionResult(primitive, Outcome.FAILED, {}, "bad_image", message, started_s, time.monotonic())
        return ActionResult(primitive, Outcome.DONE, {}, "", "", started_s, time.monotonic(), image=image)


def read(message: Any) -> RobotState:
    """Pose, velocity and attitude of a `SportModeState_`, as a state of age 0 without ranges and mode."""
    w, x, y, z = (float(v) for v in message.imu_state.quaternion)
    attitude = w * w + x * x + y * y + z * z > 0.5
    yaw = float(message.imu_state.rpy[2])
    if attitude and math.isfinite(yaw):  # Unitree's C++ library fills the quaternion alone
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    pose = Pose(float(message.position[0]), float(message.position[1]), yaw)
    vx, vy, turning = float(message.velocity[0]), float(message.velocity[1]), float(message.yaw_speed)
    return RobotState(
        age_s=0.0,
        pose=known(pose),
        velocity_mps=(vx, vy) if math.isfinite(vx) and math.isfinite(vy) else None,
        yaw_rate_rps=turning if math.isfinite(turning) else None,
        upright=1.0 - 2.0 * (x * x + y * y) > UPRIGHT if attitude else None,
    )


def posture_of(newest: tuple[float, Any] | None, joints_rad: tuple[float, ...]) -> Posture:
    """Height and tilt of the newest `SportModeState_`, with the joint angles."""
    if newest is None:
        return Posture(math.inf)
    came_s, message = newest
    height_m = float(message.position[2]) or float(message.body_height)
    state = read(message)
    tilt = None
    if state.pose is not None and state.upright is not None:
        w, x, y, z = (float(v) for v in message.imu_state.quaternion)
        c, s = math.cos(state.pose.yaw_rad / 2), math.sin(state.pose.yaw_rad / 2)
        tilt = (c * w + s * z, c * x + s * y, c * y - s * x, c * z - s * w)
    height = height_m if math.isfinite(height_m) else None
    return Posture(time.monotonic() - came_s, state.pose, height, tilt, joints_rad)


class JointAngles:
    """The angles of the first `count` motors of `rt/lowstate`. The topic is read often only while `now` is called: a
    real robot publishes it 500 times a second, and decoding one takes about a millisecond."""

    def __init__(self, topic: sdk.PolledTopic, count: int) -> None:
        self._topic, self._count = topic, count

    def now(self) -> tuple[float, ...]:
        self._topic.hurry(JOINTS_EVERY_S, JOINTS_FOR_S)
        if (message := self._topic.newest) is None:
            return ()
        angles = tuple(float(motor.q) for motor in message.motor_state[: self._count])
        return angles if all(map(math.isfinite, angles)) else ()


def is_advancing(recent: tuple[tuple[float, Pose], ...]) -> bool | None:
    """Whether a body walks or turns, from its recent poses; None if there are too few."""
    if not recent:
        return None
    (end_s, end), odometry = recent[-1], OdometryMonitor()
    kept: list[tuple[float, Pose]] = []
    for at_s, pose in recent:
        if odometry.update(at_s, RobotState(age_s=0.0, pose=pose)) is not None:
            kept.clear()  # it jumped: what was before tells nothing
        kept.append((at_s, pose))
    within = next(i for i, (at_s, _) in enumerate(kept) if at_s >= end_s - ADVANCE_S)
    if end_s - kept[within][0] < 0.6 * ADVANCE_S:  # on a busy machine none may have come for a while
        within = max(0, within - 1)
    start_s, start = kept[within]
    if (seconds := end_s - start_s) < 0.6 * ADVANCE_S:
        return None
    metres, radians = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m), abs(wrap(end.yaw_rad - start.yaw_rad))
    return metres > ADVANCE_MPS * seconds or radians > ADVANCE_RPS * seconds


def poses(topic: sdk.Topic) -> tuple[tuple[float, Pose], ...]:
    """The poses of the last second, from `SportModeState_` messages."""
    seen = ((at_s, read(message).pose) for at_s, message in topic.recent())
    return tuple((at_s, pose) for at_s, pose in seen if pose is not None)


def is_moving(state: RobotState) -> bool:
    """Whether the state shows walking or turning, beyond sensor noise."""
    speed_mps = math.hypot(*state.velocity_mps) if state.velocity_mps else 0.0
    return speed_mps > MOVING_MPS or abs(state.yaw_rate_rps or 0.0) > MOVING_RPS


def gesture_timeout_s(limit_s: float, *, simulated: bool) -> float:
    """Timeout of the SDK's calls that run a gesture which takes at most `limit_s` on the robot's own clock."""
    return limit_s / SLOWEST_WORLD if simulated else limit_s


def refused(primitive: Primitive, word: str, message: str) -> ActionResult:
    """Result of a step that was not started."""
    now_s = time.monotonic()
    return ActionResult(primitive, Outcome.REFUSED, {}, word, message, now_s, now_s)


def failed(primitive: Primitive, code: int, what: str, started_s: float) -> ActionResult:
    """Result of a step that the robot answered with an error code, or not at all."""
    word = "unsupported" if code in sdk.UNSUPPORTED else "no_answer" if code in sdk.NO_ANSWER else "robot_error"
    outcome = Outcome.UNKNOWN if word == "no_answer" and primitive.moves else Outcome.FAILED
    return ActionResult(primitive, outcome, {}, word, f"{what}: {sdk.explain(code)}.", started_s, time.monotonic())
