"""The walk-through in docs/forum/add-a-forum.md works as written, with a driver and an agent as processes."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs/forum/add-a-forum.md").read_text(encoding="utf-8")
INSTALL, SIGN_UP, DRIVER, AGENT, ASK, CONTRACT = [
    line for block in re.findall(r"^```sh\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL) for line in block.splitlines()
]
LIMIT_S = 100


def program(line: str) -> tuple[list[str | Path], dict[str, str]]:
    """Return a command of the guide, with the program from the tests' environment, and the variables that it sets."""
    words = shlex.split(line.removesuffix("&"))
    sets = dict(w.split("=", 1) for w in words if re.match(r"[A-Z_]+=", w))
    name, *arguments = words[len(sets) :]
    folder, _, what = name.rpartition("/")
    assert folder == ".venv/bin", "the guide calls programs where make puts them"
    return [Path(sys.executable).with_name(what), *arguments], sets


def run(line: str, env: Mapping[str, str], cwd: Path) -> subprocess.CompletedProcess[str]:
    command, sets = program(line)
    return subprocess.run(
        command,
        env={**os.environ, **env, **sets},
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )


def start(line: str, env: Mapping[str, str], cwd: Path) -> subprocess.Popen[str]:
    """Start a command that keeps running; return when it reports that it is ready."""
    command, sets = program(line)
    process = subprocess.Popen(
        command,
        env={**os.environ, **env, **sets},
        cwd=cwd,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert process.stdout is not None
    for said in process.stdout:
        if said.startswith("{") and json.loads(said).get("ready"):
            return process
    raise AssertionError(f"{line} did not start")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the notebook as in the guide, but into a separate folder and without a network."""
    folder = tmp_path_factory.mktemp("notebook")
    done = run(f"{INSTALL} --quiet --no-index --target {folder}", {}, ROOT)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture
def env(installed: Path, tmp_path: Path) -> dict[str, str]:
    source = os.environ.get("PYTHONPATH", "")
    absolute = [str((ROOT / part).resolve()) for part in source.split(os.pathsep) if part]
    (runtime := tmp_path / "r").mkdir()
    return {
        "PYTHONPATH": os.pathsep.join([*absolute, str(installed)]),
        "AGENTROB_DATA": str(tmp_path / "data"),
        "AGENTROB_RUNTIME": str(runtime),
    }


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the folder in which the commands run, with its own `var/notebook` and its own host lock for the robot."""
    (tmp_path / "examples").mkdir()
    shutil.copytree(ROOT / "examples/notebook", tmp_path / "examples/notebook")
    settings = tmp_path / "examples/notebook/agentrob.toml"
    domain = os.environ.get("AGENTROB_TEST_DOMAIN", "0")
    settings.write_text(settings.read_text() + f"domain = {domain}\n")
    return tmp_path


@pytest.fixture
def processes() -> Iterator[list[subprocess.Popen[str]]]:
    found: list[subprocess.Popen[str]] = []
    yield found
    for process in reversed(found):
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LIMIT_S)


def test_the_notebook_is_a_package_of_one_file(installed: Path) -> None:
    assert [path.name for path in installed.iterdir() if path.is_file()] == ["agentrob_notebook.py"]


def test_a_robot_answers_on_a_third_party_forum(
    env: Mapping[str, str], folder: Path, processes: list[subprocess.Popen[str]]
) -> None:
    assert run(SIGN_UP, env, folder).stdout == "quadruped is in var/notebook\n"
    processes.append(start(DRIVER, env, folder))
    processes.append(start(AGENT, env, folder))
    done = run(ASK, env, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "turn left 30" in done.stdout


def test_the_notebook_fulfils_the_contract_as_in_the_guide(env: Mapping[str, str]) -> None:
    done = run(f"{CONTRACT} -p no:cacheprovider", env, ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_missing_forum_is_answered_with_the_installed_ones(folder: Path, tmp_path: Path) -> None:
    settings = folder / "other.toml"
    settings.write_text('[forum]\nkind = "nosuch"\n\n[robots.quadruped]\nmodel = "fake"\n')
    command = ".venv/bin/agentrob agent once --config other.toml"
    done = run(command, {"AGENTROB_TOKEN": "x", "AGENTROB_DATA": str(tmp_path)}, folder)
    assert done.returncode == 1
    assert "forum 'nosuch' is not installed; installed forums: board, " in done.stderr
    assert "Traceback" not in done.stderr
