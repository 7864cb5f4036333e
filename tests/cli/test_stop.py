"""`agentrob stop` while board and agent are dead and another program moves the robot (laws 13, 15 and 17): the output,
the exit code, and what the robots do."""

from __future__ import annotations

import asyncio
import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any
from uuid import uuid4

import httpx2
import pytest
from typer.testing import CliRunner

from agentrob.cli.main import cli
from agentrob.demo.run import Demo, DemoSettings
from agentrob.process import host_lock
from agentrob.robots.driver.client import DriverClient
from tests import in_process
from tests.forked_process import ForkedCommand, ForkedProcess, end_all
from tests.waiting import until

AGENTROB = str(Path(sys.executable).with_name("agentrob"))
ROBOT = "quadruped"
LIMIT_S = 60.0
#: A robot is at rest if it stays this close to its mean position for this long, and if the mean positions of the first
#: and second half differ by less. So it may sway, but it does not go anywhere.
REST_M, REST_S = 0.02, 0.8
#: Takes longer than `agentrob stop` needs to start on a busy machine.
LONG = "walk forward 2 metres, walk backward 2 metres, walk forward 2 metres"
STOPPED = r"zero velocity commanded after \d+ ms; stands still"
CONFIG = """
data = "{data}"
[board]
listen = "127.0.0.1:{port}"
[forum]
url = "http://127.0.0.1:{port}"
"""
ROBOT_CONFIG = """
[robots.{name}]
model = "fake"
domain = {domain}
simulated = true
home_on_start = true
fence = {{ x_min_m = -1000.0, x_max_m = 1000.0, y_min_m = -1000.0, y_max_m = 1000.0 }}
options = {{ room = [-1000, 1000, -1000, 1000] }}
"""


@dataclass
class Lab:
    """A folder with an `agentrob.toml`, the drivers of two fake robots, and a killed board and agent."""

    folder: Path
    runtime: Path
    names: tuple[str, str]
    domain: int
    drivers: dict[str, ForkedCommand]

    def command(self, *args: str) -> ForkedCommand:
        return ForkedCommand(self.folder, *args, AGENTROB_RUNTIME=str(self.runtime))

    def start(self, name: str) -> ForkedCommand:
        log, env = self.folder / f"{name}.log", {"AGENTROB_RUNTIME": str(self.runtime)}
        self.drivers[name] = ForkedCommand(self.folder, "driver", name, log=log, **env)
        return self.drivers[name]

    def lock(self, name: str) -> str:
        return host_lock.namespaced(f"driver/fake/{self.domain}/{name}")

    def robot(self, name: str) -> DriverClient:
        return client_of(name, self.drivers[name].ready)


def client_of(name: str, ready: dict[str, Any]) -> DriverClient:
    return DriverClient(name, Path(ready["socket"]))


def shell(folder: Path, runtime: Path, *args: str) -> subprocess.Popen[str]:
    env = {**os.environ, "AGENTROB_RUNTIME": str(runtime)}
    pipe = subprocess.PIPE
    return subprocess.Popen([AGENTROB, *args], cwd=folder, env=env, stdout=pipe, stderr=pipe, text=True)


def output_of(process: subprocess.Popen[str] | ForkedCommand) -> tuple[str, str, int | None]:
    out, errors = process.communicate(timeout=LIMIT_S)
    return out, errors, process.returncode


@pytest.fixture(scope="module")
def killed_lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    """Start everything and check that it works; then kill board and agent for all tests of this file."""
    names = f"a{uuid4().hex[:6]}", f"b{uuid4().hex[:6]}"
    folder, runtime = tmp_path_factory.mktemp("field"), tmp_path_factory.mktemp("r")
    config, domain = folder / "agentrob.toml", int(os.environ["AGENTROB_TEST_DOMAIN"])

    def write(port: int) -> None:
        robots = "".join(ROBOT_CONFIG.format(name=name, domain=domain) for name in names)
        config.write_text(CONFIG.format(data=folder / "data", port=port) + robots)

    write(0)
    env = {"AGENTROB_RUNTIME": str(runtime)}
    processes = [ForkedCommand(folder, "board", "serve", log=folder / "board.log")]
    lab = Lab(folder, runtime, names, domain, {})
    try:
        write(int(processes[0].ready["url"].rsplit(":", 1)[1]))
        for name in names:
            lab.start(name)
        added = in_process.agentrob(folder, "board", "account", "add", names[0], "--kind", "robot_agent")
        assert added.returncode == 0, added.stderr
        env["AGENTROB_TOKEN"] = added.stdout.strip()
        processes.append(ForkedCommand(folder, "agent", "run", names[0], log=folder / "agent.log", **env))
        for process in (*lab.drivers.values(), *processes):
            assert process.ready
        kill(*processes)
        yield lab
    finally:
        end_all([*processes, *lab.drivers.values()])


