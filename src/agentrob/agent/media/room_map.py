"""Where a robot is in its room, and the description of the room for the live map. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from agentrob.agent.media.plot import path_of
from agentrob.config.map import MapThing
from agentrob.config.robots import RobotConfig
from agentrob.minds.visual_loop.vocabulary import thing_named
from agentrob.model import Pose, Primitive

Point = tuple[float, float]


class RoomMap:
    """The room of one robot as its owner describes it (`[robots.NAME.map]`). Poses come in the frame of the home."""

    def __init__(self, robot: str, settings: RobotConfig) -> None:
        self._robot, self._settings, self._map = robot, settings, settings.map
        (x_m, y_m), yaw_rad = self._map.home_at_m, math.radians(self._map.home_facing_deg)
        self._home = Pose(x_m, y_m, yaw_rad)

    @property
    def name(self) -> str:
        """The name of the room; robots that share it are in one frame."""
        return self._map.room or f"@{self._robot}"

    def in_room(self, pose: Pose) -> Pose:
        """A pose in the frame of the room."""
        return _placed(self._home, pose)

    def thing(self, words: str) -> MapThing | None:
        """The thing of the map that people call so, in English or Chinese; None if there is none, or more than one.

        Things of one name whose centre lies within another of that name are its parts, like the legs of a table.
        """
        named = [thing for thing in self._map.things if thing.name]
        found = [thing for thing in named if thing.name.casefold() == words.casefold()]
        if not found and (asked := thing_named(words)):
            found = [thing for thing in named if asked.fits(thing_named(thing.name))]
        whole = max(found, key=_area_m2, default=None)
        if whole is None or any(_metres_to(whole, *part.at_m) > 0 for part in found):
            return None
        return whole

    def metres_to(self, words: str, pose: Pose) -> float | None:
        """How far a pose in the frame of the home is from the outline of a thing, 0 within it; None for an unknown
        thing."""
        if (thing := self.thing(words)) is None:
            return None
        at = self.in_room(pose)
        return _metres_to(thing, at.x_m, at.y_m)

    def planned(self, start: Pose, steps: Iterable[Primitive]) -> list[Point]:
        """The requested path from `start`, which is in the frame of the room, as if every step were exact."""
        poses = (_placed(start, pose) for pose in path_of(steps))
        return _distinct([(round(p.x_m, 3), round(p.y_m, 3)) for p in poses])

    def as_data(self) -> dict[str, Any]:
        """The description that the forum draws: all positions in the frame of the room, in metres and degrees."""
        fence = self._settings.fence
        corners = [
            (fence.x_min_m, fence.y_min_m), (fence.x_max_m, fence.y_min_m),
            (fence.x_max_m, fence.y_max_m), (fence.x_min_m, fence.y_max_m),
        ]  # fmt: skip
        at_home = [self.in_room(Pose(x, y, 0.0)) for x, y in corners]
        things = [thing.model_dump(exclude_defaults=True) for thing in self._map.things]
        return {
            "room": self.name,
            "size_m": list(self._map.size_m) if self._map.size_m else None,
            "fence": [[round(p.x_m, 3), round(p.y_m, 3)] for p in at_home],
            "home": [round(v, 3) for v in (self._home.x_m, self._home.y_m, self._home.yaw_rad)],
            "things": [
                {**thing, **{key: list(thing[key]) for key in ("at_m", "size_m") if thing.get(key)}} for thing in things
            ],
        }


def _metres_to(thing: MapThing, x_m: float, y_m: float) -> float:
    """The distance from a point of the room to the outline of a thing, 0 within it."""
    dx, dy, turned = x_m - thing.at_m[0], y_m - thing.at_m[1], math.radians(thing.turned_deg)
    if thing.size_m is None:
        return max(0.0, math.hypot(dx, dy) - (thing.radius_m or 0.0))
    along = abs(math.cos(turned) * dx + math.sin(turned) * dy) - thing.size_m[0] / 2
    across = abs(-math.sin(turned) * dx + math.cos(turned) * dy) - thing.size_m[1] / 2
    return math.hypot(max(0.0, along), max(0.0, across))


def _area_m2(thing: MapThing) -> float:
    if thing.size_m is None:
        return math.pi * (thing.radius_m or 0.0) ** 2
    return thing.size_m[0] * thing.size_m[1]


def _placed(frame: Pose, pose: Pose) -> Pose:
    """A pose that is relative to `frame`, in the frame that `frame` is in."""
    c, s = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    x_m, y_m = frame.x_m + c * pose.x_m - s * pose.y_m, frame.y_m + s * pose.x_m + c * pose.y_m
    return Pose(x_m, y_m, math.remainder(frame.yaw_rad + pose.yaw_rad, math.tau))


def _distinct(points: Sequence[Point]) -> list[Point]:
    return [point for n, point in enumerate(points) if n == 0 or point != points[n - 1]]
