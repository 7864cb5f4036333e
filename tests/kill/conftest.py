"""Fixtures of the kill tests: one scene for all kill points, because only killed processes are restarted."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from tests.board.running_board import database_for
from tests.databases import BOTH
from tests.kill.kill_scene import KillScene
from tests.sizes import size


@pytest.fixture(scope="module", params=BOTH)
def scene(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[KillScene]:
    folder = tmp_path_factory.mktemp("kill")
    on_postgres = request.param == "postgresql"
    database = database_for(request.getfixturevalue("postgres"), folder) if on_postgres else ""
    made = KillScene(folder, database, getattr(request.module, "RECORDING", "auto"))
    yield made
    made.close()


@pytest.fixture
def kills() -> int:
    """Return the number of random kills, which `AGENTROB_KILLS` overrides."""
    return int(os.environ.get("AGENTROB_KILLS", size(30, 200)))


@pytest.fixture
def seed() -> int:
    """Return the seed of the random kills; `AGENTROB_KILL_SEED` repeats an earlier run."""
    return int(os.environ.get("AGENTROB_KILL_SEED", "6"))
