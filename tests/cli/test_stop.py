"""`agentrob stop` as a person types it while board and agent are dead and something else moves the robot (laws 13, 15
and 17): the words, the exit code, and what the robots do."""

from __future__ import annotations

import asyncio
import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
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

AGENTROB = str(Path(sys.executable).with_name("agentrob"))
ROBOT = "quadruped"
LIMIT_S = 60.0
#: A robot that stands keeps so close to its mean place for so long, and the mean places of both halves differ by less:
#: it may sway, but goes nowhere.
REST_M, REST_S = 0.02, 0.8
#: Longer than `agentrob stop` takes to start on a busy machine.
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
class Field:
    """A folder with an `agentrob.toml`, drivers of two fake robots, and a board and an agent that were killed."""

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


def said(process: subprocess.Popen[str] | ForkedCommand) -> tuple[str, str, int | None]:
    out, errors = process.communicate(timeout=LIMIT_S)
    return out, errors, process.returncode


@pytest.fixture(scope="module")
def ground(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Field]:
    """Everything was started and works; then board and agent are killed, and stay dead for the rest of this file."""
    names = f"a{uuid4().hex[:6]}", f"b{uuid4().hex[:6]}"
    folder, runtime = tmp_path_factory.mktemp("field"), tmp_path_factory.mktemp("r")
    config, domain = folder / "agentrob.toml", int(os.environ["AGENTROB_TEST_DOMAIN"])

    def write(port: int) -> None:
        robots = "".join(ROBOT_CONFIG.format(name=name, domain=domain) for name in names)
        config.write_text(CONFIG.format(data=folder / "data", port=port) + robots)

    write(0)
    env = {"AGENTROB_RUNTIME": str(runtime)}
    processes = [ForkedCommand(folder, "board", "serve", log=folder / "board.log")]
    field = Field(folder, runtime, names, domain, {})
    try:
        write(int(processes[0].ready["url"].rsplit(":", 1)[1]))
        for name in names:
            field.start(name)
        added = in_process.agentrob(folder, "board", "account", "add", names[0], "--kind", "robot_agent")
        assert added.returncode == 0, added.stderr
        env["AGENTROB_TOKEN"] = added.stdout.strip()
        processes.append(ForkedCommand(folder, "agent", "run", names[0], log=folder / "agent.log", **env))
        for process in (*field.drivers.values(), *processes):
            assert process.ready
        kill(*processes)
        yield field
    finally:
        end_all([*processes, *field.drivers.values()])


@pytest.fixture
def field(ground: Field) -> Iterator[Field]:
    """With two drivers that live, whatever the test before did to them."""
    for name, driver in ground.drivers.items():
        if not driver.alive:
            assert ground.start(name).ready
    yield ground
    for driver in ground.drivers.values():
        driver.send_signal(signal.SIGCONT)


def kill(*processes: ForkedProcess | subprocess.Popen[bytes]) -> None:
    for process in processes:
        process.kill()
        assert process.wait(60) == -signal.SIGKILL


async def until(robot: DriverClient, true: Callable[[Any], bool]) -> None:
    async with asyncio.timeout(LIMIT_S):
        while not true(await robot.state()):  # noqa: ASYNC110 (another process)
            await asyncio.sleep(0.02)


def speed(state: Any) -> float:
    return abs((state.velocity_mps or (0.0,))[0])


def until_it_walks(robot: DriverClient) -> None:
    asyncio.run(_with(robot, until(robot, lambda state: speed(state) > 0.2)))


def at_rest(robot: DriverClient) -> bool:
    """Nobody holds it any more, and it stays where it is: a body that stands still sways, but goes nowhere."""

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


def ours(out: str, *starts: str) -> list[str]:
    """The lines about our robots: `--all` stops those of others too."""
    return [line for line in out.splitlines() if line.startswith(starts)]


@pytest.mark.parametrize("how", ["name", "all"])
def test_law_13_a_robot_that_drive_moves_is_stopped_with_board_and_agent_dead(field: Field, how: str) -> None:
    name = field.names[0]
    drive = field.command("drive", name, "walk forward 5 metres, then walk forward 5 metres")
    until_it_walks(field.robot(name))
    out, errors, code = said(field.command("stop", *([name] if how == "name" else ["--all"])))
    (line,) = ours(out, f"{name}: ", f"{field.lock(name)}: ")
    assert re.search(STOPPED, line), out
    assert errors == ""
    assert code == 0 or len(out.splitlines()) > len(ours(out, *(field.lock(n) for n in field.names))), out
    assert at_rest(field.robot(name))
    told, _, ended = said(drive)
    assert ended == 1  # not done, and the second step did not begin
    assert "stopped" in told
    assert "skipped" in told
    assert at_rest(field.robot(name))


