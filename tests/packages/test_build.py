"""The files of agentrob-world, agentrob-unitree-sdk and the SO-101's model: how they are built, and that they are as
built."""

from __future__ import annotations

import hashlib
import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

PACKAGES = Path(__file__).parents[2] / "packages"
_spec = importlib.util.spec_from_file_location("packages_build", PACKAGES / "build.py")
assert _spec is not None
assert _spec.loader is not None
build = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(build)


@given(
    vertices=hnp.arrays(np.float64, (12, 3), elements=st.floats(-0.05, 0.05)),
    faces=hnp.arrays(np.int64, (20, 3), elements=st.integers(0, 11)),
)
def test_merged_meshes_have_valid_distinct_faces_and_move_no_vertex_far(vertices, faces):
    merged, kept = build.merge_vertices(vertices, faces, cell_m=0.02)
    assert len(merged) <= len(vertices)
    assert len(kept) <= len(faces)
    assert ((kept >= 0) & (kept < len(merged))).all()
    assert all(len(set(face)) == 3 for face in kept.tolist())
    for vertex in vertices:
        assert np.linalg.norm(merged - vertex, axis=1).min() <= 0.02 * np.sqrt(3) + 1e-9


def test_obj_polygons_become_triangles():
    square = "# a square\nv 0 0 0\nv 1 0 0\nvt 0 0\nv 1 1 0\nv 0 1 0\nusemtl x\nf 1/1/1 2//2 3/3/3 4\n"
    vertices, faces = build.read_obj(square.encode())
    assert vertices.shape == (4, 3)
    assert faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    again = build.read_obj(build.obj_text(vertices, faces).encode())
    assert np.array_equal(again[0], vertices)
    assert np.array_equal(again[1], faces)


def test_equal_corners_of_a_binary_stl_are_one_vertex():
    corner = np.dtype([("normal", "<3f4"), ("corners", "<9f4"), ("attribute", "<u2")])
    triangles = np.zeros(2, corner)
    triangles["corners"] = [[0, 0, 0, 1, 0, 0, 0, 1, 0], [1, 0, 0, 1, 1, 0, 0, 1, 0]]
    vertices, faces = build.read_stl(bytes(80) + (2).to_bytes(4, "little") + triangles.tobytes())
    assert vertices.shape == (4, 3)
    assert vertices[faces].reshape(2, 9).tolist() == triangles["corners"].tolist()


@pytest.mark.parametrize(
    ("folder", "least"),
    [(PACKAGES / "world/src/agentrob_world", 50), (PACKAGES.parent / "plugins/so101/src/agentrob_so101/model", 15)],
    ids=["world", "so101"],
)
def test_the_files_of_a_model_have_the_checksums_that_it_lists(folder, least):
    lines = (folder / "SHA256SUMS").read_text().splitlines()
    assert len(lines) > least
    for line in lines:
        expected, name = line.split("  ")
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == expected, name


@pytest.mark.slow
def test_the_files_are_built_byte_for_byte_from_their_sources():
    built = subprocess.run(
        [sys.executable, PACKAGES / "build.py", "--check"], capture_output=True, text=True, check=False
    )
    assert built.returncode == 0, built.stdout + built.stderr
