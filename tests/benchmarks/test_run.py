"""Every benchmark runs with a small load; figures are asserted only where physics determines them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = [pytest.mark.slow, pytest.mark.sim, pytest.mark.timeout(600)]

LITTLE = {
    "accuracy.py": ["--runs", "6", "--seed", "23"],
    "board.py": ["--seconds", "1", "--listeners", "20"],
    "board_search.py": ["--posts", "2000", "--trials", "3", "--vectors", "2000"],
    "crossing.py": ["--runs", "3", "--seed", "3"],
    "demo_start.py": ["1"],
    "eyes.py": ["--places", "3"],
    "fleet.py": ["--robots", "4", "--commands", "20", "--rate", "2", "--kills", "2", "--no-times"],
    "growth.py": ["--commands", "6", "--every", "3"],
    "latency.py": ["--posts", "100"],
    "left_out_templates.py": ["tests/language/later_first_sight.jsonl"],
    "live_view.py": ["--viewers", "3", "--seconds", "2", "--trials", "2"],
    "loop.py": ["--turns", "12"],
    "mcp.py": ["--calls", "5", "--starts", "1"],
    "minds.py": ["--turns", "12"],
    "remote_driver.py": ["--trials", "3", "--hold", "3", "--cuts", "1"],
    "reachy_mini.py": ["--runs", "1", "--trials", "3"],
    "rehearsal.py": ["--trials", "2"],
    "ros2.py": ["--runs", "1", "--trials", "3"],
    "rpc.py": ["--calls", "50", "--walks", "1"],
    "so101.py": ["--trials", "3", "--cubes", "1", "--runs", "1"],
    "stop_body.py": ["--only", "body", "--runs", "3"],
    "stop_http.py": ["--trials", "2"],
    "understanding.py": [],
    "understanding_time.py": ["--runs", "1"],
    "world.py": ["--seconds", "3"],
}
#: Benchmarks with their own test file.
ELSEWHERE = {"install.py": "test_install.py", "mutants.py": "test_mutants.py", "stop.py": "test_stop.py"}


def benchmark(name: str) -> str:
    done = subprocess.run(
        [sys.executable, ROOT / "benchmarks" / name, *LITTLE[name]],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=580,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_each_benchmark_is_tested() -> None:
    assert {path.name for path in (ROOT / "benchmarks").glob("*.py")} == set(LITTLE) | set(ELSEWHERE)
    for name, test in ELSEWHERE.items():
        assert f'"{name}"' in (Path(__file__).parent / test).read_text()


@pytest.mark.parametrize("name", sorted(set(LITTLE) - {"accuracy.py", "crossing.py"}))
def test_a_benchmark_runs_and_prints_figures(name: str) -> None:
    said = benchmark(name)
    sys.stdout.write(said)
    assert re.search(r"\d", said) or "absent" in said or "not there" in said


def test_moves_and_turns_are_accurate_against_the_true_pose() -> None:
    said = benchmark("accuracy.py")
    sys.stdout.write(said)
    share = re.search(r"([\d.]+) % of (\d+) within 5 cm and 4°", said)
    assert share is not None
    assert int(share[2]) >= 80
    assert float(share[1]) >= 95


def test_robots_whose_paths_cross_in_one_room_never_touch_and_none_is_stuck() -> None:
    said = benchmark("crossing.py")
    sys.stdout.write(said)
    for line in ("3 runs of crossing paths, with zones", "runs with a contact between the robots: 0", "stuck: 0"):
        assert line in said
    assert "commands: done" in said
    assert "runs in which one waited for the other: 3" in said


def test_the_bodies_stop_within_the_goal() -> None:
    printed = benchmark("stop_body.py")
    assert printed.count("  yes") == 7, printed
