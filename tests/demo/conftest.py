"""One demo for the tests of a module."""

import signal
from collections.abc import Iterator

import pytest
from running import RunningDemo, start_demo


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDemo]:
    running = start_demo(tmp_path_factory.mktemp("demo") / "data")
    yield running
    running.process.send_signal(signal.SIGINT)
    running.process.wait(10)
