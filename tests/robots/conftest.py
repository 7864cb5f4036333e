"""What the tests of robots share."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from driver_scene import Drivers

pytest.register_assert_rewrite("agentrob.robots.contract")


@pytest.fixture
def drivers(tmp_path: Path) -> Iterator[Drivers]:
    """Starts drivers of fake robots and ends them all."""
    started = Drivers(tmp_path)
    yield started
    started.close()
