"""Every command in the README works as written."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMANDS = [
    line for block in re.findall(r"^```sh\n(.*?)^```", README, re.MULTILINE | re.DOTALL) for line in block.splitlines()
]
MAKE = [c for c in COMMANDS if c.startswith("make ")]
INSTALL = [c for c in COMMANDS if c.startswith(".venv/bin/pip ")]
SHELL = [c for c in COMMANDS if c not in (*MAKE, *INSTALL)]
PYTHON = re.findall(r"^```python\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
MARKS = {"drive g1|demo": pytest.mark.slow}
LIMIT_S = 200


def environment(data: Path) -> dict[str, str]:
    return {**os.environ, "AGENTROB_DATA": str(data)}


def test_the_readme_has_the_two_commands_and_they_are_targets() -> None:
    assert MAKE == ["make demo", "make test"]
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert {c.split()[1] for c in MAKE} <= set(targets)


@pytest.mark.sim
@pytest.mark.parametrize(
    "command",
    [pytest.param(c, marks=[mark for words, mark in MARKS.items() if re.search(words, c)]) for c in SHELL],
)
def test_a_shell_command_in_the_readme_runs(command: str, tmp_path: Path) -> None:
    program, *args = shlex.split(command)
    assert program == ".venv/bin/agentrob", "the README calls the program where make puts it"
    done = subprocess.run(
        [Path(sys.executable).with_name("agentrob"), *args],
        cwd=tmp_path,
        env=environment(tmp_path),
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_packages_of_other_robots_are_installed_as_the_readme_says(tmp_path: Path) -> None:
    """Into a separate folder and without a network."""
    (command,) = INSTALL
    _, *args = shlex.split(command)
    into = ["--no-index", "--no-build-isolation", "--target", str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-m", "pip", *args, *into],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    installed = {path.name.partition("-")[0] for path in tmp_path.glob("*.dist-info")}
    assert installed == {"agentrob_ros2", "agentrob_so101"}


@pytest.mark.sim
@pytest.mark.parametrize("code", PYTHON)
def test_the_python_example_in_the_readme_drives_a_robot(code: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=environment(tmp_path),
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "move" in done.stdout
    assert "done" in done.stdout


def test_links_in_the_readme_have_targets() -> None:
    targets = re.findall(r"\]\(((?!https?:)[^)#]+)\)", README)
    missing = [t for t in targets if not (ROOT / t).exists()]
    assert not missing


def test_the_readme_is_short_and_shows_one_moving_picture_and_one_of_four_kinds_of_robots() -> None:
    assert len(README.splitlines()) <= 120
    pictures = ["docs/images/recording-room.webp", "docs/images/four-robots.webp"]
    assert re.findall(r"!\[[^\]]+\]\(([^)]+)\)", README) == pictures
