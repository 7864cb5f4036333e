"""The room as data: walls, floor, things in it, lights, and where each robot starts.

Metres; x along the long side, y along the short side, the origin in the middle of the floor. The Go2 starts at
(-1.4, -0.2) looking along x: free are 4 m ahead, 2.8 m to its left and right and 2.2 m behind it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

LENGTH_M, WIDTH_M, HEIGHT_M = 8.0, 6.0, 2.4
WALL_M = 0.05  # half of a wall's thickness

ROOM_GROUP = 0  # what range sensors and cameras see
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


WALL_RGBA: Rgba = (0.90, 0.88, 0.83, 1)
SKIRTING_RGBA: Rgba = (0.97, 0.96, 0.94, 1)
WOOD: Rgba = (0.52, 0.36, 0.22, 1)
LEG: Rgba = (0.25, 0.22, 0.20, 1)


def _walls() -> tuple[Thing, ...]:
    x, y, h = LENGTH_M / 2 + WALL_M, WIDTH_M / 2 + WALL_M, HEIGHT_M / 2
    sides = (
        ("wall_front", (x, 0.0, h), (WALL_M, y, h), ROOM_GROUP),
        ("wall_left", (0.0, y, h), (x, WALL_M, h), ROOM_GROUP),
        ("wall_back", (-x, 0.0, h), (WALL_M, y, h), NEAR_WALL_GROUP),
        ("wall_right", (0.0, -y, h), (x, WALL_M, h), NEAR_WALL_GROUP),
    )
    walls = [Thing(name, "box", at, size, WALL_RGBA, group=group) for name, at, size, group in sides]
    for name, at, size, group in sides:
        inward = tuple(c * (1 - 0.06 / abs(c)) if c and i < 2 else 0.05 for i, c in enumerate(at))
        low = (size[0], size[1], 0.05)
        walls.append(Thing("skirting_" + name, "box", (inward[0], inward[1], 0.05), low, SKIRTING_RGBA, False, group))
    return tuple(walls)


def _table(x: float, y: float) -> tuple[Thing, ...]:
    legs = tuple(
        Thing(f"table_leg_{i}", "cylinder", (x + dx, y + dy, 0.34), (0.025, 0.34), LEG)
        for i, (dx, dy) in enumerate(((0.55, 0.3), (0.55, -0.3), (-0.55, 0.3), (-0.55, -0.3)))
    )
    return (Thing("table", "box", (x, y, 0.70), (0.62, 0.36, 0.02), WOOD), *legs)


THINGS: tuple[Thing, ...] = (
    *_walls(),
    Thing("red_ball", "sphere", (2.7, 0.75, 0.15), (0.15,), (0.86, 0.12, 0.10, 1)),
    Thing("blue_box", "box", (3.2, -1.2, 0.25), (0.25, 0.25, 0.25), (0.12, 0.30, 0.80, 1)),
    Thing("green_column", "cylinder", (3.4, 2.0, 0.4), (0.16, 0.4), (0.12, 0.60, 0.28, 1)),
    Thing("yellow_post", "cylinder", (1.9, 2.6, 0.3), (0.10, 0.3), (0.95, 0.78, 0.10, 1)),
    *_table(0.9, -2.5),
    Thing("shelf", "box", (-3.7, 1.9, 0.8), (0.2, 0.6, 0.8), (0.60, 0.62, 0.66, 1)),
)

FLOOR_RGB = (0.72, 0.60, 0.45)
OVERVIEW_AT_M, OVERVIEW_TO_M = (-5.6, -5.2, 4.0), (0.0, 0.1, 0.2)
OVERVIEW_FOVY_DEG = 40.0


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
        rgb1=[0.80, 0.86, 0.93],
        rgb2=[0.52, 0.60, 0.70],
        width=64,
        height=384,
    )
    spec.add_texture(
        name="floor",
        type=texture.mjTEXTURE_2D,
        builtin=builtin.mjBUILTIN_CHECKER,
        rgb1=[0.74, 0.62, 0.47],
        rgb2=[0.69, 0.57, 0.43],
        width=128,
        height=128,
    )
    material = spec.add_material(name="floor", texrepeat=[2, 2], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[LENGTH_M / 2 + 0.1, WIDTH_M / 2 + 0.1, 0.05],
        material="floor",
    )


def _lights(spec: Any) -> None:
    import mujoco

    headlight = spec.visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [0.35] * 3, [0.25] * 3, [0.05] * 3
    for direction, strength in (((0.35, 0.25, -1.0), 0.38), ((-0.6, -0.5, -0.35), 0.14)):
        spec.worldbody.add_light(
            pos=[0, 0, 5],
            dir=list(direction),
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            castshadow=False,
            diffuse=[strength] * 3,
            specular=[0.1] * 3,
        )