@pytest.fixture
def lab(killed_lab: Lab) -> Iterator[Lab]:
    """Yield the lab with two running drivers, whatever the previous test did to them."""
    for name, driver in killed_lab.drivers.items():
        if not driver.alive:
            assert killed_lab.start(name).ready
    yield killed_lab
    for driver in killed_lab.drivers.values():
        driver.send_signal(signal.SIGCONT)


def kill(*processes: ForkedProcess | subprocess.Popen[bytes]) -> None:
    for process in processes:
        process.kill()
        assert process.wait(60) == -signal.SIGKILL


def speed(state: Any) -> float:
    return abs((state.velocity_mps or (0.0,))[0])


def until_it_walks(robot: DriverClient) -> None:
    asyncio.run(_with(robot, until(robot.state, lambda state: speed(state) > 0.2)))


def at_rest(robot: DriverClient) -> bool:
    """Wait until the robot is released and at rest; a standing robot may sway, but it does not go anywhere."""

    async def look() -> bool:
        if await robot.holder() is not None:
            return False
        places, end_s = [], time.monotonic() + REST_S
        while time.monotonic() < end_s:
            pose = (await robot.state()).pose
            assert pose is not None
            places.append((pose.x_m, pose.y_m))
            await asyncio.sleep(0.02)
        half = len(places) // 2
        middle, before, after = (
            [fmean(one) for one in zip(*some, strict=True)] for some in (places, places[:half], places[half:])
        )
        return math.dist(before, after) < REST_M and max(math.dist(middle, place) for place in places) < REST_M

    return bool(asyncio.run(_with(robot, look())))


async def _with(robot: DriverClient, work: Any) -> Any:
    async with robot:
        return await work


def our_lines(out: str, *starts: str) -> list[str]:
    """Return the lines about the robots of this test, because `--all` also stops other robots."""
    return [line for line in out.splitlines() if line.startswith(starts)]


@pytest.mark.parametrize("how", ["name", "all"])
def test_law_13_a_robot_that_drive_moves_is_stopped_with_board_and_agent_dead(lab: Lab, how: str) -> None:
    name = lab.names[0]
    drive = lab.command("drive", name, "walk forward 5 metres, then walk forward 5 metres")
    until_it_walks(lab.robot(name))
    out, errors, code = output_of(lab.command("stop", *([name] if how == "name" else ["--all"])))
    (line,) = our_lines(out, f"{name}: ", f"{lab.lock(name)}: ")
    assert re.search(STOPPED, line), out
    assert errors == ""
    assert code == 0 or len(out.splitlines()) > len(our_lines(out, *(lab.lock(n) for n in lab.names))), out
    assert at_rest(lab.robot(name))
    told, _, ended = output_of(drive)
    assert ended == 1  # stopped, and the second step did not start
    assert "stopped" in told
    assert "skipped" in told
    assert at_rest(lab.robot(name))


def test_law_15_a_hanging_driver_is_reported_and_the_other_robot_is_still_stopped(lab: Lab) -> None:
    hung, good = lab.names
    drives = [lab.command("drive", name, "walk forward 5 metres") for name in lab.names]
    for name in lab.names:
        until_it_walks(lab.robot(name))
    lab.drivers[hung].send_signal(signal.SIGSTOP)
    stopping = lab.command("stop", "--all")
    asyncio.run(_with(robot := lab.robot(good), until(robot.state, lambda state: speed(state) < 0.05)))
    assert stopping.poll() is None, "the good robot is stopped before the hung one is given up"
    out, _, code = output_of(stopping)
    assert code == 1
    (line,) = our_lines(out, lab.lock(hung))
    assert "NOT STOPPED: no driver answers" in line
    assert "use the robot's own stop" in line
    (line,) = our_lines(out, lab.lock(good))
    assert re.search(STOPPED, line)
    lab.drivers[hung].send_signal(signal.SIGCONT)
    assert [output_of(drive)[2] for drive in drives] == [1, 1]
    asyncio.run(_with(robot := lab.robot(hung), until(robot.state, lambda state: speed(state) < 0.05)))


