"""Where a robot is in its room, and the description of the room for the live map. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from agentrob.agent.media.plot import path_of
from agentrob.config.robots import RobotConfig
from agentrob.model import Pose, Primitive

Point = tuple[float, float]


class RoomMap:
    """The room of one robot as its owner describes it (`[robots.NAME.map]`). Poses come in the frame of the home."""

    def __init__(self, robot: str, settings: RobotConfig) -> None:
        self._robot, self._settings, self._map = robot, settings, settings.map
        (x_m, y_m), yaw_rad = self._map.home_at_m, math.radians(self._map.home_facing_deg)
        self._home = Pose(x_m, y_m, yaw_rad)

    def in_room(self, pose: Pose) -> Pose:
        """A pose in the frame of the room."""
        return _placed(self._home, pose)

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
            "room": self._map.room or f"@{self._robot}",
            "size_m": list(self._map.size_m) if self._map.size_m else None,
            "fence": [[round(p.x_m, 3), round(p.y_m, 3)] for p in at_home],
            "home": [round(v, 3) for v in (self._home.x_m, self._home.y_m, self._home.yaw_rad)],
            "things": [
                {**thing, **{key: list(thing[key]) for key in ("at_m", "size_m") if thing.get(key)}} for thing in things
            ],
        }


def _placed(frame: Pose, pose: Pose) -> Pose:
    """A pose that is relative to `frame`, in the frame that `frame` is in."""
    c, s = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    x_m, y_m = frame.x_m + c * pose.x_m - s * pose.y_m, frame.y_m + s * pose.x_m + c * pose.y_m
    return Pose(x_m, y_m, math.remainder(frame.yaw_rad + pose.yaw_rad, math.tau))


def _distinct(points: Sequence[Point]) -> list[Point]:
    return [point for n, point in enumerate(points) if n == 0 or point != points[n - 1]]
