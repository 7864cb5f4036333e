"""The map of a room, as a page draws it: its walls, fence and things, and where its robots are.

Everything comes from robots' agents; what is malformed is left out. In pictures y points down, so y is negated here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from agentrob.board.auth import visibility
from agentrob.board.services import Services
from agentrob.errors import BoardError
from agentrob.model import Account

_COLOUR = re.compile(r"#[0-9a-fA-F]{6}\Z")
MOST_THINGS, MOST_POINTS, FAR_M = 60, 3000, 1000.0
#: Around what is drawn, in metres.
MARGIN_M = 0.3
#: A fence that is behind a wall is drawn this far in front of it.
WALL_M = 0.06


@dataclass(frozen=True, slots=True)
class ThingView:
    """A thing from above: a rectangle of `size`, or a circle of `radius` if it has no size."""

    name: str
    x: float
    y: float
    turned: float
    size: tuple[float, float] | None
    radius: float
    colour: str


@dataclass(frozen=True, slots=True)
class MapView:
    """One robot's map. `pose` is where it last was, `fence` and `measured` are points of an SVG polyline. `simulated`:
    the path is that of a preview."""

    room: str
    size: tuple[float, float] | None = None
    fence: str = ""
    corners: tuple[tuple[float, float], ...] = ()
    things: tuple[ThingView, ...] = ()
    pose: tuple[float, float, float] | None = None
    plan: str = ""
    measured: str = ""
    geometry: str = ""
    shapeless: bool = False
    simulated: bool = False


@dataclass(frozen=True, slots=True)
class RoomView:
    """The map of a room with the robots in it: (name, map). `box` is the viewBox."""

    room: str
    box: str
    wide: float
    high: float
    size: tuple[float, float] | None
    things: tuple[ThingView, ...]
    robots: tuple[tuple[str, MapView], ...]

    @property
    def label(self) -> str:
        """The robots in the room, in a few words."""
        names = [name for name, _ in self.robots]
        return ", ".join(names[:2]) + (f" and {len(names) - 2} more" if len(names) > 2 else "")

    @property
    def solid(self) -> bool:
        """Whether there may be a 3D view: some robot's agent does not say that it has no shape."""
        return not all(view.shapeless for _, view in self.robots)


def map_view(data: object) -> MapView | None:
    """The map in a robot's card or replay; None if there is none."""
    if not isinstance(data, Mapping) or not isinstance(room := data.get("room"), str) or not room:
        return None
    fence, things = _points(data.get("fence")), data.get("things")
    found = map(_thing, things[:MOST_THINGS]) if isinstance(things, Sequence) and not isinstance(things, str) else ()
    size = _numbers(data.get("size_m"), 2)
    pose = _numbers(data.get("pose"), 3)
    name = data.get("geometry")
    return MapView(
        room=room[:64],
        size=(size[0], size[1]) if size and min(size) > 0 else None,
        fence=line(fence),
        corners=tuple(fence),
        things=tuple(thing for thing in found if thing is not None),
        pose=drawn_pose(pose) if pose else None,
        geometry=name if isinstance(name, str) and re.fullmatch(r"[0-9a-f]{32}", name) else "",
        shapeless=bool(data.get("no_geometry")),
    )


def rooms(maps: Iterable[tuple[str, MapView | None]]) -> tuple[RoomView, ...]:
    """The rooms of these robots, those with most robots first. Things that several robots describe are drawn once."""
    by_room: dict[str, list[tuple[str, MapView]]] = {}
    for name, one in maps:
        if one is not None:
            by_room.setdefault(one.room, []).append((name, one))
    found = [_room(room, tuple(robots)) for room, robots in by_room.items()]
    return tuple(sorted(found, key=lambda room: -len(room.robots)))


def _room(name: str, robots: tuple[tuple[str, MapView], ...]) -> RoomView:
    size = next((one.size for _, one in robots if one.size), None)
    things = tuple(dict.fromkeys(thing for _, one in robots for thing in one.things))
    xs, ys = [0.0], [0.0]
    if size is not None:
        xs, ys = [-size[0] / 2, size[0] / 2], [-size[1] / 2, size[1] / 2]
    for _, one in robots:
        if size is None:
            xs += [x for x, _ in one.corners]
            ys += [-y for _, y in one.corners]
        if one.pose is not None:
            xs.append(one.pose[0])
            ys.append(one.pose[1])
    left, top = min(xs) - MARGIN_M, min(ys) - MARGIN_M
    wide, high = max(xs) + MARGIN_M - left, max(ys) + MARGIN_M - top
    box = f"{left:.2f} {top:.2f} {wide:.2f} {high:.2f}"
    if size is not None:
        robots = tuple((robot, replace(one, fence=line(inside(one.corners, size)))) for robot, one in robots)
    return RoomView(name, box, round(wide, 2), round(high, 2), size, things, robots)


