"""A preview without a simulation: the exact path, the fence, the limits, and the things of the owner's map."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from agentrob.config.map import MapThing
from agentrob.model import Capabilities, Direction, Op, Outcome, Plan, Pose, Primitive
from agentrob.model.estimate import step_seconds
from agentrob.rehearsal.preview import Basis, Missing, OtherRobot, Point, Preview, PreviewRequest, RehearsedStep, Run
from agentrob.robots.protocol import BODY_RADIUS_M
from agentrob.robots.safety.fence import Fence
from agentrob.robots.safety.limits import beyond_limits
from agentrob.sim.world.scene import PlacedBody, distances_m

#: Distances are computed at points of the path that are at most this far apart.
SPACING_M = 0.05
#: Half the length and half the width of robots, seen from above.
HALF_M = {"go2": (0.35, 0.16), "g1": (0.20, 0.25)}


def in_frame(frame: Pose, pose: Pose) -> Pose:
    """A pose that is relative to `frame`, in the frame that `frame` is in."""
    c, s = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    x_m, y_m = frame.x_m + c * pose.x_m - s * pose.y_m, frame.y_m + s * pose.x_m + c * pose.y_m
    return Pose(x_m, y_m, math.remainder(frame.yaw_rad + pose.yaw_rad, math.tau))


def seen_from(frame: Pose, pose: Pose) -> Pose:
    """The inverse of `in_frame`: a pose of the outer frame, relative to `frame`."""
    c, s = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    dx, dy = pose.x_m - frame.x_m, pose.y_m - frame.y_m
    return Pose(c * dx + s * dy, -s * dx + c * dy, math.remainder(pose.yaw_rad - frame.yaw_rad, math.tau))


def after(pose: Pose, step: Primitive) -> Pose:
    """Where a step leads, as if it were exact."""
    if step.op is Op.TURN:
        degrees = -(step.degrees or 0.0) if step.direction is Direction.RIGHT else step.degrees or 0.0
        return in_frame(pose, Pose(0.0, 0.0, math.radians(degrees)))
    if step.op is Op.MOVE:
        forward, left = (step.direction or Direction.FORWARD).unit_vector
        distance_m = step.distance_m or 0.0
        return in_frame(pose, Pose(forward * distance_m, left * distance_m, 0.0))
    return pose


def planned_path(start: Pose, plan: Plan) -> tuple[Point, ...]:
    """The corners of the path, as if every step were exact."""
    poses = [start]
    for step in plan.steps:
        poses.append(after(poses[-1], step))
    return tuple((p.x_m, p.y_m, p.yaw_rad) for p in poses)


def geometry_preview(request: PreviewRequest, capabilities: Capabilities, missing: Missing) -> Preview:
    """The preview of a robot that cannot be simulated now, and why."""
    start = request.start or Pose(0.0, 0.0, 0.0)
    steps, seconds = _steps(request, capabilities)
    allowed = Plan(tuple(step.primitive for step in steps if step.outcome is Outcome.DONE))
    path = _dense(planned_path(start, allowed))
    distances: dict[str, float] = {}
    if request.start is not None:
        bodies = [*map_bodies(request.settings.map.things), *robot_bodies(request.others)]
        half_m = HALF_M.get(request.settings.model, (BODY_RADIUS_M, BODY_RADIUS_M))
        distances = least_distances(path, bodies, half_m)
    run = Run(path, seconds, steps, distances)
    planned = planned_path(start, request.plan)
    return Preview(
        request.robot, Basis.GEOMETRY, request.plan, request.start, planned, (run,), request.others,
        request.others_known, missing,
    )  # fmt: skip


def _steps(request: PreviewRequest, capabilities: Capabilities) -> tuple[tuple[RehearsedStep, ...], float]:
    """The guard's decision on each step by geometry and limits alone, until the first that it refuses."""
    fence = Fence(request.settings.fence, Pose(0.0, 0.0, 0.0))
    at = seen_from(request.home, request.start) if request.start is not None else None
    found, seconds = list[RehearsedStep](), 0.0
    for step in request.plan.steps:
        refusal = beyond_limits(step, capabilities)
        if refusal is None and request.halted and step.moves:
            refusal = "halted", request.halted
        if refusal is None and at is None and step.moves:
            refusal = "not_homed", "The robot has no home, so its fence is unknown; its owner must set home first."
        if refusal is None and at is not None and step.moves and (why := fence.refusal(at, step)) is not None:
            refusal = "fence", why
        here = in_frame(request.home, at) if at is not None else None
        where = (here.x_m, here.y_m, here.yaw_rad) if here is not None else None
        if refusal is not None:
            found.append(RehearsedStep(step, Outcome.REFUSED, *refusal, at=where))
            break
        took_s = step_seconds(step, capabilities)
        found.append(RehearsedStep(step, Outcome.DONE, seconds=took_s, at=where))
        seconds += took_s
        at = after(at, step) if at is not None else None
    return tuple(found), seconds


