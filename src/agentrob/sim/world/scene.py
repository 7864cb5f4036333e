"""World files: the size of a room, the things in it and where each robot starts. docs/robots/worlds.md documents the
format.

Metres; x along the length, y along the width, the origin in the middle of the floor; degrees counter-clockwise from x.
"""

from __future__ import annotations

import math
import tomllib
from collections import Counter
from collections.abc import Iterator
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self, get_args

import numpy as np
from numpy.typing import NDArray
from PIL import ImageColor
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from agentrob.config.robots import SCENE_CHARS, FenceConfig
from agentrob.errors import SimError

Rgba = tuple[float, float, float, float]
Triple = tuple[float, float, float]
Shape = Literal["box", "ball", "column"]
Robot = Literal["go2", "g1"]
Points = NDArray[np.float64]  # (n, 2)

LARGEST_M = 50.0
MOST_PARTS = 400
#: From the middle of a robot at its start to the nearest thing; from a place called free to the nearest thing.
START_CLEAR_M, FREE_CLEAR_M = 0.55, 0.30
#: Robots at their starts are further apart than this.
APART_M = 1.0
#: Bodies that begin higher than this obstruct no robot.
OVERHEAD_M = 1.5
GRID_M = 0.1
RESERVED = ("floor", "box", *(f"wall {side}" for side in ("front", "left", "back", "right")))
#: What a shape's size is made of.
SIZES: dict[str, tuple[str, ...]] = {"box": ("size_m",), "ball": ("radius_m",), "column": ("radius_m", "height_m")}

_Finite = Field(allow_inf_nan=False, ge=-LARGEST_M, le=LARGEST_M)
_Edge = Field(allow_inf_nan=False, gt=0, le=LARGEST_M)
Metres = Annotated[float, _Finite]
Length = Annotated[float, _Edge]
Degrees = Annotated[float, Field(allow_inf_nan=False, ge=-360, le=360)]


def _known_colour(text: str) -> str:
    rgba(text)
    return text


def rgba(colour: str) -> Rgba:
    """A CSS colour (`red`, `#db241c`, `#0d08054d` with its opacity) as numbers from 0 to 1. Raises `ValueError`."""
    try:
        red, green, blue, alpha = (v / 255 for v in ImageColor.getcolor(colour, "RGBA"))  # type: ignore[union-attr]
    except ValueError:
        raise ValueError(f"{colour!r} is not a colour; valid: a CSS name such as 'red', or '#rrggbb'") from None
    return red, green, blue, alpha


Colour = Annotated[str, AfterValidator(_known_colour)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Start(NamedTuple):
    """Where a robot stands when the world begins: metres and radians."""

    x_m: float
    y_m: float
    yaw_rad: float


class PlacedBody(NamedTuple):
    """One simple body in the room: `size_m` are half edges (box), radius and half height (column) or radius (ball)."""

    name: str
    shape: Shape
    at_m: Triple  # its middle
    yaw_rad: float
    size_m: tuple[float, ...]
    colour: str
    solid: bool
    in_overview: bool


class Part(_Table):
    """A box, ball or column. `at_m` is the middle of its underside; the third number, its height, may be left out."""

    shape: Shape | None = None
    at_m: tuple[Metres, Metres] | tuple[Metres, Metres, Metres]
    turned_deg: Degrees = 0.0
    size_m: tuple[Length, Length, Length] | None = None
    radius_m: Length | None = None
    height_m: Length | None = None
    colour: Colour = "silver"
    solid: bool = True
    in_overview: bool = True

    @model_validator(mode="after")
    def _sized_as_its_shape(self) -> Self:
        given = {field for fields in SIZES.values() for field in fields if getattr(self, field) is not None}
        needed = set(SIZES[self.shape]) if self.shape else set()
        if given != needed:
            what = f"a {self.shape} has {' and '.join(SIZES[self.shape])}" if self.shape else "without a shape no size"
            raise ValueError(f"{what} (found {', '.join(sorted(given)) or 'none'})")
        return self

    def placed(self, name: str, at_m: Triple = (0.0, 0.0, 0.0), yaw_rad: float = 0.0) -> PlacedBody:
        """Where it is in the room, when it is a part of a thing at `at_m`."""
        assert self.shape is not None
        x, y, low = (*self.at_m, 0.0)[:3]
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        half: tuple[float, ...] = (self.radius_m or 0.0,)
        if self.size_m is not None:
            half = tuple(edge / 2 for edge in self.size_m)
        elif self.height_m is not None:
            half = (self.radius_m or 0.0, self.height_m / 2)
        middle = (at_m[0] + c * x - s * y, at_m[1] + s * x + c * y, at_m[2] + low + half[-1])
        turned = yaw_rad + math.radians(self.turned_deg)
        return PlacedBody(name, self.shape, middle, turned, half, self.colour, self.solid, self.in_overview)


class Thing(Part):
    """A named object: one body, or `parts` with places relative to the thing's. `note` is a remark about it."""

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9 -]{0,39}$")]
    note: Annotated[str, Field(max_length=200)] = ""
    parts: Annotated[tuple[Part, ...], Field(max_length=100)] = ()

    @model_validator(mode="after")
    def _one_body_or_parts(self) -> Self:
        if (self.shape is None) == (not self.parts):
            raise ValueError(f"{self.name!r} needs either a shape ({', '.join(get_args(Shape))}) or parts")
        if any(part.shape is None for part in self.parts):
            raise ValueError(f"each part of {self.name!r} needs a shape: {', '.join(get_args(Shape))}")
        return self

    def bodies(self) -> tuple[PlacedBody, ...]:
        word = self.name.replace(" ", "_")
        if self.shape is not None:
            return (self.placed(word),)
        x, y, low = (*self.at_m, 0.0)[:3]
        turned = math.radians(self.turned_deg)
        return tuple(part.placed(f"{word}_{k}", (x, y, low), turned) for k, part in enumerate(self.parts))


