"""Shapes of robots for the 3D view: gzipped files beside the pictures, named by their content."""

from __future__ import annotations

import hashlib
import os
import re
import zlib
from pathlib import Path

from agentrob.errors import BoardError

#: The largest shape, compressed and not; those of the simulated robots have 0.3 and 0.5 MB.
MOST_BYTES, MOST_UNPACKED = 4 * 2**20, 16 * 2**20
#: The newest are kept: a robot has one, and a new one when its model changes.
MOST_FILES = 60


def store(images_dir: Path, data: bytes) -> str:
    """Store a gzipped geometry; return its name. 413 if it is too large, 422 if it is not gzip."""
    hint = f"gzip, at most {MOST_BYTES} bytes, which unpack to at most {MOST_UNPACKED}"
    if len(data) > MOST_BYTES:
        raise BoardError(413, "geometry_too_large", f"the geometry has {len(data)} bytes", hint)
    try:
        reading = zlib.decompressobj(zlib.MAX_WBITS | 16)
        reading.decompress(data, MOST_UNPACKED)
        whole = reading.eof and not reading.unconsumed_tail
    except zlib.error:
        whole = False
    if not whole:
        raise BoardError(422, "bad_geometry", "that is not a geometry", hint)
    name, folder = hashlib.sha256(data).hexdigest()[:32], _folder(images_dir)
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / name).exists():
        part = folder / f"{name}.{os.getpid()}.part"
        part.write_bytes(data)
        part.replace(folder / name)
        _prune(folder)
    return name


def read(images_dir: Path, name: str) -> bytes | None:
    """A stored geometry, None if there is none of this name."""
    if not re.fullmatch(r"[0-9a-f]{32}", name):
        return None
    try:
        return (_folder(images_dir) / name).read_bytes()
    except OSError:
        return None


def _folder(images_dir: Path) -> Path:
    return images_dir / "geometry"


def _prune(folder: Path) -> None:
    files = sorted(folder.iterdir(), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in files[MOST_FILES:]:
        path.unlink(missing_ok=True)
