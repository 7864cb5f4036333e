"""How the tests of a run are distributed over its workers (pytest-xdist with `--dist loadfile`).

A worker runs whole files, so that a module's board, driver or world starts once. Files whose tests need a world that
keeps pace with the clock run on at most `WORLDS` workers at a time; they wait most of the time, and the files of other
workers use the cores meanwhile. The longest files begin first, because otherwise one worker would still run one of them
when the others have finished.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn, Protocol

import pytest
from xdist.workermanage import parse_tx_spec_config

from tests.slices import FAST, durations, files_with

#: So many workers run files that need a world.
WORLDS = 2
#: A worker begins a test only when it knows the next one, so it gets another file when it has this many tests left.
LOW = 2
#: The seconds assumed for a file that `durations.toml` does not list.
DEFAULT_S = 5.0


class Worker(Protocol):
    """What the scheduler uses of xdist's `WorkerController`."""

    @property
    def shutting_down(self) -> bool: ...

    def send_runtest_some(self, indices: Sequence[int]) -> None: ...

    def shutdown(self) -> None: ...


class FileScheduler:
    """Implements the protocol `xdist.scheduler.Scheduling` for this number of workers.

    `needs_world` tells which files need a world, and `seconds` how long files take.
    """

    def __init__(self, workers: int, needs_world: Callable[[str], bool], seconds: Mapping[str, float]) -> None:
        self._workers, self._needs_world, self._seconds = workers, needs_world, seconds
        self._tests: list[str] = []
        self._collected: dict[Worker, list[str]] = {}
        self._pending: dict[Worker, list[int]] = {}
        self._queue: list[list[int]] = []
        self._begun = False

    @property
    def nodes(self) -> list[Any]:
        return list(self._pending)

    @property
    def collection_is_completed(self) -> bool:
        return len(self._collected) >= self._workers

    @property
    def tests_finished(self) -> bool:
        waiting = self._queue or any(len(tests) >= LOW for tests in self._pending.values())
        return self.collection_is_completed and not waiting

    @property
    def has_pending(self) -> bool:
        return bool(self._queue) or any(self._pending.values())

    def add_node(self, node: Worker) -> None:
        self._pending[node] = []

    def add_node_collection(self, node: Worker, collection: Sequence[str]) -> None:
        """Take the tests that a worker collected. Raises `UsageError` if others collected other tests."""
        if self._tests and list(collection) != self._tests:
            differ = sorted(set(collection) ^ set(self._tests)) or ["their order"]
            raise pytest.UsageError(f"workers collected different tests: {', '.join(differ[:5])}")
        self._collected[node] = self._tests = list(collection)

    def schedule(self) -> None:
        """Begin when all workers have collected; called again when a worker has replaced one that crashed."""
        if not self._begun:
            self._begun = True
            files: dict[str, list[int]] = {}
            for number, test in enumerate(self._tests):
                files.setdefault(file_of(test), []).append(number)
            self._queue = [files[file] for file in sorted(files, key=self._order)]
        for _ in range(LOW):
            for node in self.nodes:
                self._feed(node)

    def mark_test_complete(self, node: Worker, item_index: int, duration: float = 0) -> None:
        self._pending[node].remove(item_index)
        self._feed(node)

    def remove_node(self, node: Worker) -> str | None:
        """Forget a worker; return the test that it was running if it crashed. Its other tests go to other workers."""
        crashed, *rest = self._pending.pop(node) or [None]
        if crashed is None:
            return None
        if rest:
            self._queue.insert(0, rest)
        for other in self.nodes:
            self._feed(other)
        return self._tests[crashed]

    def mark_test_pending(self, item: str) -> NoReturn:
        raise NotImplementedError

    def remove_pending_tests_from_node(self, node: Worker, indices: Sequence[int]) -> NoReturn:
        raise NotImplementedError

    def _order(self, file: str) -> tuple[bool, float, str]:
        return not self._needs_world(file), -self._seconds.get(file, DEFAULT_S), file

    def _feed(self, node: Worker) -> None:
        """Give a worker its next file if it has few tests left; end it if no file is left for it."""
        pending = self._pending[node]
        if node.shutting_down or len(pending) > LOW:
            return
        worlds = sum(any(map(self._in_world, tests)) for other, tests in self._pending.items() if other is not node)
        for tests in self._queue:
            if worlds < WORLDS or not self._in_world(tests[0]):
                self._queue.remove(tests)
                pending += tests
                node.send_runtest_some(tests)
                return
        node.shutdown()

    def _in_world(self, test: int) -> bool:
        return self._needs_world(file_of(self._tests[test]))


def file_of(test: str) -> str:
    return test.split("::", maxsplit=1)[0]


def pytest_xdist_make_scheduler(config: pytest.Config) -> Any:
    """Use this scheduler for `--dist loadfile`, and xdist's own for others."""
    if config.getoption("dist") != "loadfile":
        return None
    worlds = set(files_with("sim"))
    return FileScheduler(len(parse_tx_spec_config(config)), worlds.__contains__, durations(FAST))
