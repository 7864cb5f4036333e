"""Measure whether the tests of the safety rooms notice defects: change one place of the code, run its tests, repeat.

    python benchmarks/mutants.py [src/agentrob/robots/safety/guard.py ...] [--sample 50 --seed 1] [--jobs 2] [--json]

Without files these are all files of the rooms in `TESTS`, which names the test files of each.
`instruments/mutations.py` makes the changes. A first run without a change records which test executes which line; then
each mutant is tested only by the tests that execute its statement, the fast files first, until one fails. A mutant of a
statement that runs when the module is imported, such as that of a constant, is tested by all tests of the room. Mutants
are written into a copy of the package in a temporary folder. Each one has a process of its own, forked after the tests'
libraries were imported.

A mutant is killed if a test fails, and timed out if a test takes much longer than without it. One that survives is
equivalent to the code, or shows a missing test, or code that nothing needs. Slow tests, and those that need the
simulated world in real time, are left out; what only they execute survives.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import multiprocessing
import os
import random
import shutil
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from instruments.mutations import Mutant, mutants_of

ROOT = Path(__file__).parents[1]
_STORE = (
    "rows",
    "records",
    "contract",
    "schedules",
    "journal",
    "same_on_both",
    "retention",
    "transactions",
    "versions",
)
#: The test files of each room or file.
TESTS = {
    "src/agentrob/robots/safety": ("tests/robots/safety",),
    "src/agentrob/robots/safety/guard.py": (
        "tests/robots/safety",
        "tests/robots/driver/test_restart.py",
        "tests/robots/driver/test_room.py",
    ),
    "src/agentrob/robots/safety/crash_marker.py": ("tests/robots/safety", "tests/robots/driver/test_restart.py"),
    "src/agentrob/screening": ("tests/screening",),
    "src/agentrob/agent/store": tuple(f"tests/agent/store/test_{name}.py" for name in _STORE),
    "src/agentrob/agent/store/session_locks.py": ("tests/agent/store/test_session_locks.py",),
}
#: Modules that hold no rule.
WITHOUT = ("__init__.py", "en.py", "zh.py")
#: A test may take this long with a mutant: so many times what it takes without, and so many seconds more.
TIMES, MORE_S = 4.0, 30.0
#: Tests that take less than this are fast, those beyond the last one slow.
PACES_S = (0.2, 1.0)
SELECTED = "not slow and not sim"


@dataclass
class Baseline:
    """The result of a file's tests without a change."""

    lines: dict[str, set[int]] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    #: The longest set-up of a test in each file: that of the fixtures which its tests share.
    setup_s: dict[str, float] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)
    modules: list[str] = field(default_factory=list)

    def tests_of(self, mutant: Mutant) -> list[str]:
        """The tests that execute the statement of a mutant, all tests if none was seen to; the fast ones first, and
        otherwise those of a file together, since they share fixtures."""
        lines = set(mutant.lines)
        tests = [test for test in self.seconds if lines & self.lines[test]] or list(self.seconds)
        file_s = dict.fromkeys(map(_file, tests), 0.0)
        for test in tests:
            file_s[_file(test)] += self.seconds[test]
        return sorted(tests, key=lambda test: (self._pace(test), file_s[_file(test)], _file(test), self.seconds[test]))

    def leave_out(self, longest_s: float) -> None:
        """Leave out tests that take longer than this."""
        self.seconds = {test: s for test, s in self.seconds.items() if s <= longest_s}

    def limit_s(self, test: str) -> float:
        """How long a test may take with a mutant. Any test may be the first of its file."""
        return MORE_S + TIMES * (self.seconds[test] + self.setup_s[_file(test)])

    def _pace(self, test: str) -> int:
        return sum(self.seconds[test] > limit_s for limit_s in PACES_S)


@dataclass
class Result:
    file: str
    line: int
    change: str
    result: str
    test: str = ""


def _file(test: str) -> str:
    return test.partition("::")[0]


