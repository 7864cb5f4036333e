"""Pictures that are uploaded: checked by decoding them, kept as files named by their hash."""

from __future__ import annotations

import hashlib
import io
import os
import tempfile
import warnings
from pathlib import Path

from PIL import Image as Pillow
from PIL import ImageOps

from agentrob.board.records import Image
from agentrob.errors import BoardError

MAX_BYTES = 8 * 1024 * 1024
MAX_PIXELS = 25_000_000
MAX_FRAME_BYTES = 2 * 1024 * 1024
_TYPES = {"JPEG": "image/jpeg", "PNG": "image/png"}


def check(data: bytes) -> tuple[Image, bytes]:
    """The picture (without id) and its bytes without what a camera wrote into them (place, owner).

    Decodes all of it, so not on the event loop. 413 when too large, 415 for what is no JPEG or PNG.
    """
    if len(data) > MAX_BYTES:
        raise BoardError(413, "image_too_large", f"the image has {len(data)} bytes", f"at most {MAX_BYTES} bytes")
    try:
        with _open(data) as picture:
            picture.load()
            width, height = picture.size
            # A JPEG with more pictures behind the first one (phones make them) becomes a plain JPEG of the first.
            several = picture.format == "MPO"
            kind = "JPEG" if several else str(picture.format)
            if several or any(picture.info.get(k) for k in ("exif", "xmp", "comment", "photoshop")):
                data, (width, height) = _without_metadata(picture, kind)
    except BoardError:
        raise
    except Exception as e:  # Pillow raises nearly everything for broken files
        raise BoardError(415, "bad_image", "that is not a picture that can be read", "a JPEG or PNG file") from e
    return Image("", width, height, _TYPES[kind]), data


def check_frame(data: bytes) -> None:
    """Look at the head of a live picture only: it comes ten times a second and from the robot's own agent."""
    try:
        with _open(data, formats=("JPEG",)):
            return
    except BoardError:
        raise
    except Exception as e:
        raise BoardError(415, "bad_frame", "that is not a picture that can be read", "a JPEG file") from e


def _open(data: bytes, formats: tuple[str, ...] = tuple(_TYPES)) -> Pillow.Image:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Pillow.DecompressionBombWarning)
        picture = Pillow.open(io.BytesIO(data), formats=formats)
    width, height = picture.size
    if width * height > MAX_PIXELS:
        raise BoardError(413, "image_too_large", f"the image is {width} × {height}", f"at most {MAX_PIXELS} pixels")
    return picture


def _without_metadata(picture: Pillow.Image, kind: str) -> tuple[bytes, tuple[int, int]]:
    upright = ImageOps.exif_transpose(picture)
    upright.info.clear()
    out = io.BytesIO()
    options = {"quality": 92} if kind == "JPEG" else {}
    upright.save(out, format=kind, **options)
    return out.getvalue(), upright.size


def keep(folder: Path, data: bytes) -> str:
    """Write the file, whole or not at all, and return the hash that names it. 503 when the disk cannot take it."""
    digest = hashlib.sha256(data).hexdigest()
    path = path_of(folder, digest)
    if path.exists():
        return digest
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            try:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
                Path(file.name).replace(path)
            except BaseException:
                Path(file.name).unlink(missing_ok=True)
                raise
    except OSError as e:
        raise BoardError(503, "storage", f"the image could not be kept: {e.strerror}", "try again later", 30.0) from e
    return digest


def path_of(folder: Path, digest: str) -> Path:
    return folder / digest[:2] / digest
