"""The process of the simulated world: real time, DDS services for every robot, the room's HTTP server.

`python -m agentrob.sim.server --help` runs it on its own. Only the world's thread accesses the physics; other threads
send it callbacks through a queue that it waits on between ticks, so that requests are answered at once.
"""

from __future__ import annotations

import argparse
import json
import math
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from agentrob.errors import AgentRobError, SimError
from agentrob.process.host_lock import HostLock

if TYPE_CHECKING:
    from agentrob.sim.services.unitree import RobotContext, RobotServices
    from agentrob.sim.world.legged import Legged
    from agentrob.sim.world.scene import Scene

ANSWER_LIMIT_S = 5.0
CAMERA_LIMIT_S = 20.0
LAST_DOMAIN = 230
FASTEST = 100
#: Each robot that can be simulated, and its usual DDS domain.
ROBOTS = {"go2": 1, "g1": 2}


@dataclass(frozen=True, slots=True)
class WorldSettings:
    """`domains` maps each robot (go2, g1) to its DDS domain; `http_port` 0 picks a free port.

    `world` is the name of a shipped world or the path of a world file (docs/robots/worlds.md); `event_log` is the file
    that `agentrob.sim.event_log.EventLog` appends to.
    `pace` is how many simulated seconds go by in a real one, at most. Above 1 the world waits for each command of a
    driver that walks a robot, and the driver reads the time off the stamps of its states.
    """

    domains: Mapping[str, int] = field(default_factory=lambda: {"go2": 1})
    interface: str = "lo"
    http_port: int = 0
    world: str = "room"
    seed: int = 0
    noise: bool = True
    event_log: Path | None = None
    pace: float = 1.0


def serve(settings: WorldSettings) -> None:
    """Serve until SIGTERM or SIGINT. Print a ready line (JSON, or text on a terminal) when the robots stand.

    Raises `RobotBusy` if another world serves one of the domains, `SimError` for invalid settings.
    """
    from agentrob.sim.world.scene import load

    _check(settings)
    scene = load(settings.world)
    for robot in settings.domains:
        scene.place(robot)
    with ExitStack() as stack:
        for domain in sorted(settings.domains.values()):
            name = f"world/{settings.interface}/{domain}"
            stack.enter_context(HostLock(name, f"the simulated world on DDS domain {domain} ({settings.interface})"))
        _Process(settings, scene, stack).run()


def _check(settings: WorldSettings) -> None:
    unknown = set(settings.domains) - set(ROBOTS)
    if unknown or not settings.domains:
        found = ", ".join(sorted(unknown)) or "none"
        raise SimError(f"unknown simulated robots: {found}; valid: {', '.join(ROBOTS)}")
    if len(set(settings.domains.values())) < len(settings.domains):
        raise SimError("each simulated robot needs a DDS domain of its own: their services have the same names")
    for domain in settings.domains.values():
        if not 0 <= domain <= LAST_DOMAIN:
            raise SimError(f"DDS domain {domain} is out of range; valid: 0 to {LAST_DOMAIN}")
    if not 0 < settings.pace <= FASTEST:
        raise SimError(f"pace {settings.pace:g} is out of range; valid: above 0 to {FASTEST}")
    interfaces = [name for _, name in socket.if_nameindex()]
    if settings.interface not in interfaces:
        raise SimError(f"no network interface {settings.interface!r} on this host; valid: {', '.join(interfaces)}")


