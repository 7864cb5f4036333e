"""Fixtures of the worker's tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.robots.driver.lease import TTL_S
from tests.agent.agent_scene import Driver, robot_settings
from tests.board.running_board import RunningBoard, running_board
from tests.worker.ledger_driver import run_ledger_driver
from tests.worker.worker_processes import Workers


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    """Start one driver for all tests of a module."""
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings(), lease_s=TTL_S)
    yield made
    made.end()


@pytest.fixture
def board(tmp_path: Path) -> Iterator[RunningBoard]:
    with running_board(tmp_path / "board") as board:
        yield board


@pytest.fixture
def workers(short_folder: Path, board: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> Iterator[Workers]:
    monkeypatch.setenv("AGENTROB_RUNTIME", str(short_folder))
    (runtime := short_folder / "agentrob").mkdir(mode=0o700)
    driver = Driver(runtime, robot_settings(options={"time_scale": 1}), run=run_ledger_driver)
    yield Workers(short_folder, board, driver)
    driver.end()
