"""The contract of detectors: a test of any detector, also of another package, calls `check_detector`.

from agentrob.eyes.contract import check_detector

def test_my_detector_keeps_the_contract():
    check_detector(MyDetector({}))
"""

from __future__ import annotations

import numpy as np

from agentrob.eyes.protocol import Detector, Picture

_SIZES = ((480, 640), (240, 320), (33, 47), (1, 1))


def check_detector(detector: Detector) -> None:
    """Raise `AssertionError` with the sentence that a detector does not keep."""
    assert isinstance(detector, Detector), "it has things, colours and detect(picture)"
    words = [*detector.things, *detector.colours]
    assert all(isinstance(word, str) and word == word.lower().strip() != "" for word in words), "its words are English"
    for picture in _pictures():
        before = picture.copy()
        found = detector.detect(picture)
        assert np.array_equal(picture, before), "it leaves the picture as it is"
        height, width = picture.shape[:2]
        for one in found:
            left, top, right, bottom = one.box
            assert 0 <= left < right <= width, "each box is within the picture"
            assert 0 <= top < bottom <= height, "each box is within the picture"
            assert 0.0 <= one.score <= 1.0, "scores are from 0 to 1"
            assert not one.thing or one.thing in detector.things, "it names only things that it says to know"
            assert not one.colour or one.colour in detector.colours, "it names only colours that it says to know"
        assert [one.score for one in found] == sorted((one.score for one in found), reverse=True), "the surest is first"
        assert list(detector.detect(picture)) == list(found), "the same picture has the same things in it"


def _pictures() -> list[Picture]:
    noise = np.random.default_rng(1)
    found = [np.full((*size, 3), level, dtype=np.uint8) for size in _SIZES for level in (0, 128, 255)]
    found += [noise.integers(0, 256, (*size, 3), dtype=np.uint8) for size in _SIZES]
    scene = np.full((240, 320, 3), 140, dtype=np.uint8)
    scene[60:120, 40:100] = (220, 30, 30)
    scene[100:200, 200:230] = (30, 60, 210)
    return [*found, scene]
