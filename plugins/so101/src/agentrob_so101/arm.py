"""The SO-101 follower arm: poses out, measured poses in, simulated or real through LeRobot."""

from __future__ import annotations

import math
import time

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotError
from agentrob.model import (
    ActionResult,
    Capabilities,
    Op,
    Outcome,
    Pose,
    Primitive,
    RobotState,
    StopResult,
)
from agentrob.robots.protocol import Watch, limits_of
from agentrob_so101 import picking
from agentrob_so101.follower import Camera, Follower, OpenCVCamera, open_follower
from agentrob_so101.keep_out import KeepOut
from agentrob_so101.kinematics import so101
from agentrob_so101.link import Link
from agentrob_so101.moving import HELD_FROM, REST_S, STATE_AGE_S, Ended, Mover, at_rest
from agentrob_so101.operations import ANGLE, DECLARED, HOME, HOME_POSE, OFF, OPENING, PICK, PICK_UP, POINT, WAY, way_of
from agentrob_so101.options import So101Options, options_of
from agentrob_so101.pose import ArmPose, farthest_deg
from agentrob_so101.simulated import SimulatedFollower

#: Why a step failed by itself, rather than being stopped.
FAILURES = frozenset(
    {"inaccurate", "restless", "stalled", "no_answer", "bad_image", "not_seen", "out_of_reach", "missed"}
)
#: Faster than this it moves.
MOVING_DPS = 8.0
#: A first step waits so long for the first state.
FIRST_S = 3.0
#: A stop waits so long for rest.
REST_LIMIT_S = 3.0
#: An arm that comes to rest after a stop turned on by more than this if it moved.
CAME_ON_DEG = 2.0


