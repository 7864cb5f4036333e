"""Adds a scene to the MuJoCo model: floor, walls, things, lights, the room's camera, and the box that faults use."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agentrob.sim.world.scene import Camera, PlacedBody, Rgba, Room, Scene, Triple, rgba

ROOM_GROUP = 0  # what range sensors and cameras see
NEAR_WALL_GROUP = 1  # what is between the overview camera and the room: there, but not drawn for it
WALL_M = 0.05  # half of a wall's thickness
PATTERN_PX = 320
OPEN_FLOOR_M = 25.0  # half an edge of what is drawn of a floor without walls

#: A box that waits far below the floor, beyond what any camera draws, until somebody puts it into the room; half edges.
BOX_SIZE_M: Triple = (0.20, 0.20, 0.30)
BOX_AWAY_M: Triple = (0.0, 0.0, -500.0)
BOX_RGBA: Rgba = (0.72, 0.55, 0.36, 1)

WHITE = "#fcfcfa"
SHADE: Rgba = (0.05, 0.03, 0.02, 0.28)
#: What stands on the floor, is about as long as wide, and neither thinner nor wider than this gets a shade.
SHADED_M = (0.08, 0.40)


def furnish(spec: Any, scene: Scene) -> None:
    """Put the room into a `mujoco.MjSpec`."""
    import mujoco

    shapes = {
        "box": mujoco.mjtGeom.mjGEOM_BOX,
        "ball": mujoco.mjtGeom.mjGEOM_SPHERE,
        "column": mujoco.mjtGeom.mjGEOM_CYLINDER,
    }
    _floor(spec, scene.room)
    for body in (*_walls(scene.room), *scene.bodies()):
        contact = 1 if body.solid else 0
        spec.worldbody.add_geom(
            name=body.name,
            type=shapes[body.shape],
            pos=body.at_m,
            quat=[math.cos(body.yaw_rad / 2), 0, 0, math.sin(body.yaw_rad / 2)],
            size=[*body.size_m, 0, 0][:3],
            rgba=rgba(body.colour),
            group=ROOM_GROUP if body.in_overview else NEAR_WALL_GROUP,
            contype=contact,
            conaffinity=contact,
        )
        _shade(spec, body)
    _lights(spec, scene)
    _overview(spec, scene.camera or _camera(scene.room))
    _box(spec)


def _walls(room: Room) -> tuple[PlacedBody, ...]:
    """Four walls with skirtings, and a ceiling; none when they have no height."""
    x, y, h, t = room.size_m[0] / 2, room.size_m[1] / 2, room.height_m / 2, WALL_M
    if not h:
        return ()
    sides = (
        ("front", (x + t, 0.0), (t, y + 2 * t), True),
        ("left", (0.0, y + t), (x + 2 * t, t), True),
        ("back", (-x - t, 0.0), (t, y + 2 * t), False),
        ("right", (0.0, -y - t), (x + 2 * t, t), False),
    )
    walls = []
    for side, (wx, wy), (hx, hy), far in sides:
        walls.append(PlacedBody(f"wall_{side}", "box", (wx, wy, h), 0.0, (hx, hy, h), room.walls, True, far))
        inside = (wx - math.copysign(0.02, wx) if wx else 0.0, wy - math.copysign(0.02, wy) if wy else 0.0)
        skirting = PlacedBody(f"skirting/{side}", "box", (*inside, 0.05), 0.0, (hx, hy, 0.05), WHITE, False, far)
        walls.append(skirting)
    ceiling = PlacedBody("room/ceiling", "box", (0.0, 0.0, 2 * h + t), 0.0, (x, y, t), WHITE, False, False)
    return (*walls, ceiling)


def _shade(spec: Any, body: PlacedBody) -> None:
    """A dark, see-through disc on the floor under what stands on it: real shadows cost three times as much."""
    import mujoco

    edges_m = body.size_m[:2] if body.shape == "box" else body.size_m[:1]
    wide_m, round_ = max(edges_m), max(edges_m) < 1.6 * min(edges_m)
    on_floor = body.solid and abs(body.at_m[2] - body.size_m[-1]) < 0.01
    if not (on_floor and round_ and SHADED_M[0] <= wide_m <= SHADED_M[1]):
        return
    spec.worldbody.add_geom(
        name=f"shade/{body.name}",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[body.at_m[0] + 0.03, body.at_m[1] + 0.03, 0.004],
        size=[wide_m if body.shape == "ball" else 1.4 * wide_m, 0.002, 0],
        rgba=SHADE,
        group=ROOM_GROUP if body.in_overview else NEAR_WALL_GROUP,
        contype=0,
        conaffinity=0,
    )


def _box(spec: Any) -> None:
    import mujoco

    box = spec.worldbody.add_body(name="box_body", mocap=True, pos=BOX_AWAY_M)
    box.add_geom(name="box", type=mujoco.mjtGeom.mjGEOM_BOX, size=BOX_SIZE_M, rgba=BOX_RGBA, group=ROOM_GROUP)


def _camera(room: Room) -> Camera:
    """From above the corner of the two walls that are not drawn, far enough to see the whole floor."""
    length_m, width_m = room.size_m if room.height_m else (8.0, 6.0)
    away_m = 0.55 * math.hypot(length_m, width_m)
    return Camera(at_m=(-0.12 * length_m - 0.8 * away_m, -0.35 * width_m - 0.6 * away_m, 0.75 * away_m))


def _overview(spec: Any, camera: Camera) -> None:
    at, to = np.array(camera.at_m), np.array(camera.to_m)
    back = (at - to) / np.linalg.norm(at - to)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    axes = [*right, *np.cross(back, right)]
    spec.worldbody.add_camera(name="overview", pos=camera.at_m, xyaxes=axes, fovy=camera.fovy_deg)


def _floor(spec: Any, room: Room) -> None:
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
    patterns = {"planks": _planks, "tiles": _tiles, "plain": _plain}
    colour = np.array(rgba(room.floor_colour)[:3])
    picture = np.clip(patterns[room.floor](colour) * 255, 0, 255).astype(np.uint8)
    spec.add_texture(
        name="floor",
        type=texture.mjTEXTURE_2D,
        width=PATTERN_PX,
        height=PATTERN_PX,
        nchannel=3,
        data=picture.ravel().tolist(),
    )
    material = spec.add_material(name="floor", texrepeat=[0.5, 0.5], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    half = [edge / 2 + 0.1 for edge in room.size_m] if room.height_m else [OPEN_FLOOR_M, OPEN_FLOOR_M]
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[*half, 0.05], material="floor")


def _planks(colour: NDArray[np.float64]) -> NDArray[np.float64]:
    """A wooden floor of 2 by 2 m: (n, n, 3), planks of one row's height, joints shifted from row to row."""
    rng = np.random.default_rng(3)
    n, rows = PATTERN_PX, 10
    picture = np.empty((n, n, 3))
    for strip in np.array_split(np.arange(n), rows):
        shift = int(rng.integers(n))
        for half in range(2):
            columns = (np.arange(n // 2) + half * n // 2 + shift) % n
            tone = 1 + rng.uniform(-0.07, 0.07)
            picture[np.ix_(strip, columns)] = colour * tone
            picture[strip, columns[0]] *= 0.72
        grain = rng.normal(1, 0.012, len(strip))
        picture[strip] *= grain[:, None, None]
        picture[strip[0]] *= 0.72
    return picture


def _tiles(colour: NDArray[np.float64]) -> NDArray[np.float64]:
    """Four by four tiles on 2 by 2 m, each of a tone of its own, with dark joints."""
    rng = np.random.default_rng(5)
    edge = PATTERN_PX // 4
    tones = np.kron(1 + rng.uniform(-0.03, 0.03, (4, 4)), np.ones((edge, edge)))
    at = np.arange(PATTERN_PX) % edge < 2
    tones[at] *= 0.82
    tones[:, at] *= 0.82
    return np.asarray(tones[:, :, None] * colour)


def _plain(colour: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.broadcast_to(colour, (PATTERN_PX, PATTERN_PX, 3))


def _lights(spec: Any, scene: Scene) -> None:
    import mujoco

    headlight = spec.visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [0.42] * 3, [0.12] * 3, [0.0] * 3
    for light in scene.light:
        strength = light.strength
        spec.worldbody.add_light(
            pos=[0, 0, 5],
            dir=list(light.direction),
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            castshadow=False,
            diffuse=[strength, strength * 0.98, strength * 0.95],
            specular=[0.15] * 3,
        )
