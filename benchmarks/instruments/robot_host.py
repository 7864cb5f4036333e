"""Hold the drivers of many fake robots in one process, and write each step that reaches a robot to a ledger.

    python benchmarks/instruments/robot_host.py --robots 50 --first 0 --runtime DIR --data DIR --ledger FILE

A driver is a process of its own elsewhere; two hundred of them would take 12 GB. The drivers, their sockets and their
API are the real ones, but they share one server and one thread that observes the robots: with a server and a thread for
each, most of the processor time would be spent on waking these.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import socket
import threading
import time
from pathlib import Path

from starlette.types import ASGIApp, Receive, Scope, Send

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Primitive, StopResult
from agentrob.process.http_server import HttpServer
from agentrob.robots.driver.api import app
from agentrob.robots.driver.driver import Driver
from agentrob.robots.driver.process import listening, make_robot
from agentrob.robots.safety.crash_marker import CrashMarker
from agentrob.robots.safety.guard import OBSERVE_HZ, Guard, SimulatedTime
from agentrob.robots.safety.lock import Halt


def robot_name(number: int) -> str:
    return f"robot-{number:03}"


def robot_settings(time_scale: float) -> RobotConfig:
    """A fake robot in a large room, without rate limits."""
    wide = {"x_min_m": -1000.0, "x_max_m": 1000.0, "y_min_m": -1000.0, "y_max_m": 1000.0}
    return RobotConfig.model_validate({
        "model": "fake", "simulated": True, "home_on_start": True, "fence": wide,
        "rates": {"commands_per_hour": 0, "cooldown_s": 0, "waiting": 0}, "recording": {"view": "none"},
        "options": {"time_scale": time_scale, "room": [-1000, 1000, -1000, 1000]},
    })  # fmt: skip


class LedgerDriver(Driver):
    """A driver that writes who made which step, when it reached the robot and how it ended."""

    def __init__(self, name: str, guard: Guard, ledger: int) -> None:
        super().__init__(name, guard)
        self._ledger = ledger

    def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        holder = self.leases.holder
        self._write(holder, "begun", str(primitive.op))
        result = super().step(lease, primitive, deadline_s)
        self._write(holder, str(result.outcome), str(primitive.op))
        return result

    def stop(self, by: str, asked_s: float | None = None, *, running_only: bool = False) -> StopResult:
        if not running_only:
            self._write(by, "stop", "")
        return super().stop(by, asked_s, running_only=running_only)

    def _write(self, holder: str | None, what: str, op: str) -> None:
        line = {"robot": self.name, "holder": holder, "what": what, "op": op, "at_s": time.monotonic()}
        os.write(self._ledger, (json.dumps(line) + "\n").encode())  # one write of a line to a file opened to append


class DriverRouter:
    """Dispatches each request to the driver on whose Unix socket it arrived."""

    def __init__(self, drivers: dict[str, ASGIApp]) -> None:
        self._drivers = drivers

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        await self._drivers[scope["server"][0]](scope, receive, send)


def observe(drivers: list[LedgerDriver], ended: threading.Event) -> None:
    """Observe all robots until `ended`, as a guard with a thread of its own does."""
    while not ended.wait(1 / OBSERVE_HZ):
        for driver in drivers:
            driver.guard.observe()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--time-scale", type=float, default=20.0)
    for folder in ("runtime", "data", "ledger"):
        parser.add_argument(f"--{folder}", type=Path, required=True)
    options = parser.parse_args()
    ended = threading.Event()
    for signum in (signal.SIGTERM, signal.SIGINT):
        signal.signal(signum, lambda *_: ended.set())
    settings = robot_settings(options.time_scale)
    ledger = os.open(options.ledger, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
    folder = options.data / "drivers"
    drivers: list[LedgerDriver] = []
    served: dict[str, ASGIApp] = {}
    listeners: list[socket.socket] = []
    with contextlib.ExitStack() as stack:
        for number in range(options.first, options.first + options.robots):
            name = robot_name(number)
            marks = Halt(folder / f"{name}.halt"), CrashMarker(folder / f"{name}.step")
            clock = SimulatedTime(time.monotonic, time.sleep)
            guard = Guard(make_robot(settings), settings, *marks, simulated_time=clock)
            drivers.append(LedgerDriver(name, guard, ledger))
            guard.settle()
            stack.callback(drivers[-1].close)
            listeners.append(stack.enter_context(listening(options.runtime / f"{name}.sock")))
            served[listeners[-1].getsockname()] = app(drivers[-1])
        threading.Thread(target=observe, args=(drivers, ended), daemon=True).start()
        server = HttpServer(DriverRouter(served), handle_signals=False, lifespan="off", ws="none")
        serving = threading.Thread(target=server.run, args=(listeners,), daemon=True)
        serving.start()
        print(json.dumps({"ready": "robots", "robots": options.robots}), flush=True)
        ended.wait()
        server.should_exit = True
        serving.join(1.0)


if __name__ == "__main__":
    main()
