"""`agentrob init` at a terminal: from an empty folder to a robot that walks, started as systemd units."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.sim.domains import PrivateDomain
from tests.demo.running import AGENTROB
from tests.host_numbers import free_port
from tests.terminal import Terminal
from tests.tolerances import about_m

DOUBLES = Path(__file__).parents[1] / "doubles"


class Machine:
    """A home folder, and the processes that its service manager has started."""

    def __init__(self, folder: Path, runtime: Path) -> None:
        self.folder, self.units_run = folder, folder / "units"
        (folder / "bin").mkdir()
        self.units_run.mkdir()
        (folder / "bin/systemctl").symlink_to(DOUBLES / "systemctl")
        self.environment = {
            **os.environ,
            "HOME": str(folder),
            "XDG_CONFIG_HOME": str(folder / "config"),
            "UNITS_RUN": str(self.units_run),
            "AGENTROB_DATA": str(folder / "data"),
            "AGENTROB_RUNTIME": str(runtime),
            "PATH": f"{folder / 'bin'}:{Path(sys.executable).parent}:{os.environ['PATH']}",
            "TERM": "xterm",
            "COLUMNS": "200",
        }

    def pids(self) -> list[int]:
        file = self.units_run / "pids"
        return [int(line.split()[1]) for line in file.read_text().splitlines()] if file.exists() else []

    def logs(self) -> str:
        return "\n".join(f"{log.name}: {log.read_text()[-1500:]}" for log in self.units_run.glob("*.log"))

    def end(self) -> None:
        for pid in self.pids():
            try:
                os.kill(pid, signal.SIGTERM)
            except ProcessLookupError:
                continue


@pytest.fixture
def machine(tmp_path: Path, short_folder: Path) -> Iterator[Machine]:
    machine = Machine(tmp_path, short_folder)
    yield machine
    machine.end()


@pytest.mark.sim
def test_the_dialogue_leads_to_a_robot_that_has_walked_and_its_undo_commands_work(machine: Machine) -> None:
    port, config = free_port(), machine.folder / "agentrob.toml"
    domain = PrivateDomain()  # of this test, as long as this object exists
    robot = ("--robot", "rex", "--domain", str(domain.number))
    init = Terminal(AGENTROB, "init", "--config", str(config), *robot, **machine.environment)
    for question, answer in (
        ("first admin", "Chief!"),
        ("'Chief!' is not valid: 2 to 32 of a-z", "chief"),
        ("Name of the forum", ""),
        ("Host and port", f"127.0.0.1:{port}"),
        ("Services", ""),
        ("Let it walk 0.3 m", ""),
    ):
        init.read_until(question, 60)
        init.press(f"{answer}\n".encode())
    init.read_until("5. First walk", 150)
    init.read_until("the thread: ", 60)
    assert init.wait() == 0, init.said + machine.logs()
    said = init.said.replace("\r\n", "\n")
    walked = re.search(r"rex replied: \*\*Done:\*\* walked (\d\.\d+) m", said)
    assert walked, said
    assert float(walked[1]) == about_m(0.3), said
    assert f"set the password of chief, once, within a day: http://127.0.0.1:{port}/password/" in said
    made = tomllib.loads(config.read_text())
    assert made["robots"]["rex"]["owner"] == "chief"
    tokens = machine.folder / "data/agents.env"
    assert tokens.stat().st_mode & 0o777 == 0o600
    units = sorted(path.name for path in (machine.folder / "config/systemd/user").iterdir())
    assert units == [f"agentrob-{name}.service" for name in ("agent-rex", "board", "driver-rex", "world-rex")]
    assert len(machine.pids()) == 4
    assert "Undo the steps in reverse order." in said
    steps = re.split(r"^\d\. ", said, flags=re.MULTILINE)[1:]
    for step in reversed(steps):
        for command in re.findall(r"^   undo: (.*)", step, flags=re.MULTILINE):
            subprocess.run(shlex.split(command), env=machine.environment, check=True, timeout=60, cwd=machine.folder)
    assert not config.exists()
    assert not tokens.exists()
    assert not (machine.folder / "data/board").exists()
    assert not list((machine.folder / "config/systemd/user").iterdir())
