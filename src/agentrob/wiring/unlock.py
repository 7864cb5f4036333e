"""`agentrob release` and `agentrob home`: release a robot or set its home on its machine, through its running driver.

Needs neither forum nor agent: whoever may write to the driver's socket, which only its own user can, owns the robot
there (law 2). A demo's robots are found by the folder that the demo keeps its sockets in.
"""

from __future__ import annotations

import asyncio
import getpass
import socket
from pathlib import Path

from agentrob.config.load import Config, runtime_dir
from agentrob.errors import ConfigError, RobotUnreachable
from agentrob.model import Lock, Pose, RobotState
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.remote import driver_client
from agentrob.robots.safety.lock import held_for
from agentrob.wiring.running_demo import demo_folder, running_demo


def release(robot: str, config: Config, data: Path | None = None) -> str:
    """Release a locked robot; a line for people. `data` is the folder of the demo that is meant.

    Raises `ConfigError` for a robot that is not known, `RobotUnreachable` without its driver, `RobotError` when it
    stays locked.
    """
    lock, state = asyncio.run(_release(_client(robot, config, data)))
    now = "Nothing moves by that; the next command may move it."
    if state.halted:  # somebody, or its own guard, locked it again at once
        now = f"But it is locked again: {_who(state.lock)}."
    if lock is None:
        return f"{robot}: it was not locked. {now}"
    return f"{robot}: released. It was locked: {_who(lock)}. {now}"


def home(robot: str, config: Config, data: Path | None = None) -> str:
    """Make the robot's home where it stands; a line for people. Raises as `release`; `RobotError` while it moves."""
    pose, state = asyncio.run(_home(_client(robot, config, data)))
    line = f"{robot}: its home is where it stands now (x {pose.x_m:.2f} m, y {pose.y_m:.2f} m of its odometry)."
    return f"{line} It is still locked: agentrob release {robot}" if state.halted else line


async def _release(driver: DriverClient) -> tuple[Lock | None, RobotState]:
    async with driver:
        lock = await driver.release(_me())
        return lock, await driver.state()


async def _home(driver: DriverClient) -> tuple[Pose, RobotState]:
    async with driver:
        pose = await driver.home(_me())
        return pose, await driver.state()


def _me() -> str:
    return f"{getpass.getuser()} at the shell"


def _who(lock: Lock | None) -> str:
    if lock is None or not lock.by:
        return lock.why if lock else "nobody knows why"
    held = held_for(lock)
    return f"by {lock.by}{f' {held} ago' if held else ''}, {lock.why.rstrip('.')}"


# ---------------------------------------------------------------------- where its driver listens
def _client(robot: str, config: Config, data: Path | None) -> DriverClient:
    """A client of the robot's driver, on this machine unless its settings name another one."""
    settings = config.robots.get(robot)
    if settings is not None and settings.driver_url and data is None:
        return driver_client(robot, settings)
    return DriverClient(robot, _socket(robot, config, data))


def _socket(robot: str, config: Config, data: Path | None) -> Path:
    """The socket of the robot's driver."""
    usual = _sockets(runtime_dir()) if data is None else {}
    if robot in usual:
        return usual[robot]
    demos = _demo_sockets(data)
    if robot in demos:
        return demos[robot]
    if robot in config.robots and data is None:
        raise RobotUnreachable(f"no driver of {robot!r} runs on this machine; start one with: agentrob driver {robot}")
    known = sorted({*usual, *demos, *(config.robots if data is None else ())})
    where = f" in the demo of {data}" if data is not None else ""
    raise ConfigError(f"no robot named {robot!r}{where}; valid: {', '.join(known) or 'none'}")


def _demo_sockets(data: Path | None) -> dict[str, Path]:
    """Those of the demo that runs with this data folder, or with the usual one."""
    facts = running_demo(data or demo_folder(once=False)) or {}
    folder = facts.get("runtime")  # its AGENTROB_RUNTIME
    return _sockets(Path(folder) / "agentrob") if isinstance(folder, str) else {}


def _sockets(folder: Path) -> dict[str, Path]:
    """Robots by name whose drivers listen in this folder."""
    found = (path for path in sorted(folder.glob("*.sock")) if not path.name.startswith("."))
    return {path.stem: path for path in found if _listens(path)}


def _listens(path: Path) -> bool:
    """Whether a process listens there; a driver that was killed leaves its socket behind."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.settimeout(1.0)
        try:
            probe.connect(str(path))
        except OSError as e:
            return isinstance(e, TimeoutError)  # it hangs: whoever calls it learns that
    return True