class _Process:
    """The parts of the running server; `stack` closes them."""

    def __init__(self, settings: WorldSettings, scene: Scene, stack: ExitStack) -> None:
        import numpy as np

        from agentrob.sim.event_log import EventLog
        from agentrob.sim.realtime_loop import RealtimeLoop
        from agentrob.sim.rendering.cameras import Cameras
        from agentrob.sim.rendering.film import Film
        from agentrob.sim.rendering.view import front_view, overview
        from agentrob.sim.services.dds import Node
        from agentrob.sim.services.unitree import RobotContext
        from agentrob.sim.world.legged import PERIOD_S
        from agentrob.sim.world.world import World

        self.began_s = time.monotonic()
        self.settings, self.stack = settings, stack
        self.loop = RealtimeLoop(PERIOD_S, settings.pace)
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGTERM, signal.SIGINT):
                signal.signal(number, lambda *_: self.loop.stop())
        self.event_log = EventLog(settings.event_log)
        stack.callback(self.event_log.close)
        robots = {name: _robot(name) for name in settings.domains}
        self.bodies: dict[str, Legged] = {name: body for name, (body, _) in robots.items()}
        self.world = World(list(self.bodies.values()), scene)
        views = {f"{name}/front": front_view(self.world.model, name) for name in self.bodies}
        views["overview"] = overview(self.world.model)
        self.cameras = Cameras(self.world.model, views, lambda: self.world.pose)
        stack.callback(self.cameras.close)
        self.film = Film(self.world.model, self.bodies, self.cameras)
        rng = np.random.default_rng(settings.seed)

        def context(domain: int) -> RobotContext:
            node = Node(domain, settings.interface)
            call_soon = self.loop.call_soon
            return RobotContext(node, self.world, self.cameras, self.event_log, call_soon, rng, settings.noise)

        self.served = {name: serve(context(settings.domains[name])) for name, (_, serve) in robots.items()}

    def run(self) -> None:
        from agentrob.sim.services.room_http import Room, RoomServer

        describe = self.world.scene.description
        overview = lambda: self.cameras.jpeg("overview")  # noqa: E731
        film = self.film.picture
        room = Room(overview, describe, self.reset, self.truth, self.health, self.faults, self.geometry, film)
        server = RoomServer(room, self.settings.http_port)
        self.stack.callback(server.close)
        self.cameras.ready.wait(CAMERA_LIMIT_S)
        ready = {
            "ready": True,
            "world": self.world.scene.name,
            "http": server.url,
            "domains": dict(self.settings.domains),
            "interface": self.settings.interface,
            "camera": self.cameras.backend,
            "seconds": round(time.monotonic() - self.began_s, 2),
        }
        sys.stdout.write((announce(ready) if sys.stdout.isatty() else json.dumps(ready)) + "\n")
        sys.stdout.flush()
        if self.settings.pace > 1:
            self.loop.run(self.tick, lambda: any(services.awaits_command() for services in self.served.values()))
        else:
            self.loop.run(self.tick)

    def tick(self) -> None:
        for services in self.served.values():
            services.before_tick()
        self.world.tick()
        self.film.note(self.world.pose)
        for services in self.served.values():
            services.after_tick()

    # ------------------------------------------------------------------ for the room's HTTP server (its threads)
    def reset(self) -> bool:
        def work() -> None:
            self.world.reset()
            for services in self.served.values():
                services.reset()

        return self._in_world(work)

    def faults(self, asked: Any) -> bool:
        """Apply faults (`agentrob.sim.faults`). Raises `SimError` for invalid ones; False if the world hangs."""
        from agentrob.sim.faults import read

        faults = read(asked, self.served, self.world.scene.room.size_m)
        put: list[bool] = []

        def work() -> None:
            put.append(self.world.put_box(faults.box_m))
            if put[0]:
                for name in (faults.robot,) if asked else self.served:  # nothing wanted: all are well again
                    self.served[name].fail(replace(faults, robot=name))

        done = self._in_world(work)
        if put == [False]:
            raise SimError("the box cannot stand where a robot is; nothing was changed")
        return done

    def truth(self) -> Mapping[str, Any]:
        found: dict[str, Any] = {}

        def work() -> None:
            found["time_s"] = round(self.world.time_s, 3)
            found["robots"] = {name: _truth(body) for name, body in self.bodies.items()}

        return found if self._in_world(work) else {"error": "the world did not answer"}

    def geometry(self, robot: str) -> bytes | None:
        """The gzipped shape of a robot and its room; reads only the compiled model, which never changes."""
        from agentrob.sim.rendering.geometry import geometry

        body = self.bodies.get(robot)
        return None if body is None else geometry(self.world.model, body, self.world.scene)

    def health(self) -> Mapping[str, Any]:
        cameras = self.cameras
        return {
            "real_time_factor": round(self.loop.real_time_factor, 3),
            "tick_ms": round(self.loop.tick_ms, 2),
            "time_s": round(self.world.time_s, 2),
            "camera": cameras.backend,
            "frames_rendered": cameras.drawn,
            "frame_ms": round(1000 * cameras.seconds / max(1, cameras.drawn), 1),
            "trouble": [t for t in (cameras.last_error, self.event_log.last_error) if t],
        }

    def _in_world(self, work: Callable[[], None]) -> bool:
        """Run work in the world's thread, which alone may read the physics; False if that thread hangs."""
        done = threading.Event()

        def both() -> None:
            work()
            done.set()

        self.loop.call_soon(both)
        return done.wait(ANSWER_LIMIT_S)


