"""The walk-through in docs/robots/add-a-robot.md works as written; errors name a missing or broken robot."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from agentrob.language.messages.catalog import can_say
from tests import in_process

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs/robots/add-a-robot.md").read_text(encoding="utf-8")
COMMANDS = [
    line for block in re.findall(r"^```sh\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL) for line in block.splitlines()
]
LIMIT_S = 200


def run(*command: str | Path, env: Mapping[str, str], cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command, env={**os.environ, **env}, cwd=cwd, capture_output=True, text=True, timeout=LIMIT_S, check=False
    )


def program(command: str) -> list[str | Path]:
    """Return a command of the guide, with the program from the tests' environment."""
    name, *arguments = shlex.split(command)
    folder, _, what = name.rpartition("/")
    assert folder == ".venv/bin", "the guide calls programs where make puts them"
    return [Path(sys.executable).with_name(what), *arguments]


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the rover as in the guide, but into a separate folder and without a network."""
    install = program(COMMANDS[0])
    assert "install" in install
    folder = tmp_path_factory.mktemp("rover")
    done = run(*install, "--quiet", "--no-index", "--target", folder, env={})
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture
def env(installed: Path, tmp_path: Path) -> dict[str, str]:
    path = os.pathsep.join(filter(None, (os.environ.get("PYTHONPATH", ""), str(installed))))
    return {"PYTHONPATH": path, "AGENTROB_DATA": str(tmp_path)}


def test_the_rover_is_a_package_of_one_file(installed: Path) -> None:
    assert [path.name for path in installed.iterdir() if path.is_file()] == ["agentrob_rover.py"]


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(c, marks=pytest.mark.slow if "pytest" in c else ())  # the contract test runs in real time
        for c in COMMANDS[1:]
        if not c.startswith("make ")
    ],
)
def test_a_command_of_the_guide_runs(command: str, env: Mapping[str, str]) -> None:
    done = run(*program(command), env=env)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_rovers_missing_abilities_are_known_before_it_is_connected(
    installed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(installed)
    for text, rule in (("step left 1 m", "ops.direction"), ("wave", "ops.unknown")):
        done = in_process.agentrob(tmp_path, "plan", "--model", "rover", "--json", text)
        assert json.loads(done.stdout)["verdict"]["rule"] == rule


@pytest.mark.sim
@pytest.mark.slow
def test_the_rover_answers_in_the_demo_as_the_guide_starts_it(env: Mapping[str, str], tmp_path: Path) -> None:
    (make,) = [c for c in COMMANDS if c.startswith("make ")]
    given = re.fullmatch(r"make demo ARGS='(.*)'", make)
    assert given is not None
    post = ["--post", "@rover drive forward 50 cm. @humanoid turn left 20 degrees.", "--json"]
    agentrob = Path(sys.executable).with_name("agentrob")
    done = run(agentrob, "demo", *shlex.split(given[1]), "--data", tmp_path / "demo", *post, env=env, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    robots = json.loads(done.stdout.splitlines()[-1])["robots"]
    assert {name: [step["op"] for step in told["steps"]] for name, told in robots.items()} == {
        "rover": ["move"],
        "humanoid": ["turn"],
    }


# ---------------------------------------------------------------------- errors
def plug_in(folder: Path, code: str) -> dict[str, str]:
    """Install a robot `broken` with this code in a folder; return the environment in which processes find it."""
    folder.mkdir()
    (folder / "broken_robot.py").write_text(code)
    facts = folder / "broken_robot-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-robot\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[agentrob.robots]\nbroken = broken_robot:Broken\n")
    return {"PYTHONPATH": os.pathsep.join(filter(None, (os.environ.get("PYTHONPATH", ""), str(folder))))}


@pytest.mark.parametrize(
    ("code", "says"),
    [
        ("import no_such_module", "cannot be loaded from broken_robot:Broken: ModuleNotFoundError: No module named"),
        ("1 / 0", "the robot 'broken' of the package broken-robot cannot be loaded"),
        ("Broke = 1", "cannot be loaded from broken_robot:Broken: AttributeError"),
        ("class Broken: pass", "the robot 'broken' has no describe(settings)"),
    ],
)
def test_a_broken_robot_is_reported_in_one_line(
    code: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plug_in(tmp_path / "installed", code)
    monkeypatch.syspath_prepend(tmp_path / "installed")
    for command in (["drive", "broken", "walk forward 1 m"], ["demo", "--robot", "broken", "--data", str(tmp_path)]):
        monkeypatch.delitem(sys.modules, "broken_robot", raising=False)
        done = in_process.agentrob(tmp_path, *command, AGENTROB_DATA=str(tmp_path / "data"))
        assert done.returncode == 1
        assert says in done.stderr.splitlines()[-1]


def test_a_process_names_a_broken_robot_without_a_traceback(tmp_path: Path) -> None:
    agentrob = Path(sys.executable).with_name("agentrob")
    env = plug_in(tmp_path / "installed", "1 / 0")
    done = run(agentrob, "drive", "broken", "walk forward 1 m", env=env, cwd=tmp_path)
    assert done.returncode == 1
    assert "ZeroDivisionError" in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr


def test_a_missing_robot_is_answered_with_the_installed_ones(tmp_path: Path) -> None:
    for command in (["drive", "nosuch", "wave"], ["demo", "--robot", "nosuch"], ["plan", "--model", "nosuch", "wave"]):
        done = in_process.agentrob(tmp_path, *command, AGENTROB_DATA=str(tmp_path / "data"))
        assert done.returncode == 1
        assert "robot 'nosuch' is not installed; installed robots: fake, g1, go2" in done.stderr


def test_the_guide_lists_reasons_that_replies_have_sentences_for() -> None:
    listed = re.search(r"Chinese replies have a sentence for (.*?), so use", GUIDE, re.DOTALL)
    assert listed is not None
    reasons = re.findall(r"`(\w+)`", listed[1])
    assert len(reasons) > 10
    assert [reason for reason in reasons if not can_say(f"agent.reason.{reason}")] == []
