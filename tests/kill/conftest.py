"""Fixtures of the tests that kill: one house for all points, since only what is killed is started again."""

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
    """How many random kills, unless `AGENTROB_KILLS` names a number."""
    return int(os.environ.get("AGENTROB_KILLS", size(30, 200)))


@pytest.fixture
def seed() -> int:
    """Of the random kills; `AGENTROB_KILL_SEED` repeats another run."""
    return int(os.environ.get("AGENTROB_KILL_SEED", "6"))
