"""Choose the test files to collect: a slice of the slow ones, or those that use a marker.

Each test process imports every file that it collects, which takes 15 s of CPU for all of them.

    pytest --slice 3/12       the slow tests in the third of twelve groups of files
    pytest --files-with sim   the files that use the marker `sim`

`.ci/run` runs one slice for each commit, chosen by the commit's hash, so that over commits all are run;
`make test-long` runs all of them. A file is in one slice. Slices take about the same time, by `durations.toml`.

    python -m tests.slices 3/12      print the files of a slice and the command that runs it
"""

from __future__ import annotations

import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
#: The tables of `durations.toml`, and the seconds assumed for a file that they do not list.
SLOW, FAST = "slow", "fast"
DEFAULT_S, FAST_DEFAULT_S = 30.0, 5.0
#: The files of the collected tests that have a marker, by marker.
MARKED_FILES = pytest.StashKey[dict[str, set[str]]]()


def durations(table: str = SLOW) -> dict[str, float]:
    """Return for each file the seconds that its slow tests take in one process at their CI size, or its other tests."""
    return dict(tomllib.loads((Path(__file__).parent / "durations.toml").read_text(encoding="utf-8"))[table])


def has_marker(path: Path, marker: str) -> bool:
    """Return whether a test file uses this marker, or the fixture `database`, whose PostgreSQL is slow."""
    text = path.read_text(encoding="utf-8")
    return f"mark.{marker}" in text or (marker == "slow" and 'usefixtures("database")' in text)


@cache
def files_with(marker: str) -> tuple[str, ...]:
    """Return the test files that use this marker, relative to the repository; cached, because it reads all files."""
    files = sorted(path for folder in ("tests", "plugins") for path in (ROOT / folder).rglob("test_*.py"))
    return tuple(str(path.relative_to(ROOT)) for path in files if has_marker(path, marker))


def slow_files() -> list[str]:
    return list(files_with("slow"))


def split(files: list[str], count: int, seconds: dict[str, float]) -> list[list[str]]:
    """Split files into `count` slices: the longest file first, each into the shortest slice so far."""
    slices: list[list[str]] = [[] for _ in range(count)]
    total = [0.0] * count
    for file in sorted(files, key=lambda file: (-seconds.get(file, DEFAULT_S), file)):
        shortest = total.index(min(total))
        slices[shortest].append(file)
        total[shortest] += seconds.get(file, DEFAULT_S)
    return slices


def parse(text: str) -> tuple[int, int]:
    """Parse `3/12` as (3, 12). Raises `UsageError`."""
    number, _, count = text.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise pytest.UsageError(f"{text!r} is not a slice; valid: NUMBER/COUNT, as 3/12")
    return int(number), int(count)


@cache
def files_of(text: str) -> list[str]:
    """Return the files of a slice such as `3/12`."""
    number, count = parse(text)
    return sorted(split(slow_files(), count, durations())[number - 1])


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slice", metavar="NUMBER/COUNT", help="run only the slow tests of this slice, as 3/12")
    parser.addoption("--files-with", metavar="MARKER", help="collect only the files that use this marker")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Collect only files of the slice or with the marker; pytest collects a file named on the command line anyway."""
    if not collection_path.match("test_*.py"):
        return None
    if (marker := config.getoption("--files-with")) and not has_marker(collection_path, marker):
        return True
    if (text := config.getoption("--slice")) and str(collection_path.relative_to(ROOT)) not in files_of(text):
        return True
    return None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    marked: dict[str, dict[pytest.Item, str]] = {
        marker: {item: str(item.path.relative_to(ROOT)) for item in items if item.get_closest_marker(marker)}
        for marker in ("slow", "sim")
    }
    config.stash[MARKED_FILES] = {marker: set(files.values()) for marker, files in marked.items()}
    slow = marked["slow"]
    if text := config.getoption("--slice"):
        chosen = set(files_of(text))
        config.hook.pytest_deselected(items=[item for item in items if slow.get(item) not in chosen])
        items[:] = [item for item in items if slow.get(item) in chosen]
    # Start the longest files first; otherwise one process would still run the last one when the others have finished.
    seconds = durations(FAST)
    items.sort(key=lambda item: -seconds.get(str(item.path.relative_to(ROOT)), FAST_DEFAULT_S))


def main() -> None:
    (text,) = sys.argv[1:]
    files, seconds = files_of(text), durations()
    expected_s = sum(seconds.get(file, DEFAULT_S) for file in files)
    print(f"slice {text} of the slow tests, about {expected_s:.0f} s in one process:")  # noqa: T201
    for file in files:
        print(f"  {file}")  # noqa: T201
    print(f"again: make test-slice SLICE={text}")  # noqa: T201


if __name__ == "__main__":
    main()