class So101:
    """See `agentrob.robots.protocol.Robot`. The arm's foot stays where it is: its pose is always zero.

    `follower` and `camera` are those of a real arm that is connected already. Raises `ConfigError` for options that are
    not valid, and `RobotError` as `open_follower` and `OpenCVCamera`.
    """

    model = "so101"

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """Its capabilities by its settings, without connecting."""
        options = options_of(settings)
        if settings.simulated and options.port:
            raise ConfigError("options of an SO-101 arm: port is that of a real arm; remove it, or simulated = true")
        sees = settings.simulated or bool(options.camera.source != "")
        ops = {Op.HELLO, *({Op.GET_FRONT_IMAGE} if sees else ())}
        limits, simulated = limits_of(settings), settings.simulated
        declared = (*DECLARED, PICK_UP) if simulated else DECLARED
        return Capabilities(cls.model, frozenset(ops), limits, frozenset(), simulated=simulated, declared=declared)

    def __init__(self, settings: RobotConfig, follower: Follower | None = None, camera: Camera | None = None) -> None:
        self.capabilities = self.describe(settings)
        self.options: So101Options = options_of(settings)
        simulated = SimulatedFollower(settings.interface, settings.domain) if settings.simulated else None
        self._camera: Camera | None = camera or simulated
        self._link = Link(follower or simulated or open_follower(self.options))
        if self._camera is None and self.options.camera.source != "":
            self._camera = OpenCVCamera(self.options)
        self._mover = Mover(self._link, KeepOut(self.options, so101()), self.capabilities.limits.turn_dps, self.state)
        self._stepping, self._made_s = False, time.monotonic()

    def state(self) -> RobotState:
        reading = self._link.reading
        if reading is None:
            return RobotState(age_s=math.inf)
        moving = reading.speed_dps > MOVING_DPS or reading.gripper_pps > 2 * MOVING_DPS
        mode = "gesture" if moving else "idle"
        return RobotState(reading.age_s, Pose(0.0, 0.0, 0.0), (0.0, 0.0), 0.0, mode, upright=True)

    def silence(self) -> str:
        """See `agentrob.robots.protocol.ExplainsSilence`."""
        return self._link.problem

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        if primitive.op not in self.capabilities.ops:
            can = ", ".join(sorted(self.capabilities.ops))
            return _ended(primitive, Outcome.REFUSED, "unsupported", f"An arm cannot {primitive.op}; it can: {can}.")
        if primitive.op is Op.GET_FRONT_IMAGE:
            return self._photo(primitive, watch)
        started_s, stops = time.monotonic(), self._link.stops
        while self._link.reading is None and time.monotonic() < self._made_s + FIRST_S:
            time.sleep(0.02)
        attentive: Watch = lambda state: "stop" if self._link.stops != stops else watch(state)  # noqa: E731
        self._stepping = True
        try:
            target, ended = self._done(primitive, attentive, stops)
        finally:
            self._stepping = False
        if ended.reason and ended.began and self._link.stops == stops:
            self._link.hold()
        return self._result(primitive, target, ended, started_s)

    def _done(self, primitive: Primitive, watch: Watch, stops: int) -> tuple[ArmPose, Ended]:
        """Do a step; returns where the arm should be at its end, and how it ended."""
        start = self._mover.start() or HOME_POSE
        if primitive.op == PICK:
            return self._pick(start, watch, stops)
        way = way_of(primitive, start)
        return way[-1], self._mover.go(way, watch, stops)

    def _pick(self, start: ArmPose, watch: Watch, stops: int) -> tuple[ArmPose, Ended]:
        """Look for the red cube from the home pose, grasp it, and lift it to there."""
        home = HOME_POSE._replace(gripper=picking.OPEN)
        ended = self._mover.go((start._replace(gripper=picking.OPEN), home), watch, stops)
        if ended.reason:
            return home, ended
        try:
            place = picking.locate(self.look())
        except RobotError as e:
            return home, Ended("bad_image", f"{str(e)[:1].upper()}{str(e)[1:]}.")
        if place is None:
            return home, Ended("not_seen", "The camera does not show the red cube.")
        grasp = picking.grasp(*place)
        if grasp is None:
            where = f"{place[0]:.2f} m ahead and {place[1]:.2f} m to the left"
            return home, Ended("out_of_reach", f"The red cube is out of reach: {where} of the arm's foot.")
        ways: list[tuple[ArmPose, ...]] = [(grasp.above, grasp.around), (grasp.around._replace(gripper=0.0),)]
        for way in (*ways, (grasp.above, HOME_POSE)):
            if way[-1] is HOME_POSE:  # with the gripper as it closed
                holding = (self._mover.start() or start).gripper
                way = tuple(pose._replace(gripper=holding) for pose in way)  # noqa: PLW2901
            ended = self._mover.go(way, watch, stops)
            if ended.reason:
                return way[-1], ended._replace(began=True)
            if way[-1].gripper != picking.OPEN and not self._holds:
                return way[-1], Ended("missed", "The gripper holds nothing.")
        return way[-1], ended

    @property
    def _holds(self) -> bool:
        """Whether something keeps the gripper from closing."""
        reading = self._link.reading
        return reading is not None and reading.pose.gripper > HELD_FROM

    def stop(self) -> StopResult:
        """Make the arm stay where it is, at once; then wait for rest."""
        asked_s, before = time.monotonic(), self._link.reading
        was_moving = self._stepping or self.state().mode == "gesture"
        sent = self._link.hold()
        latency_ms = round(1000 * (time.monotonic() - asked_s), 3)
        rests_s, rested = time.monotonic(), False
        while (now_s := time.monotonic()) < asked_s + REST_LIMIT_S and not rested:
            reading = self._link.reading
            if reading is None or not at_rest(reading) or reading.age_s > REST_S:
                rests_s = now_s
            rested = now_s - rests_s > REST_S
            time.sleep(0.01)
        after = self._link.reading
        moved_m = None
        if before is not None and after is not None:
            was_moving |= farthest_deg(before.pose, after.pose)[1] > CAME_ON_DEG
            tips = (so101().tip(one.pose)[0] for one in (before, after))
            moved_m = round(math.dist(*tips), 4)
        doubt = self._doubt(rested, sent)
        return StopResult(latency_ms, not doubt, was_moving, None if doubt else moved_m, doubt)

    def look(self) -> bytes:
        """See `agentrob.robots.protocol.HasCamera`."""
        if self._camera is None:
            raise RobotError("this arm has no camera: set camera in its options")
        return self._camera.jpeg()

    def close(self) -> None:
        self._link.close()
        if self._camera is not None:
            self._camera.close()

    def _photo(self, primitive: Primitive, watch: Watch) -> ActionResult:
        started_s = time.monotonic()
        if reason := watch(self.state()):
            return _stopped_before(primitive, reason, started_s)
        try:
            image = self.look()
        except RobotError as e:
            message = str(e)[:1].upper() + str(e)[1:] + "."
            return ActionResult(primitive, Outcome.FAILED, {}, "bad_image", message, started_s, time.monotonic())
        return ActionResult(primitive, Outcome.DONE, {}, "", "", started_s, time.monotonic(), image=image)

    def _doubt(self, rested: bool, sent: bool) -> str:
        """Why the arm is not known to be at rest; empty if it is."""
        lost = "" if sent else " The goal to stay where it is could not be sent."
        if (age_s := self.state().age_s) >= STATE_AGE_S:
            age = "no state ever came" if math.isinf(age_s) else f"its state is {age_s:.1f} s old"
            return f"The arm did not confirm: {age}. {self._link.problem}{lost}".replace(". .", ".")
        if not rested or not sent:
            return f"The arm did not confirm: it still moved after {REST_LIMIT_S:g} s.{lost}"
        return ""

    def _result(self, primitive: Primitive, target: ArmPose, ended: Ended, started_s: float) -> ActionResult:
        reading = self._link.reading
        if not ended.began and ended.reason in ("keep_out", "joint_limits", "stale_state"):
            return _ended(primitive, Outcome.REFUSED, ended.reason, ended.message, started_s)
        if not ended.began:
            return _stopped_before(primitive, ended.reason, started_s)
        if reading is None or reading.age_s >= STATE_AGE_S:
            return _ended(primitive, Outcome.STOPPED, ended.reason, ended.message, started_s)
        measured = _measured(primitive, target, reading.pose)
        pair = f"Asked {target}; measured {reading.pose}."
        if not ended.reason:
            return _ended(primitive, Outcome.DONE, "", pair, started_s, measured)
        outcome = Outcome.FAILED if ended.reason in FAILURES else Outcome.STOPPED
        why = ended.message or f"Stopped ({ended.reason.replace('_', ' ')})."
        return _ended(primitive, outcome, ended.reason, f"{why} {pair}", started_s, measured)


