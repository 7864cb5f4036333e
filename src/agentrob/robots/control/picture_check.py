"""Is what a camera sent a picture? One that is black, or all of one colour, shows nothing and must not pass for one."""

from __future__ import annotations

import io
import time
from dataclasses import replace

from agentrob.model import ActionResult, Outcome

#: A picture is looked at this small, so that the noise of a sensor in the dark does not count; and it shows something
#: when its lightest and its darkest spot differ by more than this (of 255).
SMALL, LEAST_CONTRAST = (32, 24), 8


def picture_problem(jpeg: bytes) -> str | None:
    """A sentence when there is nothing to be seen on it, None when there is."""
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
    """A result with a picture; `failed` when there is nothing to be seen on it. The picture is kept."""
    if not (result.ok and result.image and (sentence := picture_problem(result.image))):
        return result
    return replace(result, outcome=Outcome.FAILED, reason="bad_image", message=sentence, ended_s=time.monotonic())
