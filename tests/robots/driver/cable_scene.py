"""A robot at the end of a cable: world and driver in separate network namespaces, joined by virtual interfaces.

Run as `unshare -rn python cable_scene.py FOLDER`; prints one line of JSON with the result of pulling the cable.
"""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from agentrob.model import ActionResult
from agentrob.robots.driver.client import DriverClient
from tests.robots.sim_scene import DRIVER, Process
from tests.robots.sim_steps import FAR, NEAR
from tests.waiting import until, wait_for

DOMAIN = 0  # these namespaces have no other processes
WORLD = """
read go
ip link set lo up; ip addr add 10.99.0.2/24 dev robot; ip link set robot up
exec "$0" -m agentrob.sim.server --domain go2=0 --interface robot --event-log "$1"
"""


def ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True)


def set_link(up: bool) -> float:
    ip("link", "set", "host", "up" if up else "down")
    return time.monotonic()


def start(folder: Path) -> tuple[subprocess.Popen[str], Process]:
    """A world on `robot` and a driver on `host`, the two ends of the cable."""
    ip("link", "set", "lo", "up")
    ip("link", "add", "host", "type", "veth", "peer", "name", "robot")
    command = ["unshare", "-n", "sh", "-c", WORLD, sys.executable, str(folder / "ledger")]
    world = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    wait_for(lambda: Path(f"/proc/{world.pid}/ns/net").readlink() != Path("/proc/self/ns/net").readlink())
    ip("link", "set", "robot", "netns", str(world.pid))
    ip("addr", "add", "10.99.0.1/24", "dev", "host")
    set_link(True)
    assert world.stdin is not None
    assert world.stdout is not None
    world.stdin.write("go\n")
    world.stdin.flush()
    assert json.loads(world.stdout.readline())["ready"]
    settings = {"domain": DOMAIN, "interface": "host", "home_on_start": True}
    driver = Process(DRIVER, "quadruped", str(folder), json.dumps(settings), errors=subprocess.DEVNULL)
    assert json.loads(driver.ask(""))["ready"] == "driver"
    return world, driver


def said(result: ActionResult) -> dict[str, Any]:
    return {"outcome": str(result.outcome), "reason": result.reason, "message": result.message}


async def pull_cable(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = {}
    async with DriverClient("quadruped", folder / "quadruped.sock") as robot:
        await until(robot.state, lambda state: state.age_s < 0.2 and state.homed)
        async with robot.lease("walker") as lease:
            step = asyncio.create_task(robot.step(lease, FAR, 30))
            await until(robot.state, lambda state: state.pose is not None and state.pose.x_m > 0.4)
            pulled_s = set_link(False)
            found["pulled"] = said(await step)
            found["ended_s"] = time.monotonic() - pulled_s
            stopped = await robot.stop("walker")
            found["confirmed"], found["stop"] = stopped.confirmed, stopped.message
            found["stop_ms"] = stopped.latency_ms
        async with robot.lease("walker") as lease:
            found["unplugged"] = said(await robot.step(lease, NEAR, 30))
        set_link(True)
        await until(robot.state, lambda state: state.age_s < 0.2)
        await until(
            robot.state, lambda state: state.homed and not any(abs(v) > 0.1 for v in state.velocity_mps or (1.0,))
        )
        async with robot.lease("walker") as lease:
            found["again"] = said(await robot.step(lease, NEAR, 30))
    return found


def main() -> None:
    folder = Path(sys.argv[1])
    world, driver = start(folder)
    try:
        print(json.dumps(asyncio.run(pull_cable(folder))))  # noqa: T201
    finally:
        driver.end()
        world.kill()
        world.wait()


if __name__ == "__main__":
    main()