class LineRecorder:
    """A pytest plugin that notes which test executes which lines of a file, and how long each test takes."""

    def __init__(self, path: Path) -> None:
        self._path, self.baseline = str(path), Baseline()
        self._lines: set[int] = set()

    def _trace(self, frame: FrameType, _event: str, _value: object) -> Callable[..., Any] | None:
        return self._trace_line if frame.f_code.co_filename == self._path else None

    def _trace_line(self, frame: FrameType, _event: str, _value: object) -> Callable[..., Any]:
        self._lines.add(frame.f_lineno)
        return self._trace_line

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self._lines.clear()
        threading.settrace(self._trace)
        sys.settrace(self._trace)
        begun_s = time.monotonic()
        try:
            return (yield)
        finally:
            sys.settrace(None)
            threading.settrace(None)
            self.baseline.lines[item.nodeid] = set(self._lines)
            self.baseline.seconds[item.nodeid] = time.monotonic() - begun_s

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.baseline.failed.append(report.nodeid)
        if report.when == "setup":
            file = _file(report.nodeid)
            self.baseline.setup_s[file] = max(report.duration, self.baseline.setup_s.get(file, 0.0))

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.baseline.failed.append(report.nodeid)


class ChosenTests:
    """A pytest plugin that runs these tests in this order, each under its limit, and notes which one failed."""

    def __init__(self, limits_s: dict[str, float]) -> None:
        self._limits_s = limits_s
        self.failed = ("", False)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        chosen = {item.nodeid: item for item in items if item.nodeid in self._limits_s}
        items[:] = [chosen[test] for test in self._limits_s if test in chosen]
        for item in items:
            item.add_marker(pytest.mark.timeout(self._limits_s[item.nodeid]), append=False)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.failed[0]:
            self.failed = (report.nodeid, "Timeout (>" in report.longreprtext)


class Workplace:
    """A copy of the package, in which one mutant at a time takes the place of its file."""

    def __init__(self, root: Path, file: str, folder: Path) -> None:
        self.root, self.folder = root, folder
        shutil.copytree(root / "src", folder / "src")
        self.path = folder / Path(file)

    def put(self, source: str) -> None:
        """Write this in the place of the file."""
        for compiled in self.path.parent.glob(f"__pycache__/{self.path.stem}.*"):
            compiled.unlink()
        self.path.write_text(source, encoding="utf-8")

    def test(self, arguments: Iterable[str], plugin: object) -> int:
        """Run tests of the project with this copy; in a process of its own."""
        os.setsid()
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        log = os.open(self.folder / "tests.log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        for stream in (1, 2):
            os.dup2(log, stream)
        os.chdir(self.root)
        os.environ["PYTHONPATH"] = str(self.folder / "src")
        os.environ["HYPOTHESIS_STORAGE_DIRECTORY"] = str(self.folder / "hypothesis")
        sys.path.insert(0, str(self.folder / "src"))
        options = [
            "-q",
            "-x",
            "-p",
            "no:cacheprovider",
            "--hypothesis-seed=0",
            "-m",
            SELECTED,
            "--rootdir",
            str(self.root),
        ]
        return pytest.main([*options, *arguments], plugins=[plugin])


def measure_baseline(workplace: Workplace, tests: Iterable[str]) -> Baseline:
    receiving, sending = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=_record, args=(workplace, tuple(tests), sending))
    child.start()
    sending.close()
    try:
        found = receiving.recv()
    except EOFError:
        found = None
    child.join()
    if not isinstance(found, Baseline) or found.failed or not found.seconds:
        log = (workplace.folder / "tests.log").read_text(encoding="utf-8", errors="replace")
        raise SystemExit(f"The tests fail without a change:\n{log[-3000:]}")
    return found


def _record(workplace: Workplace, tests: tuple[str, ...], sending: Connection) -> None:
    recorder = LineRecorder(workplace.path)
    workplace.test(tests, recorder)
    own = {path.stem for path in (workplace.root / "src").iterdir()} | {"tests", "__main__", "__mp_main__"}
    recorder.baseline.modules = [name for name in sys.modules if name.partition(".")[0] not in own]
    sending.send(recorder.baseline)


@dataclass
class Running:
    """A mutant whose tests run."""

    mutant: Mutant
    place: Workplace
    child: Any
    receiving: Connection
    until_s: float


def _meet(workplace: Workplace, limits_s: dict[str, float], sending: Connection) -> None:
    chosen = ChosenTests(limits_s)
    code = workplace.test(dict.fromkeys(map(_file, limits_s)), chosen)
    sending.send((int(code), *chosen.failed))


def start(mutant: Mutant, place: Workplace, baseline: Baseline) -> Running:
    place.put(mutant.source)
    limits_s = {test: baseline.limit_s(test) for test in baseline.tests_of(mutant)}
    receiving, sending = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=_meet, args=(place, limits_s, sending))
    child.start()
    sending.close()
    until_s = time.monotonic() + 60.0 + sum(limits_s.values())
    return Running(mutant, place, child, receiving, until_s)


