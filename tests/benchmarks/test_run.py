"""Every benchmark runs with a small load; figures are asserted only where physics determines them."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from tests.benchmarks.small import READING, ROOT, SMALL, run

pytestmark = [pytest.mark.slow, pytest.mark.sim, pytest.mark.timeout(600)]

#: Benchmarks with their own test file.
ELSEWHERE = {"install.py": "test_install.py", "mutants.py": "test_mutants.py", "stop.py": "test_stop.py"}
#: Benchmarks with their own test below.
ASSERTED = ("accuracy.py", "crossing.py", "stop_body.py")


def test_each_benchmark_is_tested() -> None:
    assert {path.name for path in (ROOT / "benchmarks").glob("*.py")} == set(SMALL) | set(ELSEWHERE)
    for name, test in ELSEWHERE.items():
        assert f'"{name}"' in (Path(__file__).parent / test).read_text()


@pytest.mark.parametrize("name", sorted(set(SMALL) - {*READING, *ASSERTED}))
def test_a_benchmark_runs_and_prints_figures(name: str) -> None:
    printed = run(name)
    sys.stdout.write(printed)
    assert re.search(r"\d", printed) or "absent" in printed or "not there" in printed


def test_moves_and_turns_are_accurate_against_the_true_pose() -> None:
    printed = run("accuracy.py")
    sys.stdout.write(printed)
    share = re.search(r"([\d.]+) % of (\d+) within 5 cm and 4°", printed)
    assert share is not None
    assert int(share[2]) >= 80
    assert float(share[1]) >= 95


def test_robots_whose_paths_cross_in_one_room_never_touch_and_none_is_stuck() -> None:
    printed = run("crossing.py")
    sys.stdout.write(printed)
    for line in ("3 runs of crossing paths, with zones", "runs with a contact between the robots: 0", "stuck: 0"):
        assert line in printed
    assert "commands: done" in printed
    assert "runs in which one waited for the other: 3" in printed


def test_the_bodies_stop_within_the_goal() -> None:
    printed = run("stop_body.py")
    assert printed.count("  yes") == 7, printed
