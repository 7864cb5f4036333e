"""Compute a command's recording: poses, measured and commanded velocities, and steps slowed down by a limit. Pure."""

from __future__ import annotations

import bisect
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from agentrob.model import ActionResult, Op, Pose

#: Velocity is averaged over this window; over a shorter one it is mostly odometry noise and the sway of the gait.
WINDOW_S = 0.4
#: If the commanded speed stays at its maximum for this many control periods, a limit held it there.
HELD_SAMPLES = 6


class Velocity(NamedTuple):
    """In the body's frame: forward and left in m/s, counter-clockwise in rad/s."""

    forward_mps: float = 0.0
    left_mps: float = 0.0
    turn_rps: float = 0.0

    @property
    def speed_mps(self) -> float:
        return math.hypot(self.forward_mps, self.left_mps)


class Sample(NamedTuple):
    """One sample of a command. `t_s` counts from the start of its first step, `step` from 1."""

    t_s: float
    step: int
    pose: Pose
    measured: Velocity
    commanded: Velocity


class Clip(NamedTuple):
    """A step that was commanded at a lower speed than requested."""

    step: int
    asked_mps: float
    commanded_mps: float


def begins_s(results: Sequence[ActionResult]) -> float:
    """Return the start of the first step in monotonic seconds, or 0 if no step started."""
    return min((r.started_s for r in results if r.ended_s > r.started_s), default=0.0)


def seconds(results: Sequence[ActionResult]) -> float:
    """Return the duration of all steps, including pauses."""
    return max((r.ended_s for r in results), default=0.0) - begins_s(results) if begins_s(results) else 0.0


def samples(results: Sequence[ActionResult]) -> Iterator[Sample]:
    """Yield the samples of the whole command in order. Steps without a path (gestures, pictures) have none."""
    zero_s = begins_s(results)
    for number, result in enumerate(results, 1):
        times_s = [point[0] for point in result.path]
        sent_s = [c[0] for c in result.commanded]
        # Simulated time may run faster than real time: scale it to real time.
        scale = min(1.0, result.duration_s / times_s[-1]) if times_s and times_s[-1] > 0 else 1.0
        for i, (t_s, *where) in enumerate(result.path):
            at = bisect.bisect_right(sent_s, t_s) - 1
            commanded = Velocity(*result.commanded[at][1:]) if at >= 0 else Velocity()
            pose = Pose(*where)
            yield Sample(result.started_s - zero_s + t_s * scale, number, pose, _measured(result, i), commanded)


def _measured(result: ActionResult, i: int) -> Velocity:
    """Compute the velocity at one point from the odometry within the window around it."""
    path = result.path
    first = last = i
    while first > 0 and path[i][0] - path[first - 1][0] <= WINDOW_S / 2:
        first -= 1
    while last + 1 < len(path) and path[last + 1][0] - path[i][0] <= WINDOW_S / 2:
        last += 1
    if (dt := path[last][0] - path[first][0]) <= 0:
        return Velocity()
    dx, dy = path[last][1] - path[first][1], path[last][2] - path[first][2]
    yaw = path[i][3]
    turned = math.remainder(path[last][3] - path[first][3], math.tau)
    c, s = math.cos(yaw), math.sin(yaw)
    return Velocity((c * dx + s * dy) / dt, (-s * dx + c * dy) / dt, turned / dt)


def clips(results: Sequence[ActionResult]) -> tuple[Clip, ...]:
    """Return the steps slower than requested, because of a limit, a gait or unknown ranges."""
    found = []
    for number, result in enumerate(results, 1):
        asked_mps = result.primitive.speed_mps
        if result.primitive.op is not Op.MOVE or not asked_mps or not result.commanded:
            continue
        speeds = [Velocity(*c[1:]).speed_mps for c in result.commanded]
        held = sum(v >= 0.99 * max(speeds) for v in speeds)
        if max(speeds) < 0.95 * asked_mps and held >= HELD_SAMPLES:
            found.append(Clip(number, asked_mps, round(max(speeds), 2)))
    return tuple(found)


def lines(results: Sequence[ActionResult], **head: Any) -> Iterator[dict[str, Any]]:
    """Yield the recording as JSON objects: a head, then samples and events in order of time.

    Poses are odometry in the robot's own frame (REP-103, metres and radians), velocities are in its body's frame.
    """
    yield {"recording": 1, "units": "s, m, rad, m/s, rad/s", **head}
    zero_s, clipped = begins_s(results), {clip.step: clip for clip in clips(results)}
    moments = list(samples(results))
    for number, result in enumerate(results, 1):
        step = {"step": number, "op": str(result.primitive.op)}
        if result.ended_s > result.started_s:
            yield {"t": _r(result.started_s - zero_s), "event": "begin", **step, "asked": result.primitive.asked()}
        for moment in (m for m in moments if m.step == number):
            yield {
                "t": _r(moment.t_s),
                "step": number,
                "pose": [moment.pose.x_m, moment.pose.y_m, moment.pose.yaw_rad],
                "measured": [_r(v) for v in moment.measured],
                "commanded": list(moment.commanded),
            }
        if clip := clipped.get(number):
            slow = {"asked_mps": clip.asked_mps, "commanded_mps": clip.commanded_mps}
            yield {"t": _r(result.ended_s - zero_s), "event": "clipped", **step, **slow}
        end = {"outcome": str(result.outcome), "reason": result.reason, "message": result.message}
        at = {"t": _r(result.ended_s - zero_s)} if result.ended_s else {}
        yield {**at, "event": "end", **step, **end, "measured": dict(result.measured)}


def _r(value: float) -> float:
    return round(value, 4)
