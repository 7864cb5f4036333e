"""docs/robots/real-robot.md is accurate: its commands make certificates, and its two configurations reach each
other."""

from __future__ import annotations

import json
import re
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.load import parse
from agentrob.robots.driver.remote import driver_client
from tests.robots.driver_scene import NEAR, Drivers
from tests.waiting import until

GUIDE = (Path(__file__).parents[3] / "docs/robots/real-robot.md").read_text(encoding="utf-8")
SECTION = GUIDE[GUIDE.index("## 9. The driver on the robot's computer") : GUIDE.index("## What is unverified")]


@pytest.fixture
def drivers(tmp_path: Path) -> Iterator[Drivers]:
    started = Drivers(tmp_path)
    yield started
    started.close()


def blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", SECTION, re.DOTALL)


def settings(text: str, folder: Path, port: str) -> dict[str, Any]:
    """The settings of a block, for a fake robot on this machine."""
    text = text.replace("192.168.1.20:8093", f"127.0.0.1:{port}").replace("/etc/agentrob", str(folder))
    robot: dict[str, Any] = tomllib.loads(text)["robots"]["rex"]
    return {**robot, "model": "fake", "interface": "lo"}


@pytest.fixture
def certificates(tmp_path: Path) -> Path:
    """A folder with the files that the commands of the guide make."""
    (commands,) = blocks("sh")
    commands = commands.replace("192.168.1.20", "127.0.0.1")
    done = subprocess.run(["bash", "-ec", commands], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "driver.pem: OK\nagent.pem: OK" in done.stdout
    return tmp_path


async def test_the_commands_make_certificates_and_the_configurations_reach_each_other(
    drivers: Drivers, certificates: Path
) -> None:
    on_robot, on_agent = blocks("toml")
    process = drivers.spawn("rex", **settings(on_robot, certificates, "0"))
    port = json.loads(process.stdout.readline())["listen"].rpartition(":")[2]
    config = parse({"robots": {"rex": settings(on_agent, certificates, port)}})
    async with driver_client("rex", config.robot("rex")) as robot:
        await until(robot.state, lambda state: state.homed)
        async with robot.lease("agent") as lease:
            assert (await robot.step(lease, NEAR, 10)).ok
        assert (await robot.stop("agent")).confirmed
