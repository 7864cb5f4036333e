"""A test with a simulated world runs again if the machine or its world was paused, and only then."""

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

class World:
    def longest_pause_s(self, since_s):
        return 0.6

@pytest.fixture
def world():
    return World()

@pytest.mark.sim
def test_fails_once_while_its_world_is_paused(world):
    runs.append("world")
    assert runs.count("world") > 1

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
    lines = (line.split("::")[-1].split() for line in ran.stdout.splitlines() if line.startswith("test_worlds.py::"))
    outcomes = [line[:2] for line in lines if line[1:] and line[1] in {"PASSED", "FAILED", "RERUN"}]
    assert outcomes == [
        ["test_fails_once_while_paused", "RERUN"],
        ["test_fails_once_while_paused", "PASSED"],
        ["test_fails_once_while_its_world_is_paused", "RERUN"],
        ["test_fails_once_while_its_world_is_paused", "PASSED"],
        ["test_fails", "FAILED"],
        ["test_succeeds_while_paused", "PASSED"],
        ["test_fails_while_paused_without_a_world", "FAILED"],
    ], ran.stdout
    assert "test_fails_once_while_its_world_is_paused failed while it was paused: longest pause of" in ran.stdout
    assert ran.stdout.count("processors: user ") == 3, "of two that ran again, and of the one that failed"
