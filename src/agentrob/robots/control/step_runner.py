"""Runs one move or turn on any body: control loop, recorded path, measured values and outcome."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from agentrob.model import ActionResult, Direction, Op, Outcome, Pose, Primitive, RobotState
from agentrob.robots.control.controller import (
    RATE_HZ,
    REST,
    REST_WINDOW_S,
    STOPPED_WINDOW_S,
    Gait,
    MotionController,
    RestDetector,
    Velocity,
    known,
    rotate,
    wrap,
)
from agentrob.robots.control.odometry import OdometryMonitor
from agentrob.robots.protocol import BODY_RADIUS_M, Watch

#: A step is `done` within this tolerance of the request, plus a share of long distances, since odometry drifts (0.3 %).
#: The position of a turn and the heading of a move, which must not change, get no such share.
TOLERANCE_M, TOLERANCE_DEG, TOLERANCE_SHARE = 0.05, 4.0, 0.005
#: Wait at most this long for rest after a stop.
REST_LIMIT_S = 3.0
#: An older state gives no position: the robot may have moved since.
SILENT_S = 0.5
#: Only states younger than this count as evidence of rest.
FRESH_S = 0.2
#: Why a step was not measured, as in `ActionResult.unmeasured`.
LOST, JUMPED = "odometry_lost", "odometry_jump"
_UNMEASURED = {LOST: "its odometry was lost", JUMPED: "its odometry jumped"}
#: A path has at most this many points; longer ones are thinned.
PATH_POINTS = 1000


class Body(Protocol):
    """The robot as the control loop uses it. Times are seconds of the body's own clock (a fake's may run faster)."""

    def now_s(self) -> float: ...

    def state(self) -> RobotState: ...

    def command(self, velocity: Velocity) -> None: ...

    def rest(self) -> None:
        """Command zero velocity."""
        ...

    def wait_until(self, time_s: float) -> None: ...


def unit_vector(primitive: Primitive) -> tuple[float, float]:
    """(forward, left) of a move in the body's frame; forward if it has no direction."""
    return (primitive.direction or Direction.FORWARD).unit_vector


def gait_for(primitive: Primitive, gait: Gait) -> Gait:
    """The gait slowed to the step's speed; for a turn that is the speed of the body's corners."""
    if primitive.speed_mps is None:
        return gait
    if primitive.op is Op.TURN:
        return gait.at_most(gait.speed_mps, primitive.speed_mps / BODY_RADIUS_M)
    return gait.at_most(primitive.speed_mps, gait.turn_rps)


def controller_for(primitive: Primitive, gait: Gait) -> MotionController:
    gait = gait_for(primitive, gait)
    if primitive.op is Op.TURN:
        sign = -1.0 if primitive.direction is Direction.RIGHT else 1.0
        return MotionController(gait, turn_rad=sign * math.radians(primitive.degrees or 0.0))
    x, y = unit_vector(primitive)
    distance_m = primitive.distance_m or 0.0
    return MotionController(gait, forward_m=x * distance_m, left_m=y * distance_m)


