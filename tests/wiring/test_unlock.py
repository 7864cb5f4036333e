"""`agentrob release` and `agentrob home` at the robot's machine (laws 2, 9 and 17): output, exit code, and what the
driver does."""

from __future__ import annotations

import asyncio
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

import pytest

from agentrob.model import RobotState
from agentrob.robots.driver.client import DriverClient
from tests.forked_process import ForkedCommand, agentrob, end_all

CONFIG = """
data = "{data}"
[robots.{name}]
model = "fake"
domain = {domain}
simulated = true
home_on_start = {homes}
options = {{ faults = {{ }} }}
[robots.asleep]
model = "fake"
"""


@dataclass
class Machine:
    """A robot's machine: its folder and the running driver."""

    folder: Path
    runtime: Path
    name: str
    driver: ForkedCommand

    @property
    def env(self) -> dict[str, str]:
        return {"AGENTROB_RUNTIME": str(self.runtime), "AGENTROB_DATA": str(self.folder / "all")}

    def type(self, *words: str) -> tuple[int, str]:
        """Run `agentrob WORDS`; return its output and exit code."""
        done = agentrob(self.folder, *words, **self.env)
        return done.returncode, (done.stdout + done.stderr).strip()

    def start(self, *words: str) -> tuple[int, str]:
        """Run `agentrob WORDS` in a new process; return its output and exit code."""
        command, env = [sys.executable, "-m", "agentrob", *words], {**os.environ, **self.env}
        done = subprocess.run(
            command, env=env, cwd=self.folder, capture_output=True, text=True, timeout=100, check=False
        )
        return done.returncode, (done.stdout + done.stderr).strip()

    def ask(self, what: str) -> RobotState:
        """Halt the robot, or only query its state."""

        async def asked() -> RobotState:
            async with DriverClient(self.name, Path(self.driver.ready["socket"])) as robot:
                if what == "halt":
                    await robot.halt("bob")
                return await robot.state()

        return asyncio.run(asked())


def started(folder: Path, homes: bool) -> Machine:
    name, runtime = f"r{uuid4().hex[:8]}", Path(tempfile.mkdtemp(prefix="agentrob-unlock-"))  # socket paths are short
    domain = int(os.environ["AGENTROB_TEST_DOMAIN"])
    text = CONFIG.format(data=folder / "data", name=name, domain=domain, homes=str(homes).lower())
    (folder / "agentrob.toml").write_text(text)
    driver = ForkedCommand(folder, "driver", name, log=folder / "driver.log", AGENTROB_RUNTIME=str(runtime))
    assert driver.ready
    return Machine(folder, runtime, name, driver)


@pytest.fixture
def machine(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Machine]:
    made = started(tmp_path, getattr(request, "param", True))
    runtime = made.runtime
    yield made
    end_all([made.driver])
    shutil.rmtree(runtime, ignore_errors=True)


def test_law_17_release_at_the_shell_says_who_had_locked_it(machine: Machine) -> None:
    assert machine.ask("halt").halted
    code, said = machine.type("release", machine.name)
    assert code == 0
    assert re.match(rf"{machine.name}: released\. It was locked: by bob \d+ seconds? ago, ", said)
    assert said.endswith("an emergency stop. Nothing moves by that; the next command may move it.")
    assert not machine.ask("").halted
    assert machine.start("release", machine.name) == (
        0,
        f"{machine.name}: it was not locked. Nothing moves by that; the next command may move it.",
    )


def test_law_17_release_names_the_known_robots_and_how_to_start_a_driver(machine: Machine) -> None:
    for command in ("release", "home"):
        code, said = machine.type(command, "nobody")
        assert (code, said) == (
            1,
            f"agentrob: no robot named 'nobody'; valid: {', '.join(sorted(('asleep', machine.name)))}",
        )
        code, said = machine.type(command, "asleep")
        assert (code, said) == (
            1,
            "agentrob: no driver of 'asleep' runs on this machine; start one with: agentrob driver asleep",
        )
    machine.ask("halt")
    end_all([machine.driver])
    code, said = machine.type("release", machine.name)
    assert (code, said) == (
        1,
        f"agentrob: no driver of {machine.name!r} runs on this machine; start one with: agentrob driver {machine.name}",
    )


@pytest.mark.parametrize("machine", [False], indirect=True)
def test_law_9_home_at_the_shell_and_doctor_names_both_commands(machine: Machine) -> None:
    assert not machine.ask("halt").homed
    _, said = machine.type("doctor", machine.name, "--json")
    command = {f["check"]: f["command"] for f in json.loads(said)["findings"]}
    assert command["halt"] == f"agentrob release {machine.name}"
    assert command["home"] == f"agentrob home {machine.name}"
    end_s = time.monotonic() + 60
    while (answer := machine.type("home", machine.name))[0] and time.monotonic() < end_s:
        assert "cannot set home while the robot moves" in answer[1]  # the driver must have seen it stand still first
    assert answer[1].startswith(f"{machine.name}: its home is where it stands now (x ")
    assert answer[1].endswith(f"It is still locked: agentrob release {machine.name}")
    assert machine.ask("").homed
    assert machine.start("home", machine.name)[0] == 0
    code, said = machine.type("drive", machine.name, "walk forward 0.3 metres")
    assert code == 1
    assert f"To release it: agentrob release {machine.name}" in said
    assert machine.type("release", machine.name)[0] == 0
    code, said = machine.type("drive", machine.name, "walk forward 0.3 metres")
    assert code == 0, said


def test_a_demo_s_robots_are_found_by_its_folder(machine: Machine) -> None:
    """Like a running demo, the folder is locked and names the directory of the sockets."""
    import fcntl

    data = machine.folder / "all" / "demo"
    data.mkdir(parents=True)
    elsewhere = machine.folder / "elsewhere"
    sockets = str(machine.runtime)
    (data / "demo.json").write_text(json.dumps({"pid": os.getpid(), "url": "", "room": "", "runtime": sockets}))
    machine.ask("halt")
    with (data / "demo.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        machine.runtime = elsewhere  # as in another terminal beside the demo
        code, said = machine.type("release", "nobody", "--data", str(data))
        assert (code, said) == (
            1,
            f"agentrob: no robot named 'nobody' in the demo of {data}; valid: {machine.name}",
        )
        assert machine.type("release", machine.name)[0] == 0, "the usual demo needs no --data"
    assert not machine.ask("").halted