def _dense(path: Sequence[Point]) -> tuple[Point, ...]:
    """The path with a point every `SPACING_M`."""
    found = list(path[:1])
    for (x, y, _), (to_x, to_y, yaw) in pairwise(path):
        count = max(1, math.ceil(math.dist((x, y), (to_x, to_y)) / SPACING_M))
        found += [(x + (to_x - x) * k / count, y + (to_y - y) * k / count, yaw) for k in range(1, count + 1)]
    return tuple(found)


# -------------------------------------------------------------------- distances
def map_bodies(things: Iterable[MapThing]) -> list[tuple[str, PlacedBody]]:
    """The things of an owner's map, by name."""
    bodies = []
    for number, thing in enumerate(things, 1):
        name = thing.name or f"thing {number}"
        size = (thing.size_m[0] / 2, thing.size_m[1] / 2, 0.5) if thing.size_m else (thing.radius_m or 0.0, 0.5)
        shape, yaw_rad = ("box" if thing.size_m else "column"), math.radians(thing.turned_deg)
        bodies.append((name, PlacedBody(name, shape, (*thing.at_m, 0.5), yaw_rad, size, thing.colour, True, True)))  # type: ignore[arg-type]
    return bodies


def robot_bodies(others: Iterable[OtherRobot]) -> list[tuple[str, PlacedBody]]:
    """Other robots, as the boxes that they stand in."""
    bodies = []
    for other in others:
        length_m, width_m = HALF_M.get(other.model, (BODY_RADIUS_M, BODY_RADIUS_M))
        at = (other.pose.x_m, other.pose.y_m, 0.6)
        body = PlacedBody(other.name, "box", at, other.pose.yaw_rad, (length_m, width_m, 0.6), "gray", True, True)
        bodies.append((f"@{other.name}", body))
    return bodies


def least_distances(
    path: Sequence[Point], bodies: Iterable[tuple[str, PlacedBody]], half_m: tuple[float, float]
) -> dict[str, float]:
    """The least distance from the outline of a body that takes this path to each named thing; 0 within."""
    points = outlines(path, half_m)
    least: dict[str, float] = {}
    for name, body in bodies:
        metres = float(distances_m(body, points).min())
        least[name] = min(metres, least.get(name, metres))
    return least


def outlines(path: Sequence[Point], half_m: tuple[float, float]) -> NDArray[np.float64]:
    """(n, 2) points on the outline of a rectangular body, and in its middle, along a path."""
    along, across = half_m
    corners = [(x * along, y * across) for x in (-1.0, -0.5, 0.0, 0.5, 1.0) for y in (-1.0, 0.0, 1.0)]
    c, s = np.cos([p[2] for p in path]), np.sin([p[2] for p in path])
    x, y = np.array([p[0] for p in path]), np.array([p[1] for p in path])
    columns = [np.stack([x + c * dx - s * dy, y + s * dx + c * dy], axis=1) for dx, dy in corners]
    return np.concatenate(columns)
