"""Check uploaded pictures by decoding them, and store them as files named by their hash."""

from __future__ import annotations

import hashlib
import io
import os
import struct
import tempfile
import warnings
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from PIL import Image as Pillow
from PIL import ImageCms, ImageOps

from agentrob.board.content import image_metadata
from agentrob.board.db.records import SMALL, Image
from agentrob.errors import BoardError

MAX_BYTES = 8 * 1024 * 1024
MAX_PIXELS = 25_000_000
MAX_FRAME_BYTES = 2 * 1024 * 1024
#: The total of all frames of an animation.
MAX_FRAMES, MAX_MOVING_PIXELS = 300, 100_000_000
_TYPES = {"JPEG": "image/jpeg", "PNG": "image/png", "WEBP": "image/webp", "GIF": "image/gif"}


def check(data: bytes) -> tuple[Image, bytes]:
    """The picture (without id) and its bytes without metadata: location, owner, comments, profiles.

    Decodes the whole file, so not on the event loop. 413 if too large, 415 for another type.
    """
    if len(data) > MAX_BYTES:
        raise BoardError(413, "image_too_large", f"the image has {len(data)} bytes", f"at most {MAX_BYTES} bytes")
    try:
        with _open(data) as picture:
            width, height = picture.size
            moving = _check_moving(picture)
            picture.load()
            # A JPEG with more pictures behind the first one (phones make them) becomes a plain JPEG of the first.
            several = picture.format == "MPO"
            kind = "JPEG" if several else str(picture.format)
            if moving:
                _check_frames(picture)
                data = image_metadata.only(data, kind)
            elif several or not _is_plain(data, kind):
                data, (width, height) = _without_metadata(picture, kind)
                if not _is_plain(data, kind):
                    raise ValueError("there is more than pixels in it")
    except BoardError:
        raise
    except Exception as e:  # Pillow raises nearly everything for broken files
        raise BoardError(
            415, "bad_image", "that is not a picture that can be read", "a JPEG, PNG, WebP or GIF file"
        ) from e
    return Image("", width, height, _TYPES[kind]), data


def _check_moving(picture: Pillow.Image) -> bool:
    """Return whether it is animated; 413 if it has too many frames or pixels, before any of them is decoded."""
    frames = getattr(picture, "n_frames", 1) if picture.format in ("WEBP", "GIF") else 1
    width, height = picture.size
    if frames > MAX_FRAMES or (frames > 1 and frames * width * height > MAX_MOVING_PIXELS):
        what = f"the picture has {frames} frames of {width} × {height}"
        raise BoardError(
            413, "image_too_large", what, f"at most {MAX_FRAMES} frames, {MAX_MOVING_PIXELS} pixels together"
        )
    return frames > 1


def _check_frames(picture: Pillow.Image) -> None:
    """Decode every frame. Metadata of a camera cannot be removed from an animation without damage, so it is refused."""
    for number in range(getattr(picture, "n_frames", 1)):
        picture.seek(number)
        picture.load()
    if any(picture.info.get(k) for k in ("exif", "xmp")):
        raise BoardError(415, "bad_image", "that animation has metadata of a camera", "one without EXIF and XMP")


def check_frame(data: bytes) -> None:
    """Check only the header of a live picture, because the robot's own agent sends ten a second."""
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


def _is_plain(data: bytes, kind: str) -> bool:
    try:
        return image_metadata.only(data, kind) == data
    except (ValueError, IndexError, struct.error):
        return False


def _without_metadata(picture: Pillow.Image, kind: str) -> tuple[bytes, tuple[int, int]]:
    """The picture encoded again: upright, in sRGB, with its transparency."""
    upright = ImageOps.exif_transpose(picture)
    profile, transparent = upright.info.get("icc_profile"), upright.info.get("transparency")
    if profile and upright.mode in ("RGB", "CMYK"):
        with suppress(ImageCms.PyCMSError, OSError):  # a broken profile: keep the colour values as they are
            made = ImageCms.profileToProfile(
                upright, ImageCms.ImageCmsProfile(io.BytesIO(profile)), ImageCms.createProfile("sRGB"), outputMode="RGB"
            )
            upright = made or upright
    upright.info.clear()
    if transparent is not None:
        upright.info["transparency"] = transparent
    out = io.BytesIO()
    options = {"quality": 92} if kind in ("JPEG", "WEBP") else {}
    upright.save(out, format=kind, **options)
    return out.getvalue(), upright.size


def keep(folder: Path, data: bytes) -> Path:
    """Write the file atomically and return its path; its name is the hash. 503 if the disk cannot be written.

    Until a picture in the database refers to it, it may be deleted again (`moderation.take_away`).
    """
    path = path_of(folder, hashlib.sha256(data).hexdigest())
    if path.exists():
        return path
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
    return path


@lru_cache(maxsize=128)
def small(path: Path, side: int = SMALL) -> bytes:
    """A stored picture, or the first one of an animation, as a WebP whose longer side has at most `side` pixels.

    Decodes it, so not on the event loop; caches some in memory. 404 if the file is missing.
    """
    try:
        with Pillow.open(path) as picture:
            picture.draft("RGB", (side, side))
            picture.thumbnail((side, side))
            out = io.BytesIO()
            picture.convert("RGBA" if "A" in picture.getbands() else "RGB").save(out, "WEBP", quality=80)
            return out.getvalue()
    except OSError as e:
        raise gone() from e


def gone() -> BoardError:
    """The error for a picture in the database whose file is missing."""
    return BoardError(404, "no_such_image", "the file of this picture is gone", "ask an admin: a backup may have it")


def path_of(folder: Path, digest: str) -> Path:
    return folder / digest[:2] / digest