class Free(_Table):
    """The free space around a robot's start, in the robot's frame."""

    ahead_m: Annotated[float, Field(ge=0, le=LARGEST_M)]
    behind_m: Annotated[float, Field(ge=0, le=LARGEST_M)]
    left_m: Annotated[float, Field(ge=0, le=LARGEST_M)]
    right_m: Annotated[float, Field(ge=0, le=LARGEST_M)]

    @property
    def fence(self) -> FenceConfig:
        return FenceConfig(x_min_m=-self.behind_m, x_max_m=self.ahead_m, y_min_m=-self.right_m, y_max_m=self.left_m)


class StartPlace(_Table):
    """Where a robot starts. The G1 senses nothing around it and may walk in `free` only, so it needs one."""

    at_m: tuple[Metres, Metres]
    facing_deg: Degrees = 0.0
    free: Free | None = None

    @property
    def start(self) -> Start:
        return Start(*self.at_m, math.radians(self.facing_deg))


class Room(_Table):
    """Floor and walls. Without walls (`height_m` 0) the floor has no end."""

    size_m: tuple[Length, Length] = (8.0, 6.0)
    height_m: Annotated[float, Field(ge=0, le=10)] = 2.4
    walls: Colour = "#f2ede0"
    floor: Literal["planks", "tiles", "plain"] = "planks"
    floor_colour: Colour = "#bd9970"


class Camera(_Table):
    """The room's camera: its position, the point it looks at, and its vertical field of view."""

    at_m: tuple[Metres, Metres, Metres]
    to_m: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.15)
    fovy_deg: Annotated[float, Field(ge=10, le=100)] = 39.0

    @model_validator(mode="after")
    def _looks_somewhere(self) -> Self:
        if math.dist(self.at_m[:2], self.to_m[:2]) < 0.1:
            raise ValueError("it must not look straight down or up: at_m and to_m need another x or y")
        return self


class Light(_Table):
    """Parallel light from far away."""

    direction: tuple[Metres, Metres, Metres]
    strength: Annotated[float, Field(gt=0, le=2)] = 0.5

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Self:
        if not any(self.direction):
            raise ValueError("a light needs a direction, for example [0.4, 0.6, -0.8]")
        return self


#: One on the floor and both far walls, one on the near walls, one on the ceiling.
LIGHTS = (
    Light(direction=(0.45, 0.60, -0.85), strength=0.55),
    Light(direction=(-0.55, -0.45, -0.30), strength=0.32),
    Light(direction=(0.05, 0.05, 1.0), strength=0.48),
)


class Scene(_Table):
    """A whole world. `about` describes the place in a sentence or two, for people and for the screening of commands."""

    name: str = ""
    about: Annotated[str, Field(min_length=1, max_length=300)]
    room: Room = Room()
    start: dict[Robot, StartPlace]
    camera: Camera | None = None
    light: tuple[Light, ...] = LIGHTS
    thing: tuple[Thing, ...] = ()

    @model_validator(mode="after")
    def _can_be(self) -> Self:
        if problem := next(_problems(self), ""):
            raise ValueError(problem)
        return self

    def bodies(self) -> tuple[PlacedBody, ...]:
        """All things in the room, without walls and floor."""
        return tuple(body for thing in self.thing for body in thing.bodies())

    def place(self, robot: str) -> StartPlace:
        """The start of a robot. Raises `SimError` if the world has none for it."""
        for kind, place in self.start.items():
            if kind == robot:
                return place
        raise SimError(f"the world {self.name!r} has no start for {robot}; it has one for: {', '.join(self.start)}")

    @property
    def in_words(self) -> str:
        """The contents of `description` in sentences, for the screening of commands."""
        things = [f"{thing.name} ({thing.note})" if thing.note else thing.name for thing in self.thing]
        return " ".join([self.about, *([f"Things here: {', '.join(things)}."] if things else [])])[:SCENE_CHARS]

    def description(self) -> dict[str, Any]:
        """The visible things of the room, without positions."""
        things = [{"name": thing.name, **({"note": thing.note} if thing.note else {})} for thing in self.thing]
        return {"world": self.name, "about": self.about, "size_m": list(self.room.size_m), "things": things}


