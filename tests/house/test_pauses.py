"""A test with a simulated world runs again if the machine was paused, and only then."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

CONFTEST = """
from tests.pauses import pytest_itemcollected, pytest_runtest_call, pytest_runtest_setup
"""
#: SIGSTOP pauses the test process, as a host pauses a virtual machine.
TESTS = """
import subprocess
import pytest

runs = []

def pause():
    subprocess.run(["sh", "-c", "kill -STOP $PPID; sleep 0.6; kill -CONT $PPID"], check=True)

@pytest.mark.sim
def test_fails_once_while_paused():
    runs.append("paused")
    if runs.count("paused") == 1:
        pause()
        raise AssertionError("no robot")

@pytest.mark.sim
def test_fails():
    runs.append("failed")
    assert runs.count("failed") > 1

@pytest.mark.sim
def test_succeeds_while_paused():
    pause()

def test_fails_while_paused_without_a_world():
    pause()
    raise AssertionError("no world")
"""


def test_only_a_failure_while_the_machine_was_paused_is_run_again(tmp_path: Path) -> None:
    (tmp_path / "conftest.py").write_text(CONFTEST, encoding="utf-8")
    (tmp_path / "test_worlds.py").write_text(TESTS, encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = sim\n", encoding="utf-8")
    environment = {"PYTHONPATH": str(Path(__file__).parents[2]), "PATH": "/usr/bin:/bin"}
    command = [sys.executable, "-m", "pytest", "-v", "--color=no", "-p", "no:cacheprovider", str(tmp_path)]
    ran = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=100, check=False
    )
    outcomes = [
        line.split("::")[1].split()[:2] for line in ran.stdout.splitlines() if line.startswith("test_worlds.py::")
    ]
    assert outcomes == [
        ["test_fails_once_while_paused", "RERUN"],
        ["test_fails_once_while_paused", "PASSED"],
        ["test_fails", "FAILED"],
        ["test_succeeds_while_paused", "PASSED"],
        ["test_fails_while_paused_without_a_world", "FAILED"],
    ], ran.stdout