def _measured(primitive: Primitive, target: ArmPose, pose: ArmPose) -> dict[str, float]:
    """The quantities that the declaration of a step measures, and all joints and the gripper."""
    found = {f"{name}_deg": round(value, 2) for name, value in zip(pose._fields[:-1], pose, strict=False)}
    found[OPENING] = round(pose.gripper, 1)
    if primitive.op == HOME:
        found[OFF] = round(farthest_deg(target, pose)[1], 2)
    if primitive.op == POINT:
        found[ANGLE] = round(pointed_deg(str(primitive.value(WAY)), pose), 1)
    return found


def pointed_deg(way: str, pose: ArmPose) -> float:
    """How far the gripper points to the left, to the right or upwards, by where the measured joints put it."""
    _, ahead = so101().tip(pose)
    if way == "up":
        return math.degrees(math.asin(max(-1.0, min(1.0, float(ahead[2])))))
    left_deg = math.degrees(math.atan2(ahead[1], ahead[0]))
    return left_deg if way == "left" else -left_deg


def _stopped_before(primitive: Primitive, reason: str, started_s: float) -> ActionResult:
    why = f"Stopped before it began ({reason.replace('_', ' ')})."
    return _ended(primitive, Outcome.STOPPED, reason, why, started_s)


def _ended(
    primitive: Primitive,
    outcome: Outcome,
    reason: str,
    message: str,
    started_s: float | None = None,
    measured: dict[str, float] | None = None,
) -> ActionResult:
    now_s = time.monotonic()
    return ActionResult(primitive, outcome, measured or {}, reason, message, started_s or now_s, now_s)
