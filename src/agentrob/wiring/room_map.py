"""The live map of a simulated room, from its world file."""

from __future__ import annotations

import math
import re

from agentrob.config.map import MOST_THINGS, MapConfig, MapThing
from agentrob.sim.world.scene import Scene, rgba

#: What begins higher than this hangs on a wall or lies on something; what ends lower is as flat as a rug.
REACH_M, FLAT_M = 0.7, 0.02


def map_of(scene: Scene, model: str) -> MapConfig:
    """The map of a simulated room: what stands in it, and where this robot starts, which is its home."""
    start = scene.place(model)
    things = []
    for body in scene.bodies():
        low_m, high_m = body.at_m[2] - body.size_m[-1], body.at_m[2] + body.size_m[-1]
        if not (low_m < REACH_M and high_m > FLAT_M):
            continue
        colour = "#" + "".join(f"{round(255 * part):02x}" for part in rgba(body.colour)[:3])
        round_ = body.shape != "box"
        size = None if round_ else (round(2 * body.size_m[0], 3), round(2 * body.size_m[1], 3))
        things.append(
            MapThing(
                name=body.name.rstrip("0123456789").rstrip("_").replace("_", " "),
                at_m=(round(body.at_m[0], 3), round(body.at_m[1], 3)),
                size_m=size,
                radius_m=round(body.size_m[0], 3) if round_ else None,
                turned_deg=round(math.degrees(body.yaw_rad), 1),
                colour=colour,
            )
        )
    return MapConfig(
        room=re.sub(r"[^a-z0-9 _-]", "-", scene.name.lower())[:40].lstrip(" _-"),
        home_at_m=start.at_m,
        home_facing_deg=start.facing_deg,
        size_m=scene.room.size_m if scene.room.height_m else None,
        things=tuple(things[:MOST_THINGS]),
    )
