"""Cheap visual meshes: the packaged meshes with near vertices merged, in memory.

On a machine without a GPU the time of a picture is the number of triangles: merging vertices within 8 mm leaves a
tenth of them, and a picture takes a quarter of the time.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vertices = NDArray[np.float64]  # (n, 3) metres
Faces = NDArray[np.int64]  # (m, 3) indices of vertices

CELL_M = 0.008  # edge of the cube whose vertices become one
KEEP_FACES = 2500  # meshes up to this size stay as they are


def read_obj(path: Path) -> tuple[Vertices, Faces]:
    """Vertices and triangles of a Wavefront OBJ file; polygons become fans."""
    data = b"\n" + path.read_bytes()
    positions = _lines(data, b"\nv ").replace(b"\nv ", b" ")
    vertices = np.fromstring(positions, dtype=np.float64, sep=" ").reshape(-1, 3)
    return vertices, _triangles(_lines(data, b"\nf ")) - 1


def _lines(data: bytes, start: bytes) -> bytes:
    """The lines that begin with `start`, a line break and a keyword; without copying each where they stand together."""
    first, last = data.find(start), data.rfind(start)
    if first < 0:
        return b""
    end = data.find(b"\n", last + 1)
    together = data[first : end if end >= 0 else len(data)]
    if together.count(b"\n") == together.count(start):
        return together
    return b"".join(b"\n" + line for line in together.split(b"\n") if line.startswith(start[1:]))


def _triangles(lines: bytes) -> Faces:
    """Indices, counted from 1, of faces given as lines of `f a/b/c d/e/f …`, of which a, d, … are the vertices."""
    count = lines.count(b"\n")
    if lines.translate(None, b"0123456789\r") == b"\nf // // //" * count:
        numbers = np.fromstring(lines.replace(b"\nf ", b" ").replace(b"/", b" "), dtype=np.int64, sep=" ")
        if len(numbers) == 9 * count:  # triangles with texture and normal, as the packaged meshes are
            return np.ascontiguousarray(numbers.reshape(-1, 9)[:, ::3])
    faces = []
    for line in lines.split(b"\nf ")[1:]:
        ring = [int(corner.split(b"/", 1)[0]) for corner in line.split()]
        faces += [(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)]
    return np.array(faces, dtype=np.int64).reshape(-1, 3)


def read_stl(path: Path) -> tuple[Vertices, Faces]:
    """Vertices and triangles of a binary STL file; each triangle has vertices of its own."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    triangle = np.dtype([("normal", "<3f4"), ("corners", "<9f4"), ("attribute", "<u2")])
    corners = np.frombuffer(data, triangle, count, 84)["corners"]
    return corners.reshape(-1, 3).astype(np.float64), np.arange(3 * count).reshape(-1, 3)


READERS = {".obj": read_obj, ".stl": read_stl}


def merge_vertices(vertices: Vertices, faces: Faces, cell_m: float = CELL_M) -> tuple[Vertices, Faces]:
    """Replace all vertices in one cell of a grid by their mean; faces that collapse or repeat are dropped."""
    cells = np.floor(vertices / cell_m).astype(np.int64)
    _, group, count = np.unique(_one_number(cells - cells.min(axis=0)), return_inverse=True, return_counts=True)
    merged = np.stack([np.bincount(group, vertices[:, axis]) for axis in range(3)], axis=1) / count[:, None]
    moved = group[faces]
    distinct = (moved[:, 0] != moved[:, 1]) & (moved[:, 1] != moved[:, 2]) & (moved[:, 0] != moved[:, 2])
    moved = moved[distinct]
    _, first = np.unique(_one_number(np.sort(moved, axis=1)), return_index=True)
    return merged, moved[np.sort(first)]


def _one_number(rows: Faces) -> NDArray[np.int64]:
    """Each row of three numbers from 0 as one number, in the same order: sorting rows takes five times longer."""
    if not len(rows):
        return np.zeros(0, dtype=np.int64)
    sizes = rows.max(axis=0) + 1
    numbers: NDArray[np.int64] = np.ravel_multi_index(tuple(rows.T), tuple(int(size) for size in sizes))
    return numbers


def simplify(spec: Any, folder: Path) -> None:
    """Replace every large OBJ or STL mesh of a `mujoco.MjSpec` by its merged version."""
    import mujoco

    for mesh in spec.meshes:
        read = READERS.get(Path(mesh.file).suffix.lower())
        if read is None:
            continue
        vertices, faces = read(folder / mesh.file)
        if len(faces) <= KEEP_FACES:
            continue
        vertices, faces = merge_vertices(vertices, faces)
        mesh.name = mesh.name or Path(mesh.file).stem
        mesh.file = ""
        mesh.uservert, mesh.userface = vertices.ravel().tolist(), faces.ravel().tolist()
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # merged surfaces are not watertight
