"""A detector without a model: coloured things, and from their outlines whether they are balls, boxes or columns.

It knows plain colours only, not black, white, grey and brown, which walls and floors have.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agentrob.errors import ConfigError
from agentrob.eyes.protocol import Detection, Picture

#: Hues in degrees: each colour up to its bound, and red again above the last one.
HUES = (
    ("red", 14.0), ("orange", 38.0), ("yellow", 68.0), ("green", 165.0), ("teal", 195.0), ("blue", 262.0),
    ("purple", 295.0), ("pink", 342.0), ("red", 360.0),
)  # fmt: skip
#: Orange is seen only where it is bright: wood is a dark one.
LEAST_SATURATION, LEAST_VALUE, LEAST_ORANGE_VALUE = 0.58, 0.22, 0.75
#: Wider pictures are read in every n-th pixel.
READ_PX = 320
#: Smaller things are noise, as shares of the pixels read.
LEAST_SHARE = 0.0008
#: How much of its box a thing fills, and of the corners of that box.
ROUND_FILL, ROUND_CORNERS, SQUARE_FILL, SQUARE_CORNERS = (0.66, 0.88), 0.3, 0.78, 0.5
#: How much longer than wide a ball may seem, and a column at least.
ROUND_ASPECT, COLUMN_ASPECT = 1.3, 1.5
#: What is flatter than this is the edge of something.
FLAT_ASPECT = 5
_CORNER = 0.15


class ColourDetector:
    """See `agentrob.eyes.protocol.Detector`. The option `least_share` is the smallest thing, as a share of the
    picture."""

    things: Collection[str] = frozenset({"ball", "box", "column"})
    colours: Collection[str] = frozenset(name for name, _ in HUES)

    def __init__(self, options: Mapping[str, Any]) -> None:
        if unknown := sorted(set(options) - {"least_share"}):
            raise ConfigError(f"eyes.options.{unknown[0]} is not an option of the detector colours; valid: least_share")
        share = options.get("least_share", LEAST_SHARE)
        if isinstance(share, bool) or not isinstance(share, (int, float)) or not 0 < share < 1:
            raise ConfigError(f"eyes.options.least_share = {share!r} must be a number between 0 and 1, such as 0.001")
        self._least_share = float(share)

    def detect(self, picture: Picture) -> Sequence[Detection]:
        every = max(1, -(-picture.shape[1] // READ_PX))
        read = picture[::every, ::every]
        named = _named(read)
        least_px = max(12, round(self._least_share * named.size))
        found = [
            _detection(mask, at, HUES[number][0], every, picture.shape, named.size)
            for number in range(len(HUES) - 1)
            for mask, at in _blobs(named == number, least_px)
            if not _is_ground(mask, at, named.shape)
        ]
        return sorted(found, key=lambda one: -one.score)


def _named(picture: Picture) -> NDArray[np.int8]:
    """Return for each pixel the place of its colour in `HUES`, -1 for none."""
    rgb = picture.astype(np.float32) / 255
    high, low = rgb.max(axis=2), rgb.min(axis=2)
    spread = high - low
    safe = np.where(spread > 0, spread, 1)
    red, green, blue = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    sixth = np.where(
        high == red,
        ((green - blue) / safe) % 6,
        np.where(high == green, (blue - red) / safe + 2, (red - green) / safe + 4),
    )
    hue = 60 * sixth
    place = np.searchsorted(np.array([bound for _, bound in HUES]), hue, side="right")
    place = np.where(place >= len(HUES) - 1, 0, place)
    plain = (spread > LEAST_SATURATION * high) & (high > LEAST_VALUE)
    wood = (place == 1) & (high < LEAST_ORANGE_VALUE)
    return np.where(plain & ~wood, place, -1).astype(np.int8)


def _blobs(mask: NDArray[np.bool_], least_px: int) -> Iterator[tuple[NDArray[np.bool_], tuple[int, int]]]:
    """Yield each connected part of a mask that is large enough, cut out, with its place (left, top)."""
    if int(mask.sum()) < least_px:
        return
    runs, parent = _runs(mask)
    roots = np.array([_root(parent, n) for n in range(len(parent))])
    for root in np.unique(roots):
        rows = runs[roots == root]
        if int((rows[:, 2] - rows[:, 1]).sum()) < least_px:
            continue
        top, left = int(rows[:, 0].min()), int(rows[:, 1].min())
        cut = np.zeros((int(rows[:, 0].max()) - top + 1, int(rows[:, 2].max()) - left), dtype=bool)
        for y, start, end in rows:
            cut[y - top, start - left : end - left] = True
        yield cut, (left, top)


def _runs(mask: NDArray[np.bool_]) -> tuple[NDArray[np.int64], list[int]]:
    """Return the runs of a mask as (row, start, end), and for each an earlier run that it is connected with."""
    edges = np.diff(np.pad(mask, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    rows, starts = np.nonzero(edges == 1)
    ends = np.nonzero(edges == -1)[1]
    parent = list(range(len(rows)))
    above = 0
    for n in range(len(rows)):
        while above < n and (rows[above] < rows[n] - 1 or (rows[above] == rows[n] - 1 and ends[above] <= starts[n])):
            above += 1
        other = above
        while other < n and rows[other] == rows[n] - 1 and starts[other] < ends[n]:
            parent[_root(parent, n)] = _root(parent, other)
            other += 1
    return np.stack([rows, starts, ends], axis=1), parent


def _root(parent: list[int], n: int) -> int:
    while parent[n] != n:
        parent[n] = parent[parent[n]]
        n = parent[n]
    return n


def _is_ground(mask: NDArray[np.bool_], at: tuple[int, int], shape: tuple[int, ...]) -> bool:
    """Return whether a part reaches three edges of the picture, as a wall, a floor or a sky does."""
    left, top, right, bottom = at[0], at[1], at[0] + mask.shape[1], at[1] + mask.shape[0]
    return [left == 0, top == 0, right >= shape[1], bottom >= shape[0]].count(True) >= 3


def _detection(
    mask: NDArray[np.bool_], at: tuple[int, int], colour: str, every: int, shape: tuple[int, ...], pixels: int
) -> Detection:
    (height, width), (left, top) = mask.shape, at
    box = (left * every, top * every, min((left + width) * every, shape[1]), min((top + height) * every, shape[0]))
    cut_off = box[0] == 0 or box[1] == 0 or box[2] >= shape[1] or box[3] >= shape[0]
    thing = "" if cut_off else _thing(mask)
    share = float(mask.sum()) / pixels
    return Detection(thing, colour, box, round(min(1.0, 0.5 + 5 * share) * (1.0 if thing else 0.8), 3))


def _thing(mask: NDArray[np.bool_]) -> str:
    """Return what an outline looks like, empty if that is unclear."""
    height, width = mask.shape
    if width > FLAT_ASPECT * height:
        return ""
    fill, corners = float(mask.mean()), _corners(mask)
    as_wide_as_high = max(height, width) <= ROUND_ASPECT * min(height, width)
    if as_wide_as_high and ROUND_FILL[0] <= fill <= ROUND_FILL[1] and corners <= ROUND_CORNERS:
        return "ball"
    if fill >= SQUARE_FILL and corners >= SQUARE_CORNERS:
        return "column" if height > COLUMN_ASPECT * width else "box"
    return ""


def _corners(mask: NDArray[np.bool_]) -> float:
    """Return how much of the corners of its box a thing fills."""
    y, x = max(1, round(_CORNER * mask.shape[0])), max(1, round(_CORNER * mask.shape[1]))
    return float(np.mean([part.mean() for part in (mask[:y, :x], mask[:y, -x:], mask[-y:, :x], mask[-y:, -x:])]))
