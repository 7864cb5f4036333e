"""Driver processes of fake robots, clients that walk them, and functions that wait for their states."""

from __future__ import annotations

import asyncio
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from uuid import uuid4

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError
from agentrob.model import Direction, Op, Primitive
from agentrob.process.host_lock import namespaced
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.process import run_driver
from tests.forked_process import ForkedProcess
from tests.waiting import until

FAR = Primitive(Op.MOVE, Direction.FORWARD, distance_m=4.0)
NEAR = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.3)


def run(name: str, folder: Path, settings: dict[str, Any]) -> None:
    """Run a driver; the main function of its process."""
    try:
        config = RobotConfig(**{"model": "fake", "simulated": True, "home_on_start": True, **settings})
        run_driver(name, config, folder / f"{name}.sock", folder)
    except RobotError as e:
        sys.exit(str(e))


def walk(name: str, socket: Path) -> None:
    """Run a client that takes the lease and walks; the main function of its process."""

    async def main() -> None:
        async with DriverClient(name, socket) as robot, robot.lease("walker") as lease:
            print("walking", flush=True)  # noqa: T201
            await robot.step(lease, FAR, 60)

    asyncio.run(main())


class Drivers:
    """Starts driver processes of fake robots with unique names and ends them all."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.processes = folder, list[ForkedProcess]()

    def spawn(self, name: str, **settings: Any) -> ForkedProcess:
        process = ForkedProcess(run, name, self.folder, settings)
        self.processes.append(process)
        return process

    def spawn_holder(self, name: str) -> ForkedProcess:
        """Start a client in its own process that takes the lease and walks."""
        process = ForkedProcess(walk, name, self.folder / f"{name}.sock")
        self.processes.append(process)
        return process

    def start(self, name: str = "", **settings: Any) -> tuple[str, ForkedProcess]:
        name = name or f"r{uuid4().hex[:8]}"
        process = self.spawn(name, **settings)
        ready = json.loads(process.stdout.readline())
        assert ready["ready"] == "driver"
        assert ready["lock"] == namespaced(f"driver/fake/{name}")
        return name, process

    def client(self, name: str) -> DriverClient:
        return DriverClient(name, self.folder / f"{name}.sock")

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.communicate()


async def moving(robot: DriverClient, limit_s: float = 60.0) -> None:
    """Wait until the robot really moves."""
    await until(robot.state, lambda state: abs((state.velocity_mps or (0, 0))[0]) > 0.2, limit_s=limit_s)


async def seconds_until(robot: DriverClient, true: Callable[[Any], bool]) -> float:
    """Return the seconds until the state meets a condition."""
    began_s = time.monotonic()
    await until(robot.state, true)
    return time.monotonic() - began_s


def at_rest(state: Any) -> bool:
    return abs(state.velocity_mps[0]) < 0.05


#: The drivers, and the name of one that runs.
Standing = tuple[Drivers, str]
