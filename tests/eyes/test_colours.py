"""The detector without a model: colours, outlines, and where things are; on drawn pictures whose truth is known."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageDraw

from agentrob.errors import ConfigError
from agentrob.eyes.colours import ColourDetector
from agentrob.eyes.contract import check_detector
from agentrob.eyes.sight import marked, seen_in

SEEN = ColourDetector({})
COLOURS = {
    "red": "#db241c",
    "orange": "#ff8000",
    "yellow": "#f7c71f",
    "green": "#21994a",
    "teal": "#10b0b0",
    "blue": "#2154d1",
    "purple": "#7020d0",
    "pink": "#f030a0",
}
#: What walls, floors and shadows look like.
PLAIN = ("#ffffff", "#000000", "#808080", "#b8b4a8", "#996940", "#d4b899", "#5c4529", "#3d3836")


def jpeg(*shapes: tuple[str, tuple[int, int, int, int], str], ground: str = "#b8b4a8") -> bytes:
    """Draw shapes ("ellipse" or "rectangle", box, colour) on a 640x480 picture."""
    image = Image.new("RGB", (640, 480), ground)
    draw = ImageDraw.Draw(image)
    for shape, box, colour in shapes:
        getattr(draw, shape)(box, fill=colour)
    out = io.BytesIO()
    image.save(out, "JPEG", quality=85)
    return out.getvalue()


def test_it_keeps_the_contract_of_detectors() -> None:
    check_detector(SEEN)


@pytest.mark.parametrize(("colour", "paint"), COLOURS.items())
def test_it_names_plain_colours_and_shapes(colour: str, paint: str) -> None:
    ball, box, column = (
        ("ellipse", (60, 200, 160, 300)),
        ("rectangle", (260, 200, 380, 300)),
        ("rectangle", (480, 100, 530, 300)),
    )
    seen = seen_in(jpeg((*ball, paint), (*box, paint), (*column, paint)), SEEN, 60.0)
    by_place = sorted(seen, key=lambda one: one.box[0])
    assert [(one.colour, one.thing) for one in by_place] == [(colour, "ball"), (colour, "box"), (colour, "column")]


@pytest.mark.parametrize("ground", PLAIN)
def test_walls_floors_and_wood_are_not_coloured_things(ground: str) -> None:
    assert seen_in(jpeg(ground=ground), SEEN, 60.0) == ()


@given(st.integers(20, 460), st.integers(20, 300), st.integers(24, 120), st.sampled_from(sorted(COLOURS)))
def test_a_ball_anywhere_in_the_picture_is_seen_where_it_is(x: int, y: int, width: int, colour: str) -> None:
    seen = seen_in(jpeg(("ellipse", (x, y, x + width, y + width), COLOURS[colour])), SEEN, 60.0)
    assert [(one.thing, one.colour) for one in seen] == [("ball", colour)]
    focal_px = 240 / math.tan(math.radians(30))
    assert seen[0].left_deg == pytest.approx(math.degrees(math.atan((320 - x - width / 2) / focal_px)), abs=0.7)


def test_what_is_cut_off_by_the_picture_s_edge_has_no_shape() -> None:
    (seen,) = seen_in(jpeg(("ellipse", (-60, 200, 60, 320), COLOURS["red"])), SEEN, 60.0)
    assert (seen.thing, seen.colour) == ("", "red")


def test_a_wall_a_floor_and_a_sky_are_not_things() -> None:
    sky, floor = ("rectangle", (0, 0, 640, 200), COLOURS["blue"]), ("rectangle", (0, 300, 640, 480), COLOURS["red"])
    assert seen_in(jpeg(sky, floor), SEEN, 60.0) == ()


def test_specks_are_not_things() -> None:
    assert seen_in(jpeg(("rectangle", (100, 100, 104, 104), COLOURS["red"])), SEEN, 60.0) == ()


def test_the_marked_picture_has_a_frame_around_the_thing() -> None:
    plain = jpeg(("ellipse", (200, 200, 300, 300), COLOURS["red"]))
    (seen,) = seen_in(plain, SEEN, 60.0)
    before, after = (
        np.asarray(Image.open(io.BytesIO(data))).astype(int) for data in (plain, marked(plain, [(seen, "red ball")]))
    )
    assert before.shape == after.shape
    changed = np.abs(before - after).max(axis=2) > 60
    left, top, right, bottom = seen.box
    assert changed[top - 3 : top - 1, left + 10 : right - 10].mean() > 0.9
    assert changed[top + 10 : bottom - 10, left - 3 : left - 1].mean() > 0.9
    assert not changed[bottom + 30 :].any()
    assert changed[top + 10 : bottom - 10, left + 10 : right - 10].mean() < 0.01  # the thing itself stays visible
    assert changed[:top, left : left + 60].any()  # the label


@pytest.mark.parametrize(("options", "said"), [({"hue": 3}, "least_share"), ({"least_share": 2}, "between 0 and 1")])
def test_an_option_that_it_does_not_know_is_an_error_that_says_what_is_valid(
    options: dict[str, int], said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        ColourDetector(options)