def end(running: Running, file: str) -> Result:
    """Wait for the end of the tests, at most until the limit, and end what they left."""
    running.child.join(max(0.0, running.until_s - time.monotonic()))
    word, test = "timed out", ""
    if running.child.exitcode is not None:
        try:
            code, test, late = running.receiving.recv()
            word = "survived" if code == pytest.ExitCode.OK else "timed out" if late else "killed"
        except EOFError:
            word = "killed"  # it ended the process of the tests
    kill(running)
    return Result(file, running.mutant.line, running.mutant.change, word, test)


def kill(running: Running) -> None:
    """End the process of the tests and those that they started."""
    with suppress(ProcessLookupError):
        os.killpg(running.child.pid, signal.SIGKILL)
    running.child.join()


def measure(root: Path, file: str, tests: Iterable[str], options: argparse.Namespace) -> list[Result]:
    """Run the tests against the mutants of a file."""
    first, last = options.lines
    mutants = [m for m in mutants_of((root / file).read_text(encoding="utf-8")) if first <= m.line <= last]
    if options.sample and options.sample < len(mutants):
        chosen = random.Random(options.seed).sample(range(len(mutants)), options.sample)
        mutants = [mutants[n] for n in sorted(chosen)]
    results = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        places = [Workplace(root, file, Path(folder) / str(n)) for n in range(options.jobs)]
        baseline = measure_baseline(places[0], tests)
        baseline.leave_out(options.longest)
        _import(baseline.modules)
        waiting, free, running = list(reversed(mutants)), list(places), dict[int, Running]()
        try:
            while waiting or running:
                while waiting and free:
                    begun = start(waiting.pop(), free.pop(), baseline)
                    running[begun.child.sentinel] = begun
                first_s = min(each.until_s for each in running.values()) - time.monotonic()
                late = min(running, key=lambda key: running[key].until_s)
                for key in wait(list(running), max(0.0, first_s)) or [late]:
                    done = running.pop(int(key))
                    results.append(end(done, file))
                    free.append(done.place)
                    if options.verbose:
                        print(json.dumps(asdict(results[-1])), file=sys.stderr, flush=True)
        finally:
            for left in running.values():
                kill(left)
    return sorted(results, key=lambda result: result.line)


def _import(modules: Iterable[str]) -> None:
    """Import the libraries of the tests once, for all processes that are forked from now on."""
    for name in modules:
        with suppress(ImportError):  # some are made by another module, or by a test
            importlib.import_module(name)


def tests_for(file: str, given: list[str]) -> tuple[str, ...]:
    if given:
        return tuple(given)
    rooms = [room for room in TESTS if file.startswith(room)]
    if not rooms:
        raise SystemExit(f"{file} has no tests here; valid: --tests, or a file in {', '.join(TESTS)}")
    return TESTS[max(rooms, key=len)]


def all_files(root: Path) -> list[str]:
    found = (path for room in TESTS for path in sorted((root / room).rglob("*.py")))  # nothing in a room that is a file
    return [str(path.relative_to(root)) for path in found if path.name not in WITHOUT]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("files", nargs="*", help="files of the project, relative to its root")
    parser.add_argument("--tests", action="append", default=[], help="test file or folder instead of the table's")
    parser.add_argument("--root", type=Path, default=ROOT, help="the project; its packages are in src")
    parser.add_argument("--sample", type=int, default=0, help="so many mutants of each file, chosen at random")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--lines", type=int, nargs=2, default=(1, sys.maxsize), metavar=("FIRST", "LAST"), help="only these lines"
    )
    parser.add_argument("--longest", type=float, default=math.inf, help="leave out tests that take longer, in seconds")
    parser.add_argument("--jobs", type=int, default=1, help="so many mutants at a time")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--verbose", action="store_true", help="print each result to standard error")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by a signal"))
    root = options.root.resolve()
    sys.path.insert(0, str(root))
    results: list[Result] = []
    for file in options.files or all_files(root):
        begun_s = time.monotonic()
        found = measure(root, file, tests_for(file, options.tests), options)
        results += found
        if not options.json:
            counts = Counter(result.result for result in found)
            words = ", ".join(f"{counts[word]} {word}" for word in ("killed", "timed out", "survived"))
            print(f"{file}: {len(found)} mutants, {words}; {time.monotonic() - begun_s:.0f} s", flush=True)
            for result in found:
                if result.result == "survived":
                    print(f"  {file}:{result.line}: {result.change}", flush=True)
    if options.json:
        print(json.dumps([asdict(result) for result in results], indent=1))


if __name__ == "__main__":
    main()
