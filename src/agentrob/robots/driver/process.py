"""The process that owns a robot (law 11): it serves the guard, the leases and the stop channel
(docs/reference/interfaces.md).

Every program that moves the robot is a client of this process. Steps run one at a time for the holder of the lease; a
stop needs no lease, runs on a thread of its own, and ends the step and the lease.
"""

from __future__ import annotations

import contextlib
import json
import logging
import math
import os
import socket
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from agentrob.config.load import default_data_dir, runtime_dir
from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotBusy, RobotError
from agentrob.model import Pose
from agentrob.plugins import find
from agentrob.process.host_lock import HostLock, namespaced
from agentrob.process.signals import event_at_termination
from agentrob.robots.codec import display_name, encode
from agentrob.robots.driver.credentials import client_tls, token_of
from agentrob.robots.driver.driver import Driver
from agentrob.robots.driver.fencing import FencingNumbers
from agentrob.robots.protocol import Robot
from agentrob.robots.safety.crash_marker import CrashMarker, boot_id
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from agentrob.robots.zones.keeper import LocalKeeper, ZoneKeeper, room_file
from agentrob.robots.zones.member import RoomMember

log = logging.getLogger(__name__)

#: A line on the stop channel must come within this time.
LINE_S = 2.0


# ------------------------------------------------------------------ the process
def lock_name(name: str, settings: RobotConfig) -> str:
    """The host lock of a robot's driver, which is also the name of its stop channel. Fake robots of the same name
    differ by their domain.

    Only simulated robots have a namespace; a third-party robot on loopback may be real.
    """
    if settings.model == "fake":
        return namespaced(f"driver/fake/{settings.domain}/{name}" if settings.domain else f"driver/fake/{name}")
    lock = f"driver/{settings.interface}/{settings.domain}"
    return namespaced(lock) if settings.simulated and settings.interface == "lo" else lock


def make_robot(settings: RobotConfig) -> Robot:
    """Make the robot of the model that the settings name (entry points `agentrob.robots`). Raises `ConfigError`, also
    for operations that it declares in words that mean something else."""
    try:
        robot: Robot = find("robots", settings.model)(settings)
    except ValueError as e:
        raise ConfigError(f"the robot {settings.model!r} declares what is not possible: {e}") from None
    if robot.capabilities.declared:
        from agentrob.language.operations.clashes import refuse_clashes  # loads the languages

        try:
            refuse_clashes(robot.capabilities)
        except ConfigError:
            robot.close()
            raise
    return robot


def run_driver(name: str, settings: RobotConfig, socket_path: Path | None = None, data: Path | None = None) -> None:
    """Hold the robot until SIGTERM or SIGINT; the robot is stopped before this returns (within a second).

    Prints one line of JSON on standard output when it is ready. Raises `RobotBusy` if another driver holds this robot
    or this socket, `ConfigError` for a robot model that is not installed, or for certificates or a token of
    `driver_listen` that cannot be used. Call it from the main thread only.
    """
    from agentrob.robots.driver.api import DriverServer, app
    from agentrob.robots.driver.network import NetworkListener

    path = socket_path or runtime_dir() / f"{name}.sock"
    ended = event_at_termination()
    lock = lock_name(name, settings)
    with contextlib.ExitStack() as stack:
        held = stack.enter_context(HostLock(lock, f"the robot {name!r}"))
        listener = stack.enter_context(listening(path))
        network = stack.enter_context(NetworkListener(settings)) if settings.driver_listen else None
        out = stack.enter_context(_only_own_lines())
        folder = (data or default_data_dir()) / "drivers"
        halt, mark = Halt(folder / f"{name}.halt"), CrashMarker(folder / f"{name}.step")
        keeper = zone_keeper(settings, data or default_data_dir()) if settings.room else None
        room = None if keeper is None else _member(name, settings, keeper)
        guard = Guard(make_robot(settings), settings, halt, mark, room)
        kept = (settings.room, keeper) if isinstance(keeper, LocalKeeper) else None
        driver = Driver(name, guard, FencingNumbers(folder / f"{name}.fence"), kept)
        try:
            threading.Thread(target=serve_stops, args=(held.socket, driver), name="stop-channel", daemon=True).start()
            driver.guard.settle()
            if room is not None:
                room.start()
            with DriverServer(driver, listener), contextlib.ExitStack() as served:
                ready = {"ready": "driver", "robot": name, "socket": str(path), "lock": lock, "pid": os.getpid()}
                if network is not None:
                    served.enter_context(network.serve(app(driver, remote=True)))
                    ready["listen"] = network.address
                print(json.dumps(ready), file=out, flush=True)
                ended.wait()
                driver.close()
        except BaseException:
            driver.close()
            raise


