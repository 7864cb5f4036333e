"""Pictures for a model: at most 1024 pixels wide, as JPEG, without what a camera wrote beside them."""

from __future__ import annotations

import io

MOST_PX = 1024
QUALITY = 80


def shrink_jpeg(jpeg: bytes, most_px: int = MOST_PX) -> bytes:
    """The picture as a small JPEG; one that cannot be read stays as it is, and the model's host says what it thinks."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(jpeg)) as picture:
            if max(picture.size) <= most_px and picture.format == "JPEG":
                return jpeg
            picture.draft("RGB", (most_px, most_px))
            small = picture.convert("RGB")
            small.thumbnail((most_px, most_px), Image.Resampling.BILINEAR)
            out = io.BytesIO()
            small.save(out, "JPEG", quality=QUALITY)
            return out.getvalue()
    except (OSError, ValueError):
        return jpeg
