"""The process of the simulated world: real time, DDS services for every robot, the room's HTTP server.

`python -m agentrob.sim.serve --help` runs it by itself. The world's thread alone touches the physics; everybody else
hands it work through one queue, which it also waits on between ticks, so that a request is answered at once.
"""

from __future__ import annotations

import argparse
import json
import math
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from agentrob.errors import AgentRobError, SimError
from agentrob.hostlock import HostLock

LATE_S = 0.5  # further behind than this, the world gives up catching up; the real-time factor tells
RESET_LIMIT_S = 5.0


@dataclass(frozen=True, slots=True)
class WorldSettings:
    """`domains`: robot name (its kind) → DDS domain. `http_port` 0 takes a free one. `ledger`: see `ledger.Ledger`."""

    domains: Mapping[str, int] = field(default_factory=lambda: {"go2": 1})
    interface: str = "lo"
    http_port: int = 0
    world: str = "room"
    seed: int = 0
    noise: bool = True
    ledger: Path | None = None


class Clockwork:
    """Runs a world in real time and does others' work between ticks."""

    def __init__(self, tick: Callable[[], None], period_s: float) -> None:
        self._tick, self._period_s = tick, period_s
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._recent: list[tuple[float, float]] = []
        self.tick_ms = 0.0

    def later(self, work: Callable[[], None]) -> None:
        """Have work done in the world's thread, at once between two ticks."""
        self._work.put(work)

    def stop(self) -> None:
        self._work.put(None)

    @property
    def real_time_factor(self) -> float:
        """Simulated per real time over the last seconds; 1.0 when the machine is fast enough."""
        recent = list(self._recent)
        if len(recent) < 2 or recent[-1][0] == recent[0][0]:
            return 1.0
        return (recent[-1][1] - recent[0][1]) / (recent[-1][0] - recent[0][0])

    def run(self) -> None:
        """Until stopped."""
        due = time.monotonic()
        simulated = 0.0
        while self._wait(due):
            began = time.monotonic()
            self._tick()
            ended = time.monotonic()
            simulated += self._period_s
            self.tick_ms += 0.02 * ((ended - began) * 1000 - self.tick_ms)
            if not self._recent or ended - self._recent[-1][0] > 0.5:
                self._recent = [*self._recent[-10:], (ended, simulated)]
            due += self._period_s
            if ended - due > LATE_S:
                due = ended

    def _wait(self, due: float) -> bool:
        """Do work until the next tick is due; False when stopped."""
        while True:
            left = due - time.monotonic()
            try:
                work = self._work.get(timeout=left) if left > 0 else self._work.get_nowait()
            except queue.Empty:
                return True
            if work is None:
                return False
            work()


def serve(settings: WorldSettings) -> None:
    """Serve until SIGTERM or SIGINT. Prints one JSON line on stdout when the robots stand.

    Raises `RobotBusy` when another world serves one of the domains, `SimError` for settings that cannot be.
    """
    for robot in settings.domains:
        if robot != "go2":
            raise SimError(f"no simulated robot named {robot!r}; there is: go2")
    if settings.world != "room":
        raise SimError(f"no world named {settings.world!r}; there is: room")
    with ExitStack() as stack:
        for domain in sorted(set(settings.domains.values())):
            name = f"world/{settings.interface}/{domain}"
            stack.enter_context(HostLock(name, f"the simulated world on DDS domain {domain} ({settings.interface})"))
        _serve(settings, stack)


def _serve(settings: WorldSettings, stack: ExitStack) -> None:
    from agentrob.sim.cameras import Cameras, front_view, overview
    from agentrob.sim.go2 import Go2
    from agentrob.sim.go2_services import Go2Services
    from agentrob.sim.ledger import Ledger
    from agentrob.sim.room_http import Room, RoomServer
    from agentrob.sim.services import Node
    from agentrob.sim.sport import Sport
    from agentrob.sim.world import PERIOD_S, World

    began = time.monotonic()
    ledger = Ledger(settings.ledger)
    stack.callback(ledger.close)
    bodies = {name: Go2(name) for name in settings.domains}
    world = World(list(bodies.values()))
    views = {f"{name}/front": front_view(world.model, name) for name in bodies}
    cameras = Cameras(world.model, {**views, "overview": overview(world.model)}, lambda: world.pose)
    stack.callback(cameras.close)
    rng = np.random.default_rng(settings.seed)
    sports = {name: Sport(body, lambda: world.time_s, ledger) for name, body in bodies.items()}

    def tick() -> None:
        for sport in sports.values():
            sport.tick()
        world.tick()
        for service in services:
            service.publish()

    clock = Clockwork(tick, PERIOD_S)
    services = [
        Go2Services(Node(domain, settings.interface), bodies[name], sports[name], cameras, clock.later, rng, settings.noise)
        for name, domain in settings.domains.items()
    ]

    def reset() -> bool:
        done = threading.Event()

        def work() -> None:
            world.reset()
            for sport in sports.values():
                sport.reset()
            for service in services:
                service.reset()
            done.set()

        clock.later(work)
        return done.wait(RESET_LIMIT_S)

    def truth() -> Mapping[str, Any]:
        return {"time_s": round(world.time_s, 3), "robots": {n: _truth(b) for n, b in bodies.items()}}

    def health() -> Mapping[str, Any]:
        return {
            "real_time_factor": round(clock.real_time_factor, 3),
            "tick_ms": round(clock.tick_ms, 2),
            "time_s": round(world.time_s, 2),
            "camera": cameras.backend,
            "frames_rendered": cameras.drawn,
            "frame_ms": round(1000 * cameras.seconds / max(1, cameras.drawn), 1),
            "trouble": [t for t in (cameras.trouble, ledger.trouble) if t],
        }

    server = RoomServer(Room(lambda: cameras.jpeg("overview"), reset, truth, health), settings.http_port)
    stack.callback(server.close)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: clock.stop())
    cameras.ready.wait(30)
    ready = {
        "ready": True,
        "http": server.url,
        "domains": dict(settings.domains),
        "interface": settings.interface,
        "camera": cameras.backend,
        "seconds": round(time.monotonic() - began, 2),
    }
    sys.stdout.write(json.dumps(ready) + "\n")
    sys.stdout.flush()
    clock.run()


def _truth(body: Any) -> Mapping[str, Any]:
    x, y = body.xy_m
    return {
        "x_m": float(x),
        "y_m": float(y),
        "z_m": body.z_m,
        "yaw_deg": math.degrees(body.yaw_rad),
        "upright": body.upright,
        "contacts": body.touching(),
    }


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="agentrob.sim.serve", description="Serve the simulated world on DDS.")
    parser.add_argument("--domain", type=int, default=1, help="DDS domain of the Go2 (default 1)")
    parser.add_argument("--interface", default="lo", help="network interface for DDS (default lo)")
    parser.add_argument("--http-port", type=int, default=0, help="port of the room's HTTP server (default: a free one)")
    parser.add_argument("--seed", type=int, default=0, help="of the sensors' noise")
    parser.add_argument("--no-noise", action="store_true", help="perfect sensors")
    parser.add_argument("--ledger", type=Path, help="append to this file what the robots really did")
    given = parser.parse_args(arguments)
    settings = WorldSettings(
        domains={"go2": given.domain},
        interface=given.interface,
        http_port=given.http_port,
        seed=given.seed,
        noise=not given.no_noise,
        ledger=given.ledger,
    )
    try:
        serve(settings)
    except AgentRobError as e:
        sys.stderr.write(f"{e}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
