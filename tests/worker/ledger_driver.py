"""A driver that writes to a ledger which steps reached its robot, and by which worker.

Run as `python -m tests.worker.ledger_driver ROBOT SETTINGS FOLDER`, with the settings as JSON. Each line of
`ledger.jsonl` has the time, the holder of the lease, its fencing number and what happened to the step.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, FencingToken, Primitive
from agentrob.robots.driver.api import DriverServer, app
from agentrob.robots.driver.driver import Driver
from agentrob.robots.driver.fencing import FencingNumbers
from agentrob.robots.driver.network import NetworkListener
from agentrob.robots.driver.process import listening, make_robot
from agentrob.robots.safety.crash_marker import CrashMarker
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt


class LedgerDriver(Driver):
    """Writes a line when a lease is given, when a step begins, and when it has ended and the robot is at rest."""

    def __init__(self, name: str, guard: Guard, numbers: FencingNumbers, ledger: Path) -> None:
        super().__init__(name, guard, numbers)
        self._ledger = os.open(ledger, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
        self._held: dict[str, dict[str, Any]] = {}

    def take(self, holder: str, since_s: float | None = None, fence: FencingToken | None = None) -> str:
        lease = super().take(holder, since_s, fence)
        number, store = (fence.number, fence.store) if fence else (None, None)
        self._held[lease] = {"holder": holder, "number": number, "store": store}
        self._write(lease, "leased")
        return lease

    def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        self._write(lease, "begun")
        result = super().step(lease, primitive, deadline_s)
        self._write(lease, "ended", outcome=str(result.outcome), reason=result.reason)
        return result

    def _write(self, lease: str, what: str, **more: Any) -> None:
        line = {"at_s": time.monotonic(), "what": what, **self._held.get(lease, {}), **more}
        os.write(self._ledger, (json.dumps(line) + "\n").encode())


def run_ledger_driver(name: str, settings: RobotConfig, socket: Path, folder: Path) -> None:
    """Hold the robot until SIGTERM; the main function of its process."""
    ended = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: ended.set())
    with contextlib.ExitStack() as stack:
        guard = Guard(
            make_robot(settings), settings, Halt(folder / f"{name}.halt"), CrashMarker(folder / f"{name}.step")
        )
        driver = LedgerDriver(name, guard, FencingNumbers(folder / f"{name}.fence"), folder / "ledger.jsonl")
        stack.callback(driver.close)
        driver.guard.settle()
        stack.enter_context(DriverServer(driver, stack.enter_context(listening(socket))))
        if settings.driver_listen:
            network = stack.enter_context(NetworkListener(settings))
            stack.enter_context(network.serve(app(driver, remote=True)))
        print(json.dumps({"ready": "driver"}), flush=True)  # noqa: T201
        ended.wait()


if __name__ == "__main__":
    robot, place = sys.argv[1], Path(sys.argv[3])
    run_ledger_driver(robot, RobotConfig.model_validate_json(sys.argv[2]), place / f"{robot}.sock", place)
