"""Fixtures of the board's tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.board.running_board import RunningBoard, running_board


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    """Start one board for all tests of a module."""
    with running_board(tmp_path_factory.mktemp("board")) as running:
        yield running


@pytest.fixture
def fresh_board(tmp_path: Path) -> Iterator[Callable[..., RunningBoard]]:
    """Start boards with their own settings, for one test."""
    with ExitStack() as stack:
        n = iter(range(100))
        yield lambda **options: stack.enter_context(running_board(tmp_path / str(next(n)), **options))
