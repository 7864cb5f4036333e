"""The tutorial shows the example as it is, and its commands print what the page says."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/start/tutorial.md").read_text(encoding="utf-8")
EXAMPLE = ROOT / "examples/tutorial"
LIMIT_S = 200


def blocks(kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


def typed() -> list[tuple[str, str]]:
    """Each command of the console blocks, and the output that the page shows."""
    return [
        (c, out) for block in blocks("console") for c, out in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block, re.M)
    ]


def run(command: str, env: Mapping[str, str]) -> subprocess.CompletedProcess[str]:
    name, *arguments = shlex.split(command)
    return subprocess.run(
        [Path(sys.executable).with_name(name), *arguments],
        env={**os.environ, **env},
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )


@pytest.fixture(scope="module")
def env(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Install the package as on the page, but into a separate folder and without a network."""
    folder = tmp_path_factory.mktemp("lamp")
    (install,) = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("pip install")]
    done = run(f"{install} --quiet --no-index --target {folder}", {})
    assert done.returncode == 0, done.stderr
    path = os.pathsep.join(filter(None, (os.environ.get("PYTHONPATH", ""), str(folder))))
    return {"PYTHONPATH": path, "AGENTROB_DATA": str(folder / "data")}


def test_the_page_shows_the_whole_file() -> None:
    shown = [block for block in blocks("python") if "TestLamp" not in block]
    assert "\n\n\n".join(block.strip() for block in shown).split() == (EXAMPLE / "agentrob_lamp.py").read_text().split()


def test_the_page_shows_the_entry_points_and_the_contract_as_they_are() -> None:
    (entry_points,) = blocks("toml")
    assert entry_points in (EXAMPLE / "pyproject.toml").read_text()
    (contract,) = [block for block in blocks("python") if "TestLamp" in block]
    assert contract in (EXAMPLE / "test_lamp.py").read_text()


@pytest.mark.parametrize(("command", "output"), typed(), ids=lambda value: value[:60])
def test_a_command_prints_what_the_page_shows(command: str, output: str, env: Mapping[str, str]) -> None:
    done = run(command, env)
    measured = re.compile(r"\d\.\d s$", re.MULTILINE)
    assert measured.sub("S", done.stdout).strip() == measured.sub("S", output).strip(), done.stderr


@pytest.mark.slow  # the contract test runs in real time
def test_the_lamp_keeps_the_contract(env: Mapping[str, str]) -> None:
    (command,) = [line for block in blocks("sh") for line in block.splitlines() if "pytest" in line]
    done = run(f"{command} -p no:cacheprovider", env)
    assert done.returncode == 0, done.stdout


@pytest.mark.sim
@pytest.mark.slow
def test_the_lamp_shines_in_the_demo_where_somebody_says_that_it_is_dark(
    env: Mapping[str, str], tmp_path: Path
) -> None:
    (demo,) = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("agentrob demo")]
    (post,) = re.findall(r"Post `(@lamp [^`]+)`", PAGE)
    done = run(f"{demo} --data {tmp_path / 'demo'} --post {shlex.quote(post)}", env)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "**Done:** shone (5.0 s)." in done.stdout
    assert "Assumed: You said that it is dark." in done.stdout
