"""Rejects camera pictures that show nothing: unreadable, black, or all of one colour."""

from __future__ import annotations

import io
import time
from dataclasses import replace

from agentrob.model import ActionResult, Outcome

#: A picture is scaled to this size, which averages out the noise of a sensor in the dark. It shows something if its
#: lightest and darkest spots differ by more than this (of 255).
SMALL, LEAST_CONTRAST = (32, 24), 8


def picture_problem(jpeg: bytes) -> str | None:
    """Return why the picture shows nothing, or None if it shows something."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(jpeg), formats=("JPEG",)) as image:
            image.draft("L", (160, 120))
            small = image.convert("L").resize(SMALL, Image.Resampling.BOX)
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as e:
        return f"The camera sent a picture that cannot be read ({type(e).__name__})."
    levels = small.tobytes()  # one byte a pixel
    if max(levels) - min(levels) > LEAST_CONTRAST:
        return None
    what = "black" if max(levels) < 40 else "of one colour"
    return f"The picture is all {what}: the camera is covered, in the dark or broken."


def fail_blank_picture(result: ActionResult) -> ActionResult:
    """Return the result, as `failed` if its picture shows nothing. The picture is kept."""
    if not (result.ok and result.image and (sentence := picture_problem(result.image))):
        return result
    return replace(result, outcome=Outcome.FAILED, reason="bad_image", message=sentence, ended_s=time.monotonic())