@dataclass
class _Track:
    """Odometry since the start of a step until it is lost or jumps (`unmeasured`), with the angle unwrapped."""

    points: list[tuple[float, Pose, float]] = field(default_factory=list)  # (seconds, pose, radians turned)
    sent: list[tuple[float, Velocity]] = field(default_factory=list)
    unmeasured: str = ""
    _odometry: OdometryMonitor = field(default_factory=OdometryMonitor)

    def update(self, t_s: float, state: RobotState, asked_s: float) -> None:
        """Add a state that was asked for at `asked_s`, unless the odometry was lost or has jumped."""
        pose = known(state.pose)
        if self.unmeasured:
            return
        if pose is None or not state.age_s < SILENT_S:
            self.unmeasured = LOST
        elif self._odometry.update(t_s, replace(state, pose=pose), asked_s):
            self.unmeasured = JUMPED
        else:
            self._add(t_s, pose)

    def _add(self, t_s: float, pose: Pose) -> None:
        turned = self.points[-1][2] + wrap(pose.yaw_rad - self.points[-1][1].yaw_rad) if self.points else 0.0
        self.points.append((t_s, pose, turned))

    def went(self, primitive: Primitive) -> float:
        """Last measured progress in the requested direction, in metres or degrees."""
        (_, start, _), (_, last, turned) = self.points[0], self.points[-1]
        if primitive.op is Op.TURN:
            return math.degrees(-turned if primitive.direction is Direction.RIGHT else turned)
        forward, left = rotate(last.x_m - start.x_m, last.y_m - start.y_m, -start.yaw_rad)
        ax, ay = unit_vector(primitive)
        return forward * ax + left * ay

    def end(self) -> tuple[float, float, float]:
        """Final x, y and turned angle, averaged over the rest window."""
        last_s = self.points[-1][0]
        tail = [p for p in self.points if p[0] >= last_s - REST_WINDOW_S]
        n = len(tail)
        return sum(p.x_m for _, p, _ in tail) / n, sum(p.y_m for _, p, _ in tail) / n, sum(w for *_, w in tail) / n

    def measured(self, primitive: Primitive) -> dict[str, float]:
        start = self.points[0][1]
        x, y, turned = self.end()
        forward, left = rotate(x - start.x_m, y - start.y_m, -start.yaw_rad)
        if primitive.op is Op.TURN:
            sign = -1.0 if primitive.direction is Direction.RIGHT else 1.0
            return _rounded(degrees=sign * math.degrees(turned), drift_m=math.hypot(forward, left))
        ax, ay = unit_vector(primitive)
        return _rounded(
            distance_m=forward * ax + left * ay,
            sideways_m=left * ax - forward * ay,
            heading_deg=math.degrees(turned),
        )

    def path(self) -> tuple[tuple[float, float, float, float], ...]:
        t0 = self.points[0][0]
        thin = self.points[:: 1 + len(self.points) // PATH_POINTS]
        return tuple((round(t - t0, 3), round(p.x_m, 4), round(p.y_m, 4), round(p.yaw_rad, 4)) for t, p, _ in thin)

    def commanded(self) -> tuple[tuple[float, float, float, float], ...]:
        """The velocities sent, on the same clock as the path."""
        t0 = self.points[0][0]
        thin = self.sent[:: 1 + len(self.sent) // PATH_POINTS]
        rounded = ((round(t - t0, 3), *(round(v, 4) + 0.0 for v in velocity)) for t, velocity in thin)
        return tuple((t, forward, left, turn) for t, forward, left, turn in rounded)


def _rounded(**values: float) -> dict[str, float]:
    return {k: round(v, 4) + 0.0 for k, v in values.items()}


def run_step(body: Body, primitive: Primitive, gait: Gait, watch: Watch) -> ActionResult:
    """Run one `move` or `turn`. When this returns, the body is at rest or has been commanded to stop."""
    started_s = time.monotonic()
    motion, track, reason = controller_for(primitive, gait), _Track(), ""
    try:
        reason = _drive(body, motion, track, watch)
    finally:
        body.rest()
    track.sent.append((body.now_s(), REST))
    if reason and track.points:
        _come_to_rest(body, track)
    if not track.points:
        return not_begun(primitive, reason, started_s)
    measured = track.measured(primitive)
    outcome, word, message = classify_outcome(primitive, measured, reason or motion.ended, stopped=bool(reason))
    ended_s = time.monotonic()
    path, sent = track.path(), track.commanded()
    result = ActionResult(primitive, outcome, measured, word, message, started_s, ended_s, path, commanded=sent)
    return unmeasured(result, track.unmeasured, track.went(primitive)) if track.unmeasured else result


def unmeasured(result: ActionResult, why: str, went: float | None = None) -> ActionResult:
    """Return the result without values measured across a jump or gap of the odometry (law 18); such a step is never
    `done`. `why` is `LOST` or `JUMPED`; `went` is the progress measured before that, in metres or degrees."""
    turn = result.primitive.op is Op.TURN
    asked = (result.primitive.degrees if turn else result.primitive.distance_m) or 0.0
    unit, digits = ("°", 1) if turn else (" m", 2)
    pair = f"Asked {asked:g}{unit}, measured unknown" if asked else "Measured unknown"
    message = f"{pair}: {_UNMEASURED[why]}."
    if result.outcome is Outcome.STOPPED:
        message += f" Stopped ({result.reason.replace('_', ' ')})."
    seen = "" if went is None else f" Before that it was seen {round(went, digits) + 0.0:.{digits}f}{unit} on its way;"
    message += f"{seen} where it came to rest is not known." if seen else " Where it came to rest is not known."
    outcome = Outcome.STOPPED if result.outcome is Outcome.STOPPED else Outcome.UNKNOWN
    reason = result.reason if outcome is Outcome.STOPPED else why
    return replace(result, outcome=outcome, measured={}, reason=reason, message=message, unmeasured=why)


def not_begun(primitive: Primitive, reason: str, started_s: float) -> ActionResult:
    """Result of a step that the watch stopped before any command was sent."""
    message = f"Stopped before it began ({reason.replace('_', ' ')})."
    return ActionResult(primitive, Outcome.STOPPED, {}, reason, message, started_s, time.monotonic())


def _drive(body: Body, motion: MotionController, track: _Track, watch: Watch) -> str:
    """Run the control loop until the motion ends (returns "") or the watch gives a reason."""
    start_s, n = body.now_s(), 0
    while True:
        asked_s, state = body.now_s(), body.state()
        reason, now_s = watch(state), body.now_s()
        if track.points or not reason:
            track.update(now_s, state, asked_s)
        if reason:
            return reason
        if (pose := known(state.pose)) is None or track.unmeasured:
            return JUMPED if track.unmeasured == JUMPED else "stale_state"
        velocity = motion.step(now_s, pose)
        if velocity is None:
            return ""
        body.command(velocity)
        track.sent.append((now_s, velocity))
        n = max(n + 1, math.ceil((now_s - start_s) * RATE_HZ))  # after a delay continue from now, without a burst
        body.wait_until(start_s + n / RATE_HZ)


def _come_to_rest(body: Body, track: _Track) -> None:
    """Record how the body coasts. The watch is not called, since the body is already stopping."""
    rest, end_s = RestDetector(STOPPED_WINDOW_S), body.now_s() + REST_LIMIT_S
    while body.now_s() < end_s and not rest.reached:
        body.wait_until(body.now_s() + 1 / RATE_HZ)
        asked_s, state, now_s = body.now_s(), body.state(), body.now_s()
        track.update(now_s, state, asked_s)
        if (pose := known(state.pose)) is None:
            return
        if state.age_s < FRESH_S:  # one that is commanded again and again keeps its place by itself
            rest.update(now_s, pose)


_ENDINGS = {
    "stalled": "it stopped making progress",
    "timeout": "it took too long",
    "inaccurate": "it did not come closer after several corrections",
    "arrived": "it ended there",
}


def classify_outcome(
    primitive: Primitive, measured: Mapping[str, float], how: str, *, stopped: bool
) -> tuple[Outcome, str, str]:
    """Return outcome, reason and message, from the requested and measured values alone (law 18)."""
    turn = primitive.op is Op.TURN
    asked = (primitive.degrees if turn else primitive.distance_m) or 0.0
    got = measured["degrees" if turn else "distance_m"]
    shown = (round(got, 1) if turn else round(got, 2)) + 0.0  # a negative zero becomes one without sign
    pair = f"Asked {asked:g}°, measured {shown:.1f}°" if turn else f"Asked {asked:g} m, measured {shown:.2f} m"
    if stopped:
        return Outcome.STOPPED, how, f"{pair}: stopped ({how.replace('_', ' ')})."
    allowed = (TOLERANCE_DEG if turn else TOLERANCE_M) + TOLERANCE_SHARE * asked
    aside_m = measured["drift_m"] if turn else abs(measured["sideways_m"])
    turned_deg = 0.0 if turn else abs(measured["heading_deg"])
    aside_allowed_m = TOLERANCE_M if turn else allowed
    if abs(got - asked) <= allowed and aside_m <= aside_allowed_m and turned_deg <= TOLERANCE_DEG:
        return Outcome.DONE, "", f"{pair}."
    if turn:
        pair += f", {100 * aside_m:.0f} cm off its place"
    else:
        pair += f", {100 * aside_m:.0f} cm aside and {turned_deg:.0f}° off its heading"
    outcome = Outcome.INACCURATE if abs(got - asked) <= max(allowed, 0.2 * asked) else Outcome.FAILED
    word = "inaccurate" if how == "arrived" else how
    return outcome, word, f"{pair}: {_ENDINGS.get(how, how)}."
