"""The room as data: walls, floor, things in it, lights, and where each robot starts.

Metres; x along the long side, y along the short side, the origin in the middle of the floor. The Go2 starts at
(-1.4, -0.2) looking along x: free are 4 m ahead, 2.8 m to its left and right and 2.2 m behind it. The G1 starts at
(1.2, 1.0) looking back along x, aside of the Go2's ways: `G1_FREE` is the rectangle in which nothing stands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agentrob.config import FenceConfig

LENGTH_M, WIDTH_M, HEIGHT_M = 8.0, 6.0, 2.4
WALL_M = 0.05  # half of a wall's thickness

ROOM_GROUP = 0  # what range sensors and cameras see
PLANKS_PX = 320
NEAR_WALL_GROUP = 1  # walls between the overview camera and the room: there, but not drawn for it

Rgba = tuple[float, float, float, float]
Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Start:
    """Where a robot stands when the world begins: metres and radians."""

    x_m: float
    y_m: float
    yaw_rad: float


GO2_START = Start(-1.4, -0.2, 0.0)
G1_START = Start(1.2, 1.0, math.pi)  # facing the Go2's side of the room: each sees the other from its start
#: Around the G1's start (x ahead of it, y to its left), where no thing is nearer than 0.35 m: a robot without range
#: sensors may walk there. The Go2 may come in.
G1_FREE = FenceConfig(x_min_m=-0.9, x_max_m=4.2, y_min_m=-0.7, y_max_m=2.7)


@dataclass(frozen=True, slots=True)
class Thing:
    """A fixed thing: `size_m` are half edges (box), (radius, half height) (cylinder) or (radius) (sphere)."""

    name: str
    shape: str
    at_m: Triple
    size_m: tuple[float, ...]
    rgba: Rgba
    solid: bool = True
    group: int = ROOM_GROUP


#: A box that waits below the floor until somebody puts it into the room; half edges.
BOX_SIZE_M: Triple = (0.20, 0.20, 0.30)
BOX_AWAY_M: Triple = (0.0, 0.0, -5.0)
BOX_RGBA: Rgba = (0.72, 0.55, 0.36, 1)

WALL_RGBA: Rgba = (0.95, 0.93, 0.88, 1)
WHITE: Rgba = (0.99, 0.99, 0.98, 1)
WOOD: Rgba = (0.60, 0.41, 0.25, 1)
DARK: Rgba = (0.24, 0.22, 0.21, 1)
GREEN: Rgba = (0.25, 0.52, 0.28, 1)
TEAL: Rgba = (0.28, 0.48, 0.52, 1)
SHADE: Rgba = (0.05, 0.03, 0.02, 0.28)
FLOOR_RGB = (0.74, 0.60, 0.44)
RED, BLUE, YELLOW = (0.86, 0.14, 0.11, 1), (0.13, 0.33, 0.82, 1), (0.97, 0.78, 0.12, 1)


def _walls() -> tuple[Thing, ...]:
    x, y, h = LENGTH_M / 2, WIDTH_M / 2, HEIGHT_M / 2
    t = WALL_M
    sides = (
        ("front", (x + t, 0.0), (t, y + 2 * t), ROOM_GROUP),
        ("left", (0.0, y + t), (x + 2 * t, t), ROOM_GROUP),
        ("back", (-x - t, 0.0), (t, y + 2 * t), NEAR_WALL_GROUP),
        ("right", (0.0, -y - t), (x + 2 * t, t), NEAR_WALL_GROUP),
    )
    walls = []
    for side, (wx, wy), (hx, hy), group in sides:
        walls.append(Thing(f"wall_{side}", "box", (wx, wy, h), (hx, hy, h), WALL_RGBA, group=group))
        inside = (wx - math.copysign(0.02, wx) if wx else 0.0, wy - math.copysign(0.02, wy) if wy else 0.0)
        walls.append(_decor(f"skirting_{side}", (*inside, 0.05), (hx, hy, 0.05), WHITE, group))
    ceiling = _decor("ceiling", (0.0, 0.0, HEIGHT_M + t), (x, y, t), WHITE, NEAR_WALL_GROUP)
    return (*walls, ceiling)


def _decor(name: str, at: Triple, size: tuple[float, ...], rgba: Rgba, group: int = ROOM_GROUP) -> Thing:
    return Thing(name, "box", at, size, rgba, solid=False, group=group)


def _table(x: float, y: float) -> tuple[Thing, ...]:
    corners = ((0.55, 0.3), (0.55, -0.3), (-0.55, 0.3), (-0.55, -0.3))
    legs = tuple(
        Thing(f"table_leg_{i}", "cylinder", (x + dx, y + dy, 0.34), (0.025, 0.34), DARK)
        for i, (dx, dy) in enumerate(corners)
    )
    return (Thing("table", "box", (x, y, 0.70), (0.62, 0.36, 0.02), WOOD), *legs)


def _sofa(x: float, y: float) -> tuple[Thing, ...]:
    """Against the left wall, its back to it."""
    return (
        Thing("sofa_seat", "box", (x, y, 0.21), (0.85, 0.36, 0.21), TEAL),
        Thing("sofa_back", "box", (x, y + 0.32, 0.40), (0.85, 0.10, 0.40), TEAL),
        Thing("sofa_arm_0", "box", (x - 0.90, y, 0.29), (0.09, 0.40, 0.29), TEAL),
        Thing("sofa_arm_1", "box", (x + 0.90, y, 0.29), (0.09, 0.40, 0.29), TEAL),
        _decor("cushion", (x - 0.45, y + 0.12, 0.55), (0.20, 0.08, 0.17), YELLOW),
    )


def _plant(x: float, y: float) -> tuple[Thing, ...]:
    leaves = ((0.0, 0.0, 0.95, 0.26), (0.14, 0.08, 0.74, 0.20), (-0.13, -0.10, 0.78, 0.19), (0.05, -0.15, 0.68, 0.17))
    return (
        Thing("plant_pot", "cylinder", (x, y, 0.20), (0.17, 0.20), (0.80, 0.45, 0.30, 1)),
        Thing("plant_stem", "cylinder", (x, y, 0.55), (0.03, 0.20), (0.36, 0.27, 0.16, 1), solid=False),
        *(
            Thing(f"plant_leaf_{i}", "sphere", (x + dx, y + dy, z), (r,), (0.22 + 0.05 * i, 0.50, 0.26, 1), solid=False)
            for i, (dx, dy, z, r) in enumerate(leaves)
        ),
    )


def _shelf(x: float, y: float) -> tuple[Thing, ...]:
    """Against the left wall."""
    books = tuple(
        _decor(f"book_{i}", (x - 0.40 + 0.07 * i, y, 1.02), (0.028, 0.10, 0.13 + 0.015 * (i % 3)), colour)
        for i, colour in enumerate((RED, TEAL, YELLOW, BLUE, GREEN, DARK, RED, BLUE, YELLOW))
    )
    return (Thing("shelf", "box", (x, y, 0.44), (0.50, 0.18, 0.44), WOOD), *books)


def _window(x: float, at_y: float) -> tuple[Thing, ...]:
    """In the left wall."""
    panes = tuple(
        _decor(f"pane_{i}", (x + dx, at_y - 0.012, 1.50), (0.44, 0.01, 0.48), (0.72, 0.87, 0.97, 1))
        for i, dx in enumerate((-0.48, 0.48))
    )
    sill = _decor("window_sill", (x, at_y - 0.06, 0.95), (1.06, 0.08, 0.025), WHITE)
    return (_decor("window_frame", (x, at_y, 1.50), (1.00, 0.01, 0.56), WHITE), *panes, sill)


def _poster(at_x: float, y: float) -> tuple[Thing, ...]:
    """On the front wall: a sun over hills, in a dark frame."""
    disc = Thing("poster_sun", "sphere", (at_x + 0.10, y + 0.18, 1.62), (0.17,), YELLOW, solid=False)
    return (
        _decor("poster_frame", (at_x, y, 1.45), (0.012, 0.62, 0.46), DARK),
        _decor("poster_paper", (at_x - 0.01, y, 1.45), (0.012, 0.58, 0.42), (0.96, 0.70, 0.52, 1)),
        _decor("poster_hill", (at_x - 0.02, y, 1.16), (0.012, 0.58, 0.13), TEAL),
        disc,
    )


def _shades(things: tuple[Thing, ...]) -> tuple[Thing, ...]:
    """A dark, see-through disc on the floor under what stands on it: real shadows cost three times as much."""
    return tuple(
        Thing(
            f"shade_{t.name}", "cylinder", (t.at_m[0] + 0.03, t.at_m[1] + 0.03, 0.004), (r, 0.002), SHADE, solid=False
        )
        for t, r in zip(things, (0.15, 0.36, 0.22, 0.15), strict=False)
    )


TOYS: tuple[Thing, ...] = (
    Thing("red_ball", "sphere", (2.7, 0.75, 0.15), (0.15,), RED),
    Thing("blue_box", "box", (3.2, -1.2, 0.25), (0.25, 0.25, 0.25), BLUE),
    Thing("green_column", "cylinder", (3.5, 1.5, 0.4), (0.16, 0.4), (0.13, 0.60, 0.29, 1)),
    Thing("yellow_post", "cylinder", (2.6, 2.5, 0.3), (0.10, 0.3), YELLOW),
)
THINGS: tuple[Thing, ...] = (
    *_walls(),
    *TOYS,
    *_shades(TOYS),
    *_table(1.2, -2.5),
    *_sofa(0.9, 2.5),
    *_plant(3.65, 2.6),
    *_shelf(-3.3, 2.8),
    *_window(-1.6, WIDTH_M / 2),
    *_poster(LENGTH_M / 2, 0.4),
    _decor("rug", (0.2, 0.0, 0.002), (1.5, 1.0, 0.003), (0.62, 0.33, 0.29, 1)),
    _decor("rug_inside", (0.2, 0.0, 0.004), (1.35, 0.85, 0.004), (0.83, 0.72, 0.60, 1)),
    _decor("picture", (-LENGTH_M / 2, 0.3, 1.25), (0.012, 0.50, 0.36), BLUE, NEAR_WALL_GROUP),
    _decor("picture_inside", (-LENGTH_M / 2 + 0.01, 0.3, 1.25), (0.012, 0.42, 0.28), YELLOW, NEAR_WALL_GROUP),
    _decor("door", (-1.0, -WIDTH_M / 2, 1.0), (0.45, 0.02, 1.0), WOOD, NEAR_WALL_GROUP),
)

OVERVIEW_AT_M, OVERVIEW_TO_M = (-5.3, -5.0, 3.9), (0.15, 0.15, 0.15)
OVERVIEW_FOVY_DEG = 39.0


#: Direction and strength: one on the floor and both far walls, one on the near walls, one on the ceiling.
LIGHTS: tuple[tuple[Triple, float], ...] = (
    ((0.45, 0.60, -0.85), 0.55),
    ((-0.55, -0.45, -0.30), 0.32),
    ((0.05, 0.05, 1.0), 0.48),
)


def furnish(spec: Any, things: tuple[Thing, ...] = THINGS) -> None:
    """Put the room into a `mujoco.MjSpec`."""
    import mujoco

    shapes = {
        "box": mujoco.mjtGeom.mjGEOM_BOX,
        "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
        "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    }
    _floor(spec)
    for thing in things:
        size = [*thing.size_m, 0, 0][:3]
        contact = 1 if thing.solid else 0
        spec.worldbody.add_geom(
            name=thing.name,
            type=shapes[thing.shape],
            pos=thing.at_m,
            size=size,
            rgba=thing.rgba,
            group=thing.group,
            contype=contact,
            conaffinity=contact,
        )
    _lights(spec)
    _overview(spec)


def _overview(spec: Any) -> None:
    at, to = np.array(OVERVIEW_AT_M), np.array(OVERVIEW_TO_M)
    back = (at - to) / np.linalg.norm(at - to)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    axes = [*right, *np.cross(back, right)]
    spec.worldbody.add_camera(name="overview", pos=OVERVIEW_AT_M, xyaxes=axes, fovy=OVERVIEW_FOVY_DEG)


def _floor(spec: Any) -> None:
    import mujoco

    texture, builtin = mujoco.mjtTexture, mujoco.mjtBuiltin
    spec.add_texture(
        name="sky",
        type=texture.mjTEXTURE_SKYBOX,
        builtin=builtin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.94, 0.95],
        rgb2=[0.80, 0.83, 0.87],
        width=64,
        height=384,
    )
    spec.add_texture(
        name="floor",
        type=texture.mjTEXTURE_2D,
        width=PLANKS_PX,
        height=PLANKS_PX,
        nchannel=3,
        data=_planks().ravel().tolist(),
    )
    material = spec.add_material(name="floor", texrepeat=[0.5, 0.5], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[LENGTH_M / 2 + 0.1, WIDTH_M / 2 + 0.1, 0.05],
        material="floor",
    )


def _planks() -> NDArray[np.uint8]:
    """A wooden floor of 2 by 2 m: (n, n, 3), planks of one row's height, joints shifted from row to row."""
    rng = np.random.default_rng(3)
    n, rows = PLANKS_PX, 10
    picture = np.empty((n, n, 3))
    for strip in np.array_split(np.arange(n), rows):
        shift = int(rng.integers(n))
        for half in range(2):
            columns = (np.arange(n // 2) + half * n // 2 + shift) % n
            tone = 1 + rng.uniform(-0.07, 0.07)
            picture[np.ix_(strip, columns)] = np.array(FLOOR_RGB) * tone
            picture[strip, columns[0]] *= 0.72
        grain = rng.normal(1, 0.012, len(strip))
        picture[strip] *= grain[:, None, None]
        picture[strip[0]] *= 0.72
    return np.asarray(np.clip(picture * 255, 0, 255).astype(np.uint8))


def _lights(spec: Any) -> None:
    import mujoco

    headlight = spec.visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [0.42] * 3, [0.12] * 3, [0.0] * 3
    for direction, strength in LIGHTS:
        spec.worldbody.add_light(
            pos=[0, 0, 5],
            dir=list(direction),
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            castshadow=False,
            diffuse=[strength, strength * 0.98, strength * 0.95],
            specular=[0.15] * 3,
        )
