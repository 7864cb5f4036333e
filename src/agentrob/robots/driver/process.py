"""The one process that holds a robot (law 11): guard, lease and stop channel, served as docs/seams.md says.

Whoever wants the robot to move is a client of this process. Steps run one at a time for the holder of the lease; a stop
needs no lease, runs on a thread of its own, and ends the step and the lease.
"""

from __future__ import annotations

import contextlib
import json
import logging
import math
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from agentrob.config.load import RobotConfig, default_data_dir, runtime_dir
from agentrob.errors import RobotBusy, RobotError
from agentrob.model import ActionResult, Lock, Pose, Primitive, RobotState, StopResult
from agentrob.plugins import find
from agentrob.process.host_lock import HostLock
from agentrob.robots.codec import encode, name_of
from agentrob.robots.driver.lease import Leases
from agentrob.robots.protocol import Robot
from agentrob.robots.safety.crash_marker import Mark
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt

log = logging.getLogger(__name__)

#: At most so long is waited for rest before the process ends.
LAST_STOP_S = 0.4
#: A new holder waits so long for the end of the last one's step: a robot comes to rest within 3 s.
TAKE_S = 4.0
#: Pictures for the record are taken no more often than this.
LOOK_S = 0.4
#: A line on the stop channel must come within this time.
LINE_S = 2.0


class Driver:
    """What the process does, without sockets: all calls are thread-safe."""

    def __init__(self, name: str, guard: Guard) -> None:
        self.name, self.guard = name, guard
        self.leases = Leases()
        self._step = threading.Lock()
        self._looking, self._looked_s = threading.Lock(), -LOOK_S

    @property
    def busy(self) -> bool:
        return self._step.locked()

    def state(self) -> RobotState:
        return self.guard.state()

    def take(self, holder: str, since_s: float | None = None) -> str:
        """A lease, once the last holder's step has come to rest; waits for that.

        `since_s` is when the command was accepted, by the monotonic clock; now when not given. Raises `RobotBusy`, and
        `LeaseLost` when a stop or a halt came since then, also while this waits.
        """
        asked_s = time.monotonic()
        since_s, end_s = asked_s if since_s is None else since_s, asked_s + TAKE_S
        self.leases.refuse_ended(since_s)
        while self.leases.holder is None and self.busy and time.monotonic() < end_s:
            time.sleep(0.02)
        if self.leases.holder is None and self.busy:
            raise RobotBusy("the robot is still ending the step of its last holder; try again in a moment")
        lease = self.leases.take(holder, since_s)
        log.info("lease to %s", holder)
        return lease

    def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        """Blocks until the step has ended. Raises `LeaseLost`, `RobotBusy`."""
        self.leases.renew(lease)
        if not self._step.acquire(blocking=False):
            raise RobotBusy("another step of this lease is still running")
        try:
            result = self.guard.step(primitive, lambda _: self.leases.lost(lease), deadline_s)
        finally:
            self._step.release()
        log.info("step %s %s: %s %s", primitive.op, primitive.asked(), result.outcome, result.message)
        return result

    def look(self) -> bytes:
        """A picture of the robot's own camera, for the record; at most every `LOOK_S`, whoever asks. `RobotBusy` when
        that is too soon or another look is under way."""
        if not self._looking.acquire(blocking=False):
            raise RobotBusy("another look through the robot's camera is under way")
        try:
            if time.monotonic() - self._looked_s < LOOK_S:
                raise RobotBusy(f"the robot's camera is looked through at most every {LOOK_S:g} s")
            self._looked_s = time.monotonic()
            return self.guard.look()
        finally:
            self._looking.release()

    def stop(self, by: str, asked_s: float | None = None, *, running_only: bool = False) -> StopResult:
        """Ends the running step and the lease: what its holder was about to do is over too, and so is what was accepted
        before; that is left with `running_only`, by which an agent ends a command of its own.

        `asked_s` is when it was asked for, by the monotonic clock; the latency counts from there.
        """
        asked_s = time.monotonic() if asked_s is None else asked_s
        ended_s = self.leases.end("stop", by, running_only=running_only)
        late_ms = 1000 * (time.monotonic() - asked_s)
        result = self.guard.stop()
        log.warning("stop by %s: %s", by, result)
        return replace(result, latency_ms=round(result.latency_ms + late_ms, 3), ended_s=ended_s)

    def halt(self, by: str) -> StopResult:
        ended_s = self.leases.end("halt", by)
        return replace(self.guard.halt(name_of(by)), ended_s=ended_s)

    def release(self, by: str, since_s: float = math.inf) -> Lock | None:
        """Let a locked robot move again. Nothing moves by this: what was accepted before the release is over (law 14).

        `since_s` is when it was asked for, by the monotonic clock. The lock that was taken away, None when there was
        none. Raises `RobotError` when it stays locked.
        """
        lock = self.guard.release(by, since_s)
        if lock is not None:
            self.leases.end("release", by)
        return lock

    def home(self, by: str) -> Pose:
        """Where the robot stands now is its home. Raises `RobotError`, also while anything moves."""
        if self.busy:
            raise RobotError("cannot set home while a step runs")
        return self.guard.home(name_of(by))

    def close(self) -> None:
        """Stop the robot, waiting for its rest only a moment, and let it go."""
        self.leases.end("shutdown")
        last = threading.Thread(target=self.guard.stop, daemon=True)
        last.start()
        last.join(LAST_STOP_S)
        self.guard.close()


