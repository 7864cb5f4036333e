"""How much a measured value may differ from the requested one: the tolerance of the driver for a step that is done."""

from __future__ import annotations

from typing import Any

import pytest

from agentrob.robots.control.step_runner import TOLERANCE_DEG, TOLERANCE_M, TOLERANCE_SHARE

#: Reports round distances to centimetres and angles to tenths of a degree.
ROUNDING_M, ROUNDING_DEG = 0.005, 0.05


def about_m(asked_m: float) -> Any:
    """Return what equals any distance that a finished move of `asked_m` may have."""
    return pytest.approx(asked_m, abs=TOLERANCE_M + TOLERANCE_SHARE * asked_m + ROUNDING_M)


def about_deg(asked_deg: float) -> Any:
    """Return what equals any angle that a finished turn of `asked_deg` may have."""
    return pytest.approx(asked_deg, abs=TOLERANCE_DEG + TOLERANCE_SHARE * asked_deg + ROUNDING_DEG)
