"""Plots of paths, with and without matplotlib."""

from __future__ import annotations

import io
from types import SimpleNamespace
from typing import Any

import pytest
from PIL import Image

from agentrob.agent.media import plot
from agentrob.board.content import images
from agentrob.model import Op, Primitive


@pytest.fixture
def results() -> list[Any]:
    """Return what a plot uses of the result of a step that walked 0.5 m."""
    path = tuple((0.1 * n, 0.1 * n, 0.0, 0.0) for n in range(6))
    return [SimpleNamespace(path=path, primitive=Primitive(Op.MOVE, distance_m=0.5))]


def test_a_path_is_drawn_as_a_picture(results: list[Any]) -> None:
    drawn = plot.path_plot(results)
    assert drawn is not None
    assert Image.open(io.BytesIO(drawn)).size == (800, 600)


def test_the_board_keeps_a_plot_as_it_is_and_need_not_encode_it_again(results: list[Any]) -> None:
    drawn = plot.path_plot(results)
    assert drawn is not None
    assert images.check(drawn)[1] == drawn


def test_without_matplotlib_there_is_no_plot_and_no_error(results: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plot, "available", lambda: False)
    plot.warm_up()
    assert plot.path_plot(results) is None
