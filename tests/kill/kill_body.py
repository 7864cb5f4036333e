"""The body of `kill_robot.RemoteBodyRobot`, a process that is never killed: it moves as commanded and logs its motion.

Like a real robot it holds a velocity for one second after the last command. The ledger has one JSON object per line:
`at_s` (CLOCK_MONOTONIC), `event` (`step`: a driver begins a step; `rest_commanded`: it is commanded to rest while it
moves; `moves`, `rests`) and `walked_m`, the total distance so far.
"""

from __future__ import annotations

import json
import math
import socket
import sys
import threading
import time
from pathlib import Path
from typing import Any

from agentrob.config.robots import RobotConfig
from agentrob.robots import codec
from agentrob.robots.control.controller import Velocity
from agentrob.robots.fake import FakeRobot

FAR = 2000.0
#: A tenth of the speed limit. A robot slower than this counts as standing: a body that coasts only fades out.
STILL_MPS = 0.05


class Body:
    def __init__(self, ledger: Path) -> None:
        self.robot = FakeRobot(RobotConfig(model="fake", options={"room": [-FAR, FAR, -FAR, FAR]}))
        self.ledger = ledger.open("a", encoding="utf-8")
        self.lock = threading.Lock()
        self.walked_m, self.pose, self.moving = 0.0, self.robot.pose, False

    def look(self) -> None:
        """Log when it starts to move and when it stands still again."""
        with self.lock:
            state, last = self.robot.state(), self.pose
            assert state.pose is not None
            self.pose = state.pose
            self.walked_m += math.hypot(self.pose.x_m - last.x_m, self.pose.y_m - last.y_m)
            assert state.velocity_mps is not None
            moving = math.hypot(*state.velocity_mps) > STILL_MPS
            if moving != self.moving:
                self.moving = moving
                self.note("moves" if moving else "rests")

    def note(self, event: str, **facts: Any) -> None:
        line = {"at_s": time.monotonic(), "event": event, "walked_m": round(self.walked_m, 4), **facts}
        self.ledger.write(json.dumps(line) + "\n")
        self.ledger.flush()

    def answer(self, request: dict[str, Any]) -> Any:
        self.look()
        match request["what"]:
            case "state":
                return codec.encode(self.robot.state())
            case "moving":
                return self.moving
            case "step":
                with self.lock:
                    self.note("step", op=request["op"])
            case "command":
                self.robot.command(Velocity(*request["velocity"]))
            case "rest":
                self.robot.rest()
                with self.lock:
                    if self.moving:
                        self.note("rest_commanded")
        return None

    def serve(self, connection: socket.socket) -> None:
        lines = connection.makefile("rw", encoding="utf-8")
        try:
            for line in lines:
                lines.write(json.dumps(self.answer(json.loads(line))) + "\n")
                lines.flush()
        except OSError:
            pass  # a killed driver

    def accept(self, listener: socket.socket) -> None:
        while True:
            connection, _ = listener.accept()
            threading.Thread(target=self.serve, args=(connection,), daemon=True).start()


def main(path: str, ledger: str) -> None:
    body = Body(Path(ledger))
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.bind(path)
    listener.listen()
    threading.Thread(target=body.accept, args=(listener,), daemon=True).start()
    sys.stdout.write(json.dumps({"ready": True}) + "\n")
    sys.stdout.flush()
    while True:
        body.look()
        time.sleep(0.01)
