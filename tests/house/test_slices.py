"""Every slow test is in exactly one slice, and all slices take about the same time."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.slices import (
    DEFAULT_S,
    FAST,
    FAST_DEFAULT_S,
    MARKED_FILES,
    ROOT,
    durations,
    files_of,
    files_with,
    parse,
    slow_files,
    split,
)

COUNT = 12
#: Seconds of one slice in one process; `.ci/run` uses two, except for tests that need a simulated world.
MOST_S = 600.0


@pytest.mark.parametrize("count", [1, 3, COUNT])
def test_every_slow_file_is_in_exactly_one_slice(count: int) -> None:
    found = [file for number in range(1, count + 1) for file in files_of(f"{number}/{count}")]
    assert sorted(found) == slow_files()
    assert len(found) > 30


@pytest.mark.parametrize("marker", ["slow", "sim"])
def test_every_marked_test_that_was_collected_is_in_a_file_with_the_marker(
    marker: str, request: pytest.FixtureRequest
) -> None:
    assert request.config.stash[MARKED_FILES][marker] <= set(files_with(marker))


def test_no_slice_takes_longer_than_the_limit() -> None:
    seconds = durations()
    totals = [sum(seconds.get(file, DEFAULT_S) for file in part) for part in split(slow_files(), COUNT, seconds)]
    assert max(totals) <= MOST_S, totals


def test_the_durations_name_files_that_exist() -> None:
    assert set(durations()) <= set(slow_files())
    assert [file for file in durations(FAST) if not (ROOT / file).is_file()] == []


def test_the_longest_files_are_collected_first() -> None:
    quick, slow = "tests/process/test_listen.py", "tests/wiring/test_drive.py"
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", quick, slow]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=100, check=True)
    files = [line.partition("::")[0] for line in done.stdout.splitlines() if "::" in line]
    assert durations(FAST)[slow] > FAST_DEFAULT_S
    assert list(dict.fromkeys(files)) == [slow, quick]


def test_a_new_file_counts_with_the_default() -> None:
    assert split(["new", "long", "short"], 2, {"long": 2 * DEFAULT_S, "short": 1.0}) == [["long"], ["new", "short"]]


@pytest.mark.parametrize("text", ["0/8", "9/8", "3", "a/b", "1/0", "-1/8"])
def test_an_invalid_slice_is_refused(text: str) -> None:
    with pytest.raises(pytest.UsageError, match=r"valid: NUMBER/COUNT"):
        parse(text)


def test_a_slice_collects_the_slow_tests_of_its_files_only() -> None:
    file = "tests/kill/test_kill_points.py"
    number = next(n for n in range(1, COUNT + 1) if file in files_of(f"{n}/{COUNT}"))

    def collected(text: str) -> list[str]:
        command = [
            sys.executable,
            "-m",
            "pytest",
            "--collect-only",
            "-q",
            "-p",
            "no:cacheprovider",
            "--slice",
            text,
            file,
        ]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=100, check=False)
        return [line for line in done.stdout.splitlines() if "::" in line]

    ours = collected(f"{number}/{COUNT}")
    assert len(ours) > 60
    assert not [line for line in ours if "[sqlite-agent, walking]" in line], "it is fast, so `make test` runs it"
    assert collected(f"{number % COUNT + 1}/{COUNT}") == []


def test_only_the_files_with_a_marker_are_collected() -> None:
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", "tests/demo"]
    done = subprocess.run(
        [*command, "--files-with", "browser"], cwd=ROOT, capture_output=True, text=True, timeout=100, check=False
    )
    files = {line.partition("::")[0] for line in done.stdout.splitlines() if "::" in line}
    assert files == {"tests/demo/test_browser.py"}