def _robot(kind: str) -> tuple[Legged, Callable[[RobotContext], RobotServices]]:
    """Make a robot's body and its services."""
    if kind == "g1":
        from agentrob.sim.bodies.g1 import G1
        from agentrob.sim.services.g1 import G1Services

        g1 = G1(kind)
        return g1, lambda context: G1Services(g1, context)
    from agentrob.sim.bodies.go2 import Go2
    from agentrob.sim.services.go2 import Go2Services

    go2 = Go2(kind)
    return go2, lambda context: Go2Services(go2, context)


def parse_domains(texts: Sequence[str]) -> dict[str, int]:
    """Parse texts such as `go2=1` into robot → domain; a number alone is the Go2's. Raises `SimError`."""
    domains: dict[str, int] = {}
    for text in texts:
        robot, _, number = text.rpartition("=")
        if not number.isdigit():
            raise SimError(f"--domain {text!r} is not ROBOT=DOMAIN with a domain from 0 to 230, for example go2=1")
        domains[robot or "go2"] = int(number)
    return domains


def choose_domains(robots: Sequence[str], domains: Sequence[str]) -> dict[str, int]:
    """The domain of each requested robot: the given one, else its default. Raises `SimError`."""
    given = parse_domains(domains)
    wanted = [*robots, *(robot for robot in given if robot not in robots)] or ["go2"]
    return {robot: given.get(robot, ROBOTS.get(robot, LAST_DOMAIN)) for robot in wanted}


def announce(ready: Mapping[str, Any]) -> str:
    """Describe the world for a terminal."""
    robots = [f"{name} on DDS domain {domain}" for name, domain in ready["domains"].items()]
    return (
        f"\n  World    {ready['world']} (pictures: {ready['camera']})\n"
        f"  Robots   {', '.join(robots)}; interface {ready['interface']}\n"
        f"  Room     {ready['http']}/overview.jpg, /film/ROBOT.jpg, /scene, /health\n"
        f"  End      Ctrl-C\n"
    )


def _truth(body: Legged) -> Mapping[str, Any]:
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
    parser = argparse.ArgumentParser(prog="agentrob.sim.server", description="Serve the simulated world on DDS.")
    wanted = "ROBOT=DDS-DOMAIN, once for each robot; a number alone is the Go2's (default go2=1)"
    parser.add_argument("--domain", action="append", help=wanted)
    parser.add_argument("--world", default="room", help="the name of a shipped world, or the path of a world file")
    parser.add_argument("--interface", default="lo", help="network interface for DDS (default lo)")
    parser.add_argument("--http-port", type=int, default=0, help="port of the room's HTTP server (default: a free one)")
    parser.add_argument("--seed", type=int, default=0, help="of the sensors' noise")
    parser.add_argument("--no-noise", action="store_true", help="perfect sensors")
    parser.add_argument(
        "--pace", type=float, default=1.0, help="simulated seconds per real second, at most (default 1)"
    )
    parser.add_argument("--event-log", type=Path, help="append the robots' actual motions and gestures to this file")
    given = parser.parse_args(arguments)
    try:
        settings = WorldSettings(
            domains=parse_domains(given.domain or ["go2=1"]),
            interface=given.interface,
            http_port=given.http_port,
            world=given.world,
            seed=given.seed,
            noise=not given.no_noise,
            event_log=given.event_log,
            pace=given.pace,
        )
        serve(settings)
    except AgentRobError as e:
        sys.stderr.write(f"{e}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
