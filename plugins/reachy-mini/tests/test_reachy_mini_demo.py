"""The simulated Reachy Mini in the demo: it answers a post, and says what must be installed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from agentrob_reachy_mini.simulator import IN_CHECKOUT, VARIABLE

from agentrob.errors import SimError
from agentrob.wiring import app

AGENTROB = Path(sys.executable).with_name("agentrob")
INSTALLED = Path(__file__).parents[3] / IN_CHECKOUT


def run(folder: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [AGENTROB, *arguments], env={**os.environ, "AGENTROB_DATA": str(folder), **environment}, cwd=folder,
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip


def test_the_daemon_is_found_by_its_variable_and_otherwise_told_how_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SimError, match="reachy-mini-daemon is not installed: run scripts/reachy-mini-daemon"):
        app.simulated_robot("reachy-mini", 41)
    daemon = tmp_path / "elsewhere"
    daemon.write_text("#!/bin/sh\n")
    daemon.chmod(0o755)
    monkeypatch.setenv(VARIABLE, str(daemon))
    settings = app.simulated_robot("reachy-mini", 41)
    assert settings.options == {"url": "http://127.0.0.1:18341"}
    assert (settings.map.room, settings.simulated) == ("desk", True)


def test_the_simulation_of_the_package_needs_nothing_else(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert app.simulated_robot("reachy-mini-sim", 42).options == {"url": "http://127.0.0.1:18342"}


@pytest.mark.slow
def test_drive_moves_it_and_what_must_be_installed_is_one_line(tmp_path: Path) -> None:
    done = run(tmp_path, "drive", "reachy-mini-sim", "look up, then nod")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "✓ look up 20 degrees" in done.stdout
    assert "✓ nod" in done.stdout
    missing = run(tmp_path, "drive", "reachy-mini", "nod", PATH="/usr/bin:/bin", **{VARIABLE: ""})
    assert missing.returncode != 0
    (line,) = [line for line in missing.stderr.splitlines() if "reachy-mini-daemon is not installed" in line]
    assert "--robot reachy-mini-sim needs neither" in line


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "post", "done_word"),
    [
        ("reachy-mini", "nod, then turn left 30 degrees", "nodded"),
        ("reachy-mini-sim", "点点头，然后动动天线", "点了头"),
    ],
)
def test_it_answers_a_post_in_the_demo(tmp_path: Path, robot: str, post: str, done_word: str) -> None:
    arguments = ["demo", "--data", str(tmp_path / "demo"), "--robot", robot, "--post", f"@{robot} {post}", "--json"]
    done = run(tmp_path, *arguments, **{VARIABLE: str(INSTALLED)})
    assert done.returncode == 0, done.stdout + done.stderr
    answer = json.loads(done.stdout)
    assert answer["status"] == "done", answer
    assert done_word in answer["reply_markdown"]
