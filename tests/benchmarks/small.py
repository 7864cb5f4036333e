"""Run a benchmark with a small load."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

#: The arguments of a small run, by benchmark.
SMALL = {
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
    "remote_driver.py": ["--trials", "3", "--hold", "3", "--cuts", "1", "--link", "2"],
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

#: Benchmarks that only read sentences, without a robot or a world.
READING = ("left_out_templates.py", "minds.py", "understanding.py", "understanding_time.py")


def run(name: str) -> str:
    """Return what a benchmark prints; `AssertionError` if it fails."""
    done = subprocess.run(
        [sys.executable, ROOT / "benchmarks" / name, *SMALL[name]],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=580,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
