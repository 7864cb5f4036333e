"""The shape of a robot and its room for viewers in 3D, read from the compiled model at run time.

One file: the length of the head (uint32, little endian), the head as JSON, then the meshes. A mesh has 16-bit
vertices, scaled to its bounding box, and triangles of 16- or 32-bit indices. Viewers compute where the bodies are from
the pose of the base and the joint angles, as the robot reports them: the simulation's own state is not needed.
"""

from __future__ import annotations

import gzip
import json
import struct
from typing import Any

import numpy as np

from agentrob.sim.world.legged import Legged
from agentrob.sim.world.room import ROOM_GROUP
from agentrob.sim.world.scene import Scene, rgba
from agentrob.sim.world.world import ROBOT_GROUP

VERSION = 1


def geometry(model: Any, robot: Legged, scene: Scene | None = None) -> bytes:
    """The gzipped geometry of one robot of a compiled `MjModel`, and of the room around it if there is a scene."""
    bodies = [b for b in range(model.nbody) if model.body_rootid[b] == robot.body]
    place = {body: index for index, body in enumerate(bodies)}
    meshes = _Meshes(model)
    head = {
        "version": VERSION,
        "bodies": [_body(model, body, place, robot) for body in bodies],
        "geoms": [_geom(model, g, place, meshes) for g in range(model.ngeom) if _drawn(model, g, place, ROBOT_GROUP)],
        "room": [
            _geom(model, g, {0: 0}, meshes)
            for g in range(model.ngeom)
            if scene is not None and _drawn(model, g, {0: 0}, ROOM_GROUP)
        ],
        "floor": [] if scene is None else list(rgba(scene.room.floor_colour)[:3]),
        "meshes": meshes.heads,
    }
    text = json.dumps(head, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return gzip.compress(struct.pack("<I", len(text)) + text + bytes(meshes.blob), mtime=0)


class _Meshes:
    """The meshes of the geoms that are drawn, each once."""

    def __init__(self, model: Any) -> None:
        self._model = model
        self._known: dict[int, int] = {}
        self.heads: list[dict[str, Any]] = []
        self.blob = bytearray()

    def index(self, mesh: int) -> int:
        if mesh not in self._known:
            self._known[mesh] = len(self.heads)
            self._add(mesh)
        return self._known[mesh]

    def _add(self, mesh: int) -> None:
        m = self._model
        first, count = int(m.mesh_vertadr[mesh]), int(m.mesh_vertnum[mesh])
        vertices = m.mesh_vert[first : first + count]
        first, faces = int(m.mesh_faceadr[mesh]), int(m.mesh_facenum[mesh])
        indices = m.mesh_face[first : first + faces].astype("<u2" if count < 2**16 else "<u4")
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        scaled = np.round((vertices - low) / np.maximum(high - low, 1e-9) * 65535).astype("<u2")
        head = {"at": len(self.blob), "vertices": count, "faces": faces, "bytes": indices.itemsize}
        self.heads.append(head | {"low": _r(low, 5), "high": _r(high, 5)})
        for part in (scaled.tobytes(), indices.tobytes()):
            self.blob += part + b"\0" * (-len(part) % 4)


def _body(model: Any, body: int, place: dict[int, int], robot: Legged) -> dict[str, Any]:
    """A body in the frame of its parent (-1: the room), and the joint that turns it: the number of its motor."""
    data: dict[str, Any] = {"parent": place.get(int(model.body_parentid[body]), -1)}
    data |= {"at": _r(model.body_pos[body]), "turned": _r(model.body_quat[body])}
    first = int(model.body_jntadr[body])
    name = model.joint(first).name.removeprefix(f"{robot.name}/") if first >= 0 else ""
    if name in robot.build.joints:
        axis, pivot = _r(model.jnt_axis[first]), _r(model.jnt_pos[first])
        data["joint"] = {"motor": robot.build.joints.index(name), "axis": axis, "pivot": pivot}
    return data


def _drawn(model: Any, geom: int, place: dict[int, int], group: int) -> bool:
    return int(model.geom_bodyid[geom]) in place and model.geom_group[geom] == group and model.geom_rgba[geom, 3] > 0


def _geom(model: Any, geom: int, place: dict[int, int], meshes: _Meshes) -> dict[str, Any]:
    """A mesh, or a primitive: `kind` as in `mjtGeom`, `size` as in `geom_size`."""
    import mujoco

    material = int(model.geom_matid[geom])
    colour = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
    data = {"body": place[int(model.geom_bodyid[geom])], "at": _r(model.geom_pos[geom])}
    data |= {"turned": _r(model.geom_quat[geom]), "colour": _r(colour, 2)}
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        return data | {"mesh": meshes.index(int(model.geom_dataid[geom]))}
    return data | {"kind": int(model.geom_type[geom]), "size": _r(model.geom_size[geom])}


def _r(values: Any, digits: int = 4) -> list[float]:
    return [round(float(value), digits) for value in values]
