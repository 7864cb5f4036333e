"""`make test` gives workers whole files: each test once, few worlds at a time, and the longest files first."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from tests.file_scheduler import LOW, WORLDS, FileScheduler, file_of
from tests.slices import FAST, ROOT, durations

#: Three tests a file; those of `world_*` need a world.
FILES = [*(f"world_{n}.py" for n in range(5)), *(f"file_{n}.py" for n in range(9))]
TESTS = [f"{file}::test_{n}" for file in FILES for n in range(3)]


class FakeWorker:
    """Runs its tests in order when it is told to; as a real one, the last one only after it was told to end."""

    def __init__(self) -> None:
        self.waiting: list[int] = []
        self.shutting_down = False

    def send_runtest_some(self, indices: Sequence[int]) -> None:
        assert not self.shutting_down
        self.waiting += indices

    def shutdown(self) -> None:
        self.shutting_down = True

    def next(self) -> int | None:
        return self.waiting.pop(0) if len(self.waiting) > 1 or (self.waiting and self.shutting_down) else None


def begun(workers: int, seconds: dict[str, float] | None = None) -> tuple[FileScheduler, list[FakeWorker]]:
    scheduler = FileScheduler(workers, lambda file: file.startswith("world"), seconds or {})
    nodes = [FakeWorker() for _ in range(workers)]
    for node in nodes:
        scheduler.add_node(node)
        assert not scheduler.collection_is_completed
        scheduler.add_node_collection(node, TESTS)
    assert scheduler.collection_is_completed
    scheduler.schedule()
    return scheduler, nodes


def run(scheduler: FileScheduler, nodes: Sequence[FakeWorker]) -> list[str]:
    """Let all workers run one test after the other; return the tests in the order in which they ran."""
    ran: list[str] = []
    while True:
        found = [(node, test) for node in nodes if (test := node.next()) is not None]
        for node, test in found:
            ran.append(TESTS[test])
            scheduler.mark_test_complete(node, test)
        if scheduler.tests_finished:
            for node in nodes:
                node.shutdown()
        if not found and not any(node.waiting for node in nodes):
            return ran
        assert found or scheduler.tests_finished, "no worker can go on"


@pytest.mark.parametrize("workers", [1, 2, 4, 30])
def test_each_test_runs_once_and_the_run_ends(workers: int) -> None:
    scheduler, nodes = begun(workers)
    assert sorted(run(scheduler, nodes)) == sorted(TESTS)
    assert not scheduler.has_pending


def test_a_file_is_not_split() -> None:
    _, nodes = begun(4)
    for node in nodes:
        files = [file_of(TESTS[test]) for test in node.waiting]
        assert all(files.count(file) == 3 for file in files)


def test_few_workers_have_worlds_at_a_time_and_the_others_have_other_files() -> None:
    scheduler, nodes = begun(4)
    while scheduler.has_pending and not scheduler.tests_finished:
        with_worlds = [node for node in nodes if any(TESTS[test].startswith("world") for test in node.waiting)]
        assert len(with_worlds) <= WORLDS
        for node in nodes:
            if (test := node.next()) is not None:
                scheduler.mark_test_complete(node, test)


def test_worlds_and_the_longest_files_begin_first() -> None:
    _, nodes = begun(4, {"world_3.py": 90, "file_7.py": 60, "file_2.py": 30})
    assert [file_of(TESTS[node.waiting[0]]) for node in nodes] == ["world_3.py", "world_0.py", "file_7.py", "file_2.py"]


def test_what_a_crashed_worker_had_left_runs_on_others_and_the_crash_is_reported() -> None:
    scheduler, nodes = begun(3)
    crashed = nodes.pop(0)
    assert scheduler.remove_node(crashed) == TESTS[crashed.waiting[0]]
    new = FakeWorker()
    scheduler.add_node(new)
    scheduler.add_node_collection(new, TESTS)
    scheduler.schedule()
    assert sorted([TESTS[crashed.waiting[0]], *run(scheduler, [*nodes, new])]) == sorted(TESTS)


def test_a_worker_that_ended_well_reports_no_crash() -> None:
    scheduler, nodes = begun(2)
    run(scheduler, nodes)
    assert scheduler.remove_node(nodes[0]) is None


def test_workers_that_collected_different_tests_are_an_error() -> None:
    scheduler = FileScheduler(2, lambda file: False, {})
    one, other = FakeWorker(), FakeWorker()
    scheduler.add_node(one)
    scheduler.add_node(other)
    scheduler.add_node_collection(one, TESTS)
    with pytest.raises(pytest.UsageError, match=r"different tests: file_8\.py::test_2"):
        scheduler.add_node_collection(other, TESTS[:-1])


def test_a_worker_is_fed_before_it_waits() -> None:
    scheduler, (node,) = begun(1)
    scheduler.mark_test_complete(node, node.waiting.pop(0))
    assert [file_of(TESTS[test]) for test in node.waiting] == ["world_0.py"] * LOW + ["world_1.py"] * 3


def test_the_durations_name_files_that_exist() -> None:
    assert [file for file in durations(FAST) if not (ROOT / file).is_file()] == []