# ---------------------------------------------------------------------- checks
def _problems(scene: Scene) -> Iterator[str]:
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


def _misplaced(scene: Scene, robot: str, place: StartPlace, bodies: list[PlacedBody]) -> Iterator[str]:
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


def _underside_m(body: PlacedBody) -> float:
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


def distances_m(body: PlacedBody, points: Points) -> NDArray[np.float64]:
    """(n,) from each point to the body's outline seen from above; 0 within."""
    away = points - np.array(body.at_m[:2])
    if body.shape != "box":
        return np.asarray(np.maximum(np.hypot(away[:, 0], away[:, 1]) - body.size_m[0], 0.0))
    c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
    along = np.stack([c * away[:, 0] + s * away[:, 1], -s * away[:, 0] + c * away[:, 1]], axis=1)
    beyond = np.maximum(np.abs(along) - np.array(body.size_m[:2]), 0.0)
    return np.asarray(np.hypot(beyond[:, 0], beyond[:, 1]))


#: A floor without walls or things.
OPEN_FLOOR = Scene(
    name="open floor",
    about="A floor without walls.",
    room=Room(height_m=0),
    start={
        "go2": StartPlace(at_m=(0, 0)),
        "g1": StartPlace(at_m=(0, 2), free=Free(ahead_m=9, behind_m=9, left_m=9, right_m=9)),
    },
)


# ---------------------------------------------------------------------- files
def shipped() -> dict[str, Traversable]:
    """The worlds that come with AgentRob, by name."""
    files = (resources.files("agentrob.sim.world") / "worlds").iterdir()
    return {f.name.removesuffix(".toml"): f for f in sorted(files, key=lambda f: f.name) if f.name.endswith(".toml")}


def load(world: str = "room") -> Scene:
    """A shipped world by its name, or one of a file. Raises `SimError` that says what would be valid."""
    known = shipped()
    source: Traversable | Path = known[world] if world in known else Path(world).expanduser()
    if world not in known and not (source.is_file() or world.endswith(".toml") or "/" in world):
        raise SimError(f"no world named {world!r}; valid: {', '.join(known)}; or give the path of a world's file")
    try:
        raw = tomllib.loads(source.read_text(encoding="utf-8"))
    except OSError as e:
        raise SimError(f"cannot read the world {world}: {e.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as e:
        raise SimError(f"the world {world} is not valid TOML: {e}") from None
    return parse({"name": source.name.removesuffix(".toml"), **raw}, world)


def parse(raw: dict[str, Any], source: str) -> Scene:
    """Check a world that is already read."""
    try:
        return Scene.model_validate(raw)
    except ValidationError as e:
        problems = list(dict.fromkeys(_explain(error, raw) for error in e.errors()))
        raise SimError(f"the world {source}: " + "; ".join(problems[:5])) from None


_TABLES: dict[str, type[_Table]] = {
    "room": Room,
    "start": StartPlace,
    "free": Free,
    "camera": Camera,
    "light": Light,
    "thing": Thing,
    "parts": Part,
}


def _explain(error: Any, raw: dict[str, Any]) -> str:
    """One fault as `thing 3 (red ball).radius_m: …`."""
    words, table, at = list[str](), "", raw
    for key in error["loc"]:
        at = at[key] if isinstance(at, dict | list) and key in (at if isinstance(at, dict) else range(len(at))) else {}
        if isinstance(key, int):
            name = at.get("name") if isinstance(at, dict) else None
            words[-1] += f" {key + 1}" + (f" ({name})" if name else "")
        elif not key.startswith(("tuple", "[key]")):
            words.append(key)
            table = key if key in _TABLES else table
    where, text = ".".join(words), error["msg"].removeprefix("Value error, ")
    if error["type"] == "extra_forbidden":
        fields = _TABLES[table].model_fields if table else set(Scene.model_fields) - {"name"}
        return f"{where} is not known; valid here: {', '.join(sorted(fields))}"
    if isinstance(error["input"], str | int | float | bool) and error["type"] != "value_error":
        text += f" (found {error['input']!r})"
    return f"{where}: {text}" if where else text
