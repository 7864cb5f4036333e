"""`agentrob demo --mind`: the models of a configuration read posts in the demo, also at its next start."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from agentrob.config.load import load
from tests.demo.running import AGENTROB

pytestmark = pytest.mark.sim
MIND = """
[minds.clever]
provider = "compatible"
model = "some-model"
base_url = "http://127.0.0.1:9/v1"
"""


def demo(data: Path, folder: Path, *args: str) -> subprocess.CompletedProcess[str]:
    folder.mkdir(exist_ok=True)
    command = [AGENTROB, "demo", "--post", "@quadruped help", "--data", str(data), *args]
    env = {**os.environ, "AGENTROB_DATA": str(data.parent)}
    return subprocess.run(command, capture_output=True, text=True, timeout=100, check=False, cwd=folder, env=env)


def test_a_mind_that_is_chosen_once_is_kept_by_the_next_starts(tmp_path: Path) -> None:
    data, with_minds, without = tmp_path / "demo", tmp_path / "a", tmp_path / "b"
    with_minds.mkdir()
    (with_minds / "agentrob.toml").write_text(MIND)
    unknown = demo(data, with_minds, "--mind", "cleverer")
    assert unknown.returncode == 1
    assert "unknown mind 'cleverer'; valid: rules" in unknown.stderr
    assert "clever" in unknown.stderr.rpartition(":")[2]
    assert "I can" in demo(data, with_minds, "--mind", "clever").stdout
    demo(data, without)
    kept = load(data / "agentrob.toml")
    assert {robot.mind for robot in kept.robots.values()} == {"clever"}
    assert kept.minds["clever"].base_url == "http://127.0.0.1:9/v1"
    (data / "agentrob.toml").write_text("broken [")
    started = demo(data, without)
    assert "is not valid TOML" in started.stderr
    assert (data / "agentrob.toml.broken").read_text() == "broken ["
    assert {robot.mind for robot in load(data / "agentrob.toml").robots.values()} == {"rules"}
