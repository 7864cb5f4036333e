"""One demo for the tests of a module, and none left behind by any test."""

from collections.abc import Iterator

import pytest

from tests.demo.running import RUNNING, RunningDemo, end_left, start_demo


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDemo]:
    before = len(RUNNING)
    yield start_demo(tmp_path_factory.mktemp("demos") / "demo")
    end_left(before)


@pytest.fixture(autouse=True)
def nothing_left(request: pytest.FixtureRequest) -> Iterator[None]:
    if "demo" in request.fixturenames:
        request.getfixturevalue("demo")
    before = len(RUNNING)
    yield
    end_left(before)