def test_law_15_a_driver_that_hangs_is_said_so_and_the_other_robot_is_stopped_all_the_same(field: Field) -> None:
    hung, good = field.names
    drives = [field.command("drive", name, "walk forward 5 metres") for name in field.names]
    for name in field.names:
        until_it_walks(field.robot(name))
    field.drivers[hung].send_signal(signal.SIGSTOP)
    stopping = field.command("stop", "--all")
    asyncio.run(_with(robot := field.robot(good), until(robot, lambda state: speed(state) < 0.05)))
    assert stopping.poll() is None, "the good robot is stopped before the hung one is given up"
    out, _, code = said(stopping)
    assert code == 1
    (line,) = ours(out, field.lock(hung))
    assert "NOT STOPPED: no driver answers" in line
    assert "use the robot's own stop" in line
    (line,) = ours(out, field.lock(good))
    assert re.search(STOPPED, line)
    field.drivers[hung].send_signal(signal.SIGCONT)
    assert [said(drive)[2] for drive in drives] == [1, 1]
    asyncio.run(_with(robot := field.robot(hung), until(robot, lambda state: speed(state) < 0.05)))


def test_law_17_one_robot_whose_driver_hangs_is_said_so_within_its_time(field: Field) -> None:
    hung = field.names[0]
    field.drivers[hung].send_signal(signal.SIGSTOP)
    out, errors, code = said(field.command("stop", hung))
    assert code == 1
    assert f"{hung}: NOT STOPPED: no driver answers at {field.lock(hung)} (TimeoutError)" in out
    assert errors == ""


def test_law_17_a_robot_without_a_driver_is_said_so(field: Field) -> None:
    gone = field.names[0]
    kill(field.drivers[gone])
    out, errors, code = said(field.command("stop", gone))
    assert code == 1
    assert f"{gone}: NOT STOPPED: no driver answers" in out
    assert "use the robot's own stop" in out
    assert errors == ""


def test_law_17_no_driver_at_all_is_said_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    # As on a machine of our own: others may run drivers on this one.
    monkeypatch.setattr(host_lock, "held", lambda prefix="": [])
    monkeypatch.chdir(tmp_path)
    for args in (["stop"], ["stop", "--all"]):
        done = CliRunner().invoke(cli, args)
        assert done.exit_code == 0
        assert done.stdout == "no driver runs on this machine, so no robot is moved by us\n"


@pytest.fixture(scope="module")
def headless(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """A demo whose board and Go2's agent were killed."""
    with Demo(DemoSettings(tmp_path_factory.mktemp("headless") / "demo", port=None)) as demo:
        demo.start()
        child = {child.name: child for child in demo.children}
        kill(child[f"agent-{ROBOT}"].process, child["board"].process)
        yield demo


async def put_back(demo: Demo, robot: DriverClient) -> None:
    """To its start, as seen by its driver for longer than a state is on its way."""
    httpx2.post(f"{demo.room_url}/reset", timeout=LIMIT_S).raise_for_status()
    since_s = math.inf

    def there(state: Any) -> bool:
        nonlocal since_s
        near = state.homed and state.pose is not None and math.hypot(state.pose.x_m, state.pose.y_m) < 0.05
        since_s = min(since_s, time.monotonic()) if near else math.inf
        return time.monotonic() - since_s > 0.4

    await until(robot, there)


@pytest.mark.sim
@pytest.mark.parametrize("how", ["all", pytest.param("name", marks=pytest.mark.slow)])
def test_law_13_a_simulated_go2_is_stopped_with_board_and_agent_dead(headless: Demo, tmp_path: Path, how: str) -> None:
    assert headless.runtime is not None
    config = str(headless.data / "agentrob.toml")
    driver = next(child for child in headless.children if child.name == f"driver-{ROBOT}")
    asyncio.run(_with(robot := client_of(ROBOT, driver.wait_ready()), put_back(headless, robot)))
    drive = shell(tmp_path, headless.runtime, "drive", ROBOT, LONG, "--config", config)
    until_it_walks(client_of(ROBOT, driver.wait_ready()))
    aim = [ROBOT] if how == "name" else ["--all"]
    out, errors, code = said(shell(tmp_path, headless.runtime, "stop", *aim, "--config", config))
    (line,) = ours(out, f"{ROBOT}: ", f"{driver.wait_ready()['lock']}: ")
    assert re.search(STOPPED, line), out
    assert errors == ""
    assert code == 0 or len(out.splitlines()) > 1, out
    assert at_rest(client_of(ROBOT, driver.wait_ready()))
    assert said(drive)[2] == 1
