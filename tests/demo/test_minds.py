"""`agentrob demo --mind`: the demo uses the minds of a configuration, also at its next start."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from agentrob.config.load import Config, load
from agentrob.demo.run import Demo, DemoSettings
from agentrob.errors import ConfigError
from agentrob.sim.domains import PrivateDomain
from tests.demo.running import AGENTROB

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


def written_config(data: Path, mind: str | None = None) -> Config:
    """Return the configuration that a start of the demo would write, without starting it."""
    with Demo(DemoSettings(data, mind=mind)) as demo:
        data.mkdir(exist_ok=True)
        demo._domains = {name: PrivateDomain() for name in demo.robots}
        return load(demo._write_config(8088, room_url=""))


def minds_of(config: Config) -> set[str]:
    return {robot.mind for robot in config.robots.values()}


def test_the_next_start_uses_the_mind_of_the_last_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    data, with_minds, without = tmp_path / "demo", tmp_path / "a", tmp_path / "b"
    with_minds.mkdir()
    without.mkdir()
    (with_minds / "agentrob.toml").write_text(MIND)
    monkeypatch.chdir(with_minds)
    with pytest.raises(ConfigError, match="unknown mind 'cleverer'; valid: rules, clever"):
        written_config(data, "cleverer")
    assert minds_of(written_config(data, "clever")) == {"clever"}
    monkeypatch.chdir(without)
    kept = written_config(data)
    assert minds_of(kept) == {"clever"}
    assert kept.minds["clever"].base_url == "http://127.0.0.1:9/v1"
    (data / "agentrob.toml").write_text("broken [")
    assert minds_of(written_config(data)) == {"rules"}
    assert "is not valid TOML" in capsys.readouterr().err
    assert (data / "agentrob.toml.broken").read_text() == "broken ["


def test_an_unknown_mind_is_reported_before_anything_starts(tmp_path: Path) -> None:
    unknown = demo(tmp_path / "demo", tmp_path / "a", "--mind", "cleverer")
    assert unknown.returncode == 1
    assert unknown.stderr.splitlines()[-1].endswith(
        f"unknown mind 'cleverer'; valid: rules; add [minds.NAME] to ./agentrob.toml or {tmp_path}/demo/agentrob.toml"
    )
    assert not list((tmp_path / "demo").glob("log/*"))


def test_a_mind_that_cannot_be_loaded_is_reported_before_anything_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    info = tmp_path / "broken_mind-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-mind\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[agentrob.minds]\nbroken = no_such_module:Mind\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    broken = demo(tmp_path / "demo", tmp_path / "a", "--mind", "broken")
    assert broken.returncode == 1
    assert "the mind 'broken' of the package broken-mind cannot be loaded" in broken.stderr.splitlines()[-1]
    assert not list((tmp_path / "demo").glob("log/*"))


@pytest.mark.sim
@pytest.mark.slow
def test_a_chosen_mind_is_kept_by_later_starts(tmp_path: Path) -> None:
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
