"""The benchmark of the installation opens the demo's page from the wheels, and says without them what builds them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COMMAND = [sys.executable, ROOT / "benchmarks" / "install.py", "--dist"]


@pytest.mark.slow
@pytest.mark.sim
@pytest.mark.timeout(1200)
def test_the_page_opens_from_the_wheels(tmp_path: Path) -> None:
    subprocess.run([ROOT / "scripts/dist", tmp_path], capture_output=True, timeout=200, check=True)
    done = subprocess.run([*COMMAND, tmp_path], capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout.splitlines()[-1])
    assert told["packages"] > 10
    assert told["megabytes_without_pyc_and_pip"] < told["megabytes"]
    assert told["from_nothing_to_page_s"] > told["demo_s"] > 0


def test_without_wheels_it_says_what_builds_them(tmp_path: Path) -> None:
    done = subprocess.run([*COMMAND, tmp_path], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "make dist" in done.stderr