# ------------------------------------------------------------------ the process
def lock_name(name: str, settings: RobotConfig) -> str:
    """The host lock of a robot's driver; also the name of its stop channel. A fake's domain tells namesakes apart."""
    if settings.model == "fake":
        return f"driver/fake/{settings.domain}/{name}" if settings.domain else f"driver/fake/{name}"
    return f"driver/{settings.interface}/{settings.domain}"


def make_robot(settings: RobotConfig) -> Robot:
    """The robot of the entry point (`agentrob.robots`) that the settings name. Raises `ConfigError`."""
    robot: Robot = find("robots", settings.model)(settings)
    return robot


def run_driver(name: str, settings: RobotConfig, socket_path: Path | None = None, data: Path | None = None) -> None:
    """Hold the robot until SIGTERM or SIGINT; the robot is stopped before this returns (within a second).

    Prints one line of JSON on standard output when it serves. Raises `RobotBusy` when another driver holds this robot
    or this socket, `ConfigError` for a robot model that is not installed. Call it from the main thread only.
    """
    from agentrob.robots.driver.api import Service

    path = socket_path or runtime_dir() / f"{name}.sock"
    ended = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: ended.set())
    lock = lock_name(name, settings)
    with HostLock(lock, f"the robot {name!r}") as held, listening(path) as listener, _only_own_lines() as out:
        folder = (data or default_data_dir()) / "drivers"
        halt, mark = Halt(folder / f"{name}.halt"), Mark(folder / f"{name}.step")
        driver = Driver(name, Guard(make_robot(settings), settings, halt, mark))
        try:
            threading.Thread(target=serve_stops, args=(held.socket, driver), name="stop-channel", daemon=True).start()
            driver.guard.settle()
            with Service(driver, listener):
                ready = {"ready": "driver", "robot": name, "socket": str(path), "lock": lock, "pid": os.getpid()}
                print(json.dumps(ready), file=out, flush=True)
                ended.wait()
                driver.close()
        except BaseException:
            driver.close()
            raise


@contextlib.contextmanager
def _only_own_lines() -> Iterator[Any]:
    """The real standard output; whatever a robot's SDK prints goes to standard error meanwhile."""
    out = sys.stdout
    with contextlib.redirect_stdout(sys.stderr):
        yield out


@contextlib.contextmanager
def listening(path: Path) -> Iterator[socket.socket]:
    """A listening Unix socket at `path`, for this user only; one that a killed driver left behind is replaced."""
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
        fresh.replace(path)  # at once: no client ever sees a socket that does not listen
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
        who = name_of(who) or "somebody local"
        if word in ("stop", "halt"):
            answer = encode(driver.stop(who) if word == "stop" else driver.halt(who))
        else:
            answer = {"error": "say: stop <who>, or halt <who>"}
        connection.settimeout(LINE_S)
        connection.sendall((json.dumps(answer) + "\n").encode())
