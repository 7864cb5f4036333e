"""Whether a world can be: names, room for the robots, and that what is said to be free is free."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from agentrob.sim.world.scene import Placed, Scene, StartPlace

#: From the middle of a robot at its start to the nearest thing; from a place called free to the nearest thing.
START_CLEAR_M, FREE_CLEAR_M = 0.55, 0.30
#: Robots at their starts are further apart than this.
APART_M = 1.0
#: What begins higher than this hinders nobody.
OVERHEAD_M = 1.5
GRID_M = 0.1
RESERVED = ("floor", "box", *(f"wall {side}" for side in ("front", "left", "back", "right")))

Points = NDArray[np.float64]  # (n, 2)


def objection(scene: Scene) -> str:
    """Why this world cannot be, in one sentence; empty when it can."""
    return next(_objections(scene), "")


def _objections(scene: Scene) -> Iterator[str]:
    from agentrob.sim.world.scene import MOST_PARTS

    for name, count in Counter(thing.name for thing in scene.thing).items():
        if count > 1:
            yield f"{count} things are named {name!r}; each needs a name of its own"
        if name in RESERVED:
            yield f"no thing may be named {name!r}: the room itself uses that name"
    bodies = scene.bodies()
    if len({body.name for body in bodies}) < len(bodies):
        yield "names of things must differ in more than spaces, and from the names of another's parts (table_0)"
    if len(bodies) > MOST_PARTS:
        yield f"it has {len(bodies)} bodies; at most {MOST_PARTS} are allowed"
    if not scene.start:
        yield "start: it needs at least one, for example [start.go2] with at_m = [0, 0]"
    hindering = [b for b in bodies if b.solid and _underside_m(b) < OVERHEAD_M]
    for robot, place in scene.start.items():
        yield from _misplaced(scene, robot, place, hindering)
    places = list(scene.start.items())
    for k, (robot, place) in enumerate(places):
        for other, its in places[k + 1 :]:
            if math.dist(place.at_m, its.at_m) < APART_M:
                yield f"start.{robot} and start.{other} are nearer than {APART_M:g} m"


def _misplaced(scene: Scene, robot: str, place: StartPlace, bodies: list[Placed]) -> Iterator[str]:
    where = f"start.{robot}"
    at = np.array([place.at_m])
    if (inside_m := _inside_m(scene, at)) < START_CLEAR_M:
        yield f"{where}: at_m must be in the room and {START_CLEAR_M:g} m from its walls (found {inside_m:.2f} m)"
    for body in bodies:
        if (distance_m := distances_m(body, at).min()) < START_CLEAR_M:
            yield f"{where}: {body.name} is {distance_m:.2f} m away; {START_CLEAR_M:g} m are needed"
    if place.free is None:
        if robot == "g1":
            yield (
                f"{where} needs free = {{ ahead_m = …, behind_m = …, left_m = …, right_m = … }}: the G1 senses nothing "
                "around it and may walk only where nothing stands"
            )
        return
    points = _grid(place)
    if (inside_m := _inside_m(scene, points)) < FREE_CLEAR_M:
        yield f"{where}.free: it must end {FREE_CLEAR_M:g} m before the walls (found {inside_m:.2f} m)"
    for body in bodies:
        if (distance_m := distances_m(body, points).min()) < FREE_CLEAR_M:
            yield f"{where}.free: {body.name} is {distance_m:.2f} m from it; {FREE_CLEAR_M:g} m are needed"


def _underside_m(body: Placed) -> float:
    return body.at_m[2] - body.size_m[-1]


def _inside_m(scene: Scene, points: Points) -> float:
    """From the nearest of the points to a wall; negative outside."""
    if not scene.room.height_m:
        return math.inf
    return float((np.array(scene.room.size_m) / 2 - np.abs(points)).min())


def _grid(place: StartPlace) -> Points:
    """Points all over what is said to be free."""
    assert place.free is not None
    free, start = place.free, place.start
    x = np.linspace(-free.behind_m, free.ahead_m, 2 + round((free.ahead_m + free.behind_m) / GRID_M))
    y = np.linspace(-free.right_m, free.left_m, 2 + round((free.left_m + free.right_m) / GRID_M))
    xs, ys = (grid.ravel() for grid in np.meshgrid(x, y))
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    return np.stack([start.x_m + c * xs - s * ys, start.y_m + s * xs + c * ys], axis=1)


def distances_m(body: Placed, points: Points) -> NDArray[np.float64]:
    """(n,) from each point to the body's outline seen from above; 0 within."""
    away = points - np.array(body.at_m[:2])
    if body.shape != "box":
        return np.asarray(np.maximum(np.hypot(away[:, 0], away[:, 1]) - body.size_m[0], 0.0))
    c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
    along = np.stack([c * away[:, 0] + s * away[:, 1], -s * away[:, 0] + c * away[:, 1]], axis=1)
    beyond = np.maximum(np.abs(along) - np.array(body.size_m[:2]), 0.0)
    return np.asarray(np.hypot(beyond[:, 0], beyond[:, 1]))
