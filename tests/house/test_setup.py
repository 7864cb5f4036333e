"""`scripts/setup` prints short progress, writes pip's output to a log, and shows that only if it fails."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PYTHON = """#!/bin/sh
case "$*" in
    "-m pip --version") echo pip 25 ;;
    "-m pip install"*) echo "WARNING: Location 'file:///nowhere' is ignored" >&2; echo "Collecting a==1"; {ending} ;;
esac
"""


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Create a checkout with a lock of two packages and a virtual environment whose pip only prints."""
    (tmp_path / "scripts").mkdir()
    (tmp_path / ".venv/bin").mkdir(parents=True)
    shutil.copy(ROOT / "scripts/setup", tmp_path / "scripts/setup")
    (tmp_path / "requirements.lock").write_text("a==1 --hash=sha256:0\nb-c==2 \\\n    --hash=sha256:0\n")
    (tmp_path / "pyproject.toml").touch()
    return tmp_path


def set_up(checkout: Path, ending: str) -> subprocess.CompletedProcess[str]:
    python = checkout / ".venv/bin/python"
    python.write_text(PYTHON.format(ending=ending))
    python.chmod(0o755)
    return subprocess.run(
        ["scripts/setup", "requirements.lock"], cwd=checkout, capture_output=True, text=True, timeout=100, check=False
    )


def test_a_successful_setup_prints_one_line_and_the_next_one_nothing(checkout: Path) -> None:
    first = set_up(checkout, "exit 0")
    assert first.returncode == 0
    assert first.stdout == "setup: installing 2 packages (about a minute the first time)\n"
    assert first.stderr == ""
    again = set_up(checkout, "exit 0")
    assert (again.returncode, again.stdout, again.stderr) == (0, "", "")


def test_a_failed_setup_shows_pips_output_and_is_repeated(checkout: Path) -> None:
    failed = set_up(checkout, "echo 'ERROR: no space left' >&2; exit 1")
    assert failed.returncode == 1
    assert "setup: pip could not install the packages" in failed.stderr
    assert "ERROR: no space left" in failed.stderr
    assert set_up(checkout, "exit 0").returncode == 0
