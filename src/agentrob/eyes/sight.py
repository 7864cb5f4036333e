"""Look at a JPEG with a detector: what is where, as angles from straight ahead, and the picture with it marked."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agentrob.eyes.protocol import Detection, Detector

#: Vertical fields of view in degrees of cameras whose owner gives none: those of the simulated robots.
FOV_DEG, FOV_OF_MODEL_DEG = 60.0, {"go2": 60.0, "g1": 60.0, "fake": 60.0}
#: More things than this are not marked, the surest are.
MOST_MARKED = 12
_LINE_PX, _GAP_PX, _FONT_PX = 3, 3, 16
_MARK, _INK = (255, 255, 255), (20, 20, 20)


@dataclass(frozen=True, slots=True)
class Seen:
    """A thing that was seen. `left_deg` is the angle of its middle from straight ahead, positive to the left."""

    thing: str
    colour: str
    left_deg: float
    box: tuple[int, int, int, int]
    score: float


def seen_in(jpeg: bytes, detector: Detector, fov_deg: float) -> tuple[Seen, ...]:
    """Return what the detector finds in a JPEG, the surest first. `fov_deg` is the camera's vertical field of view.

    Raises what the detector and Pillow raise.
    """
    from PIL import Image

    with Image.open(io.BytesIO(jpeg)) as image:
        picture = np.asarray(image.convert("RGB"))
    height, width = picture.shape[:2]
    found = (one for one in detector.detect(picture) if _inside(one, width, height))
    return tuple(Seen(d.thing, d.colour, _left_deg(d, width, height, fov_deg), d.box, d.score) for d in found)


def marked(jpeg: bytes, labels: Sequence[tuple[Seen, str]]) -> bytes:
    """Return the JPEG with a box and a label around each thing."""
    from PIL import Image, ImageDraw, ImageFont

    with Image.open(io.BytesIO(jpeg)) as image:
        picture = image.convert("RGB")
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(_FONT_PX)
    for one, label in labels[:MOST_MARKED]:
        left, top, right, bottom = one.box
        for ink, line_px, away_px in ((_INK, _LINE_PX + 2, _GAP_PX + 1), (_MARK, _LINE_PX, _GAP_PX)):
            frame = (left - away_px, top - away_px, right - 1 + away_px, bottom - 1 + away_px)
            draw.rectangle(tuple(map(float, frame)), outline=ink, width=line_px)
        wide, high = draw.textbbox((0, 0), label, font=font)[2:]
        x = max(0, min(left, picture.width - int(wide) - 6))
        y = top - int(high) - 10 if top > high + 10 else min(bottom + 4, picture.height - int(high) - 6)
        draw.rectangle((x, y, x + wide + 6, y + high + 6), fill=_MARK)
        draw.text((x + 3, y + 2), label, fill=_INK, font=font)
    out = io.BytesIO()
    picture.save(out, "JPEG", quality=85)
    return out.getvalue()


def _inside(one: Detection, width: int, height: int) -> bool:
    left, top, right, bottom = one.box
    return 0 <= left < right <= width and 0 <= top < bottom <= height


def _left_deg(one: Detection, width: int, height: int, fov_deg: float) -> float:
    focal_px = height / 2 / math.tan(math.radians(fov_deg) / 2)
    middle_px = (one.box[0] + one.box[2]) / 2
    return math.degrees(math.atan((width / 2 - middle_px) / focal_px))
