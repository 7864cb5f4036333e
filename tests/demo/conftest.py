"""One demo for all tests of a module; no test leaves a demo running."""

from collections.abc import Iterator

import pytest

from tests.demo.running import RUNNING, RunningDemo, end_leftovers, start_demo


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDemo]:
    before = len(RUNNING)
    yield start_demo(tmp_path_factory.mktemp("demos") / "demo")
    end_leftovers(before)


@pytest.fixture(autouse=True)
def no_demo_left(request: pytest.FixtureRequest) -> Iterator[None]:
    if "demo" in request.fixturenames:
        request.getfixturevalue("demo")
    before = len(RUNNING)
    yield
    end_leftovers(before)
