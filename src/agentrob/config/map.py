"""The `[robots.NAME.map]` table: what the live map shows around a robot.

[robots.rex.map]
room = "lab"                  # robots with the same room are drawn on one map
home_at_m = [1.0, -0.5]       # where the robot's home is in the room, and which way it faces there
home_facing_deg = 90
size_m = [8, 6]               # the walls, with the room's origin in their middle
things = [
  { name = "table", at_m = [1.2, -2.5], size_m = [1.24, 0.72], colour = "#996940" },
  { name = "column", at_m = [3.5, 1.5], radius_m = 0.16 },
]
"""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from agentrob.config.section import Section

#: The most things of a map: its description travels in the robot's card.
MOST_THINGS = 60
_Metres = Annotated[float, Field(allow_inf_nan=False, ge=-1000, le=1000)]
_Length = Annotated[float, Field(allow_inf_nan=False, gt=0, le=1000)]


class MapThing(Section):
    """A thing in the room, seen from above: a rectangle (`size_m`) or a circle (`radius_m`) around `at_m`.

    `turned_deg` turns a rectangle counter-clockwise. `name` and `colour` are shown.
    """

    name: Annotated[str, Field(max_length=40)] = ""
    at_m: tuple[_Metres, _Metres]
    size_m: tuple[_Length, _Length] | None = None
    radius_m: _Length | None = None
    turned_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    colour: Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")] = "#9aa4b0"

    @model_validator(mode="after")
    def _is_one_shape(self) -> Self:
        if (self.size_m is None) == (self.radius_m is None):
            raise ValueError("a thing of a map is either a rectangle (size_m) or a circle (radius_m)")
        return self


class MapConfig(Section):
    """The room of a robot as its live map shows it. Whoever may read one of the robot's boards sees the map.

    Positions are in metres in the frame of `room`: x and y as you choose them, `home_at_m` and `home_facing_deg` say
    where the robot's home is in it. `size_m` draws walls around the room's origin. Without a `room` the robot has a
    map of its own, around its home. Only the `things` that are listed are shown; if there are any, the forum also gets
    the robot's `scene`, to judge by it what people write before they post it. `geometry` is where the robot's shape
    for the 3D view comes from: `auto` (made from the installed models of a Go2 or G1, extra `sim`), a URL (`agentrob
    sim` serves one, with its room), or `none`. Without a shape there is only the map.
    """

    room: Annotated[str, Field(pattern=r"^([a-z0-9][a-z0-9 _-]{0,39})?$")] = ""
    home_at_m: tuple[_Metres, _Metres] = (0.0, 0.0)
    home_facing_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    size_m: tuple[_Length, _Length] | None = None
    things: Annotated[tuple[MapThing, ...], Field(max_length=MOST_THINGS)] = ()
    geometry: Annotated[str, Field(pattern=r"^(auto|none|https?://\S+)$")] = "auto"