def inside(corners: Sequence[tuple[float, float]], size: tuple[float, float]) -> list[tuple[float, float]]:
    """The part of a fence that is inside the walls, as a polygon: where the fence is behind a wall, it runs along that
    wall, so that it is closed. Empty if all of it is behind a wall."""
    found = list(corners)
    for axis, bound in ((0, size[0] / 2 - WALL_M), (1, size[1] / 2 - WALL_M)):
        for side in (1, -1):
            kept, found = found, []
            for n, point in enumerate(kept):
                before = kept[n - 1]
                here, there = bound - side * point[axis], bound - side * before[axis]
                if (here >= 0) != (there >= 0):
                    part = there / (there - here)
                    crossing = [before[k] + part * (point[k] - before[k]) for k in (0, 1)]
                    found.append((crossing[0], crossing[1]))
                if here >= 0:
                    found.append(point)
    return found


def line(points: Iterable[Sequence[float]]) -> str:
    """Points in the room as those of an SVG polyline."""
    return " ".join(f"{x:.2f},{-y:.2f}" for x, y in (point[:2] for point in points))


def drawn_pose(pose: Sequence[float]) -> tuple[float, float, float]:
    """A pose as x and y of the picture, and degrees clockwise."""
    return round(pose[0], 3), round(-pose[1], 3), round(-math.degrees(pose[2]), 1)


def with_paths(one: MapView, plan: Sequence[Sequence[float]], poses: Sequence[Sequence[float]]) -> MapView:
    """The map with a planned and a measured path; `poses` are x, y and yaw."""
    return replace(one, plan=line(plan), measured=line(poses), pose=drawn_pose(poses[-1]) if poses else one.pose)


def _thing(data: object) -> ThingView | None:
    if not isinstance(data, Mapping) or (at := _numbers(data.get("at_m"), 2)) is None:
        return None
    size, radius = _numbers(data.get("size_m"), 2), _number(data.get("radius_m"))
    if size is None and radius is None:
        return None
    colour, name = data.get("colour"), data.get("name")
    return ThingView(
        name=name[:40] if isinstance(name, str) else "",
        x=round(at[0], 3),
        y=round(-at[1], 3),
        turned=round(-(_number(data.get("turned_deg")) or 0.0), 1),
        size=(abs(size[0]), abs(size[1])) if size else None,
        radius=abs(radius or 0.0),
        colour=colour if isinstance(colour, str) and _COLOUR.match(colour) else "#9aa4b0",
    )


def _points(data: object) -> list[tuple[float, float]]:
    if not isinstance(data, Sequence) or isinstance(data, str):
        return []
    found = (_numbers(point, 2) for point in data[:MOST_POINTS])
    return [(point[0], point[1]) for point in found if point is not None]


def _numbers(data: object, count: int) -> list[float] | None:
    if not isinstance(data, Sequence) or isinstance(data, str) or len(data) != count:
        return None
    found = [_number(value) for value in data]
    return None if None in found else [value for value in found if value is not None]


def _number(data: object) -> float | None:
    if isinstance(data, bool) or not isinstance(data, int | float) or not abs(data) <= FAR_M:
        return None
    return float(data)


# -------------------------------------------------------------------- rights
def may_see(services: Services, robot: str, account: Account | None) -> bool:
    """Whether an account may see the robot's map: that of every reader of a board on which the robot acts."""
    boards = services.store.everything.all_boards()
    readable = visibility.boards_readable_by(boards, account, services.settings.public_read)
    return shows(services.presence.robot(robot).card, readable)


def shows(card: Mapping[str, Any], readable: frozenset[str]) -> bool:
    """Whether a reader of these boards may see the map of the robot with this card."""
    data = card.get("boards")
    boards = data if isinstance(data, list | tuple) else (card.get("board"),)
    named = {board for board in boards if isinstance(board, str) and board}
    return bool(named & readable if named else readable)


def check(services: Services, robot: str, account: Account | None) -> None:
    """403 unless the account may see the robot's map."""
    if not may_see(services, robot, account):
        what = f"the map of {robot} is for those who may read a board on which it acts"
        raise BoardError(403, "no_map", what, "ask an admin for the right to read that board")