def test_law_17_a_hanging_driver_is_reported_in_time(lab: Lab) -> None:
    hung = lab.names[0]
    lab.drivers[hung].send_signal(signal.SIGSTOP)
    out, errors, code = output_of(lab.command("stop", hung))
    assert code == 1
    assert f"{hung}: NOT STOPPED: no driver answers at {lab.lock(hung)} (TimeoutError)" in out
    assert errors == ""


def test_law_17_a_robot_without_a_driver_is_reported(lab: Lab) -> None:
    gone = lab.names[0]
    kill(lab.drivers[gone])
    out, errors, code = output_of(lab.command("stop", gone))
    assert code == 1
    assert f"{gone}: NOT STOPPED: no driver answers" in out
    assert "use the robot's own stop" in out
    assert errors == ""


def test_law_17_the_absence_of_any_driver_is_reported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    # With its own runtime folder, because other tests may run drivers on this machine.
    monkeypatch.setattr(host_lock, "held", lambda prefix="": [])
    monkeypatch.chdir(tmp_path)
    for args in (["stop"], ["stop", "--all"]):
        done = CliRunner().invoke(cli, args)
        assert done.exit_code == 0
        assert done.stdout == "no driver runs on this machine, so no robot is moved by us\n"


@pytest.fixture(scope="module")
def orphaned_demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """Start a demo and kill its board and its worker."""
    with Demo(DemoSettings(tmp_path_factory.mktemp("headless") / "demo", port=0)) as demo:
        demo.start()
        child = {child.name: child for child in demo.children}
        kill(child["worker"].process, child["board"].process)
        yield demo


async def reset_room(demo: Demo, robot: DriverClient) -> None:
    """Reset the room; wait until the driver has seen the robot at its start for longer than a state's delay."""
    httpx2.post(f"{demo.room_url}/reset", timeout=LIMIT_S).raise_for_status()
    since_s = math.inf

    def there(state: Any) -> bool:
        nonlocal since_s
        near = state.homed and state.pose is not None and math.hypot(state.pose.x_m, state.pose.y_m) < 0.05
        since_s = min(since_s, time.monotonic()) if near else math.inf
        return time.monotonic() - since_s > 0.4

    await until(robot.state, there)


@pytest.mark.sim
@pytest.mark.parametrize("how", ["all", pytest.param("name", marks=pytest.mark.slow)])
def test_law_13_a_simulated_go2_is_stopped_with_board_and_agent_dead(
    orphaned_demo: Demo, tmp_path: Path, how: str
) -> None:
    assert orphaned_demo.runtime is not None
    config = str(orphaned_demo.data / "agentrob.toml")
    driver = next(child for child in orphaned_demo.children if child.name == f"driver-{ROBOT}")
    asyncio.run(_with(robot := client_of(ROBOT, driver.wait_ready()), reset_room(orphaned_demo, robot)))
    drive = shell(tmp_path, orphaned_demo.runtime, "drive", ROBOT, LONG, "--config", config)
    until_it_walks(client_of(ROBOT, driver.wait_ready()))
    aim = [ROBOT] if how == "name" else ["--all"]
    out, errors, code = output_of(shell(tmp_path, orphaned_demo.runtime, "stop", *aim, "--config", config))
    (line,) = our_lines(out, f"{ROBOT}: ", f"{driver.wait_ready()['lock']}: ")
    assert re.search(STOPPED, line), out
    assert errors == ""
    assert code == 0 or len(out.splitlines()) > 1, out
    assert at_rest(client_of(ROBOT, driver.wait_ready()))
    assert output_of(drive)[2] == 1
