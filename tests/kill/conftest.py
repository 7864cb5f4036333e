"""Fixtures of the kill tests: one house for all kill points, because only killed processes are restarted."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from tests.kill.kill_house import House
from tests.sizes import size


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Iterator[House]:
    made = House(tmp_path_factory.mktemp("kill"))
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