def zone_keeper(settings: RobotConfig, data: Path) -> ZoneKeeper:
    """Whoever keeps the zones of the robot's room: a file in the data folder, or the driver at `room_url`. Raises
    `ConfigError` for certificates or a token that cannot be used."""
    if not settings.room_url:
        return LocalKeeper(room_file(data, settings.room), boot_id)
    from agentrob.robots.zones.http import RemoteKeeper

    return RemoteKeeper(settings.room, settings.room_url, client_tls(settings, settings.room_url), token_of(settings))


def _member(name: str, settings: RobotConfig, keeper: ZoneKeeper) -> RoomMember:
    (x_m, y_m), facing_rad = settings.map.home_at_m, math.radians(settings.map.home_facing_deg)
    return RoomMember(name, settings.room, keeper, home=Pose(x_m, y_m, facing_rad), error_m=settings.room_error_m)


@contextlib.contextmanager
def _only_own_lines() -> Iterator[Any]:
    """Yield standard output, and redirect the output of a robot's SDK to standard error meanwhile."""
    out = sys.stdout
    with contextlib.redirect_stdout(sys.stderr):
        yield out


@contextlib.contextmanager
def listening(path: Path) -> Iterator[socket.socket]:
    """A listening Unix socket at `path`, for this user only; it replaces a socket that a killed driver left."""
    _refuse_when_served(path)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    fresh.unlink(missing_ok=True)
    try:
        old_mask = os.umask(0o177)
        try:
            listener.bind(str(fresh))
        finally:
            os.umask(old_mask)
        listener.listen(64)
        ours = fresh.stat().st_ino
        fresh.replace(path)  # atomic: no client ever sees a socket that does not listen
    except OSError as e:
        listener.close()
        raise RobotError(f"cannot listen at {path}: {e.strerror or e}") from None
    try:
        yield listener
    finally:
        listener.close()
        with contextlib.suppress(FileNotFoundError):
            if path.stat().st_ino == ours:
                path.unlink()


def _refuse_when_served(path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.settimeout(1.0)
        try:
            probe.connect(str(path))
        except (FileNotFoundError, ConnectionRefusedError):
            return
        except OSError as e:
            raise RobotError(f"cannot use {path}: {e.strerror or e}") from None
    raise RobotBusy(f"another driver serves {path}; stop it first or give this robot another name")


# ------------------------------------------------------------------ the stop channel
def serve_stops(channel: socket.socket, driver: Driver) -> None:
    """Serve `stop <who>` and `halt <who>` on the lock's socket until it is closed, each in a thread of its own."""
    while True:
        try:
            connection, _ = channel.accept()
        except OSError:
            return
        threading.Thread(target=_serve_stop, args=(connection, driver), daemon=True).start()


def _serve_stop(connection: socket.socket, driver: Driver) -> None:
    with connection, contextlib.suppress(OSError):
        connection.settimeout(LINE_S)
        word, _, who = connection.makefile("r", encoding="utf-8", errors="replace").readline(200).strip().partition(" ")
        who = display_name(who) or "a local user"
        if word in ("stop", "halt"):
            answer = encode(driver.stop(who) if word == "stop" else driver.halt(who))
        else:
            answer = {"error": "unknown request; valid: stop NAME, halt NAME"}
        connection.settimeout(LINE_S)
        connection.sendall((json.dumps(answer) + "\n").encode())
