"""The simulated Reachy Mini of the demo: the daemon of its maker in its `--mockup-sim` mode, or a small one of our own.

agentrob simulator reachy-mini --domain 42       # needs reachy-mini-daemon
agentrob simulator reachy-mini-sim --domain 43   # needs nothing else
"""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from agentrob.config.map import MapConfig
from agentrob.config.robots import RobotConfig
from agentrob.errors import SimError
from agentrob.process.child import print_line, print_ready
from agentrob_reachy_mini.daemon import Daemon, DaemonLost, DaemonRefused
from agentrob_reachy_mini.simulated_daemon import SimulatedDaemon

#: The path of reachy-mini-daemon where it is not on the PATH.
VARIABLE = "AGENTROB_REACHY_MINI_DAEMON"
#: Where `scripts/reachy-mini-daemon` puts it in a checkout.
IN_CHECKOUT = ".venv-reachy-mini/bin/reachy-mini-daemon"
FIRST_PORT = 18300
START_S, END_S = 60.0, 8.0
SCENE = "It stands on a desk of 1.6 m by 0.8 m. In front of it is free space; behind it is a wall."
ARGUMENTS = (
    "--mockup-sim", "--no-media", "--headless", "--no-preload-datasets", "--dataset-update-interval", "0",
    "--no-goto-sleep-on-stop", "--log-level", "WARNING",
)  # fmt: skip
ISOLATION = ("unshare", "--user", "--map-root-user", "--net")


def find_daemon() -> str:
    """The path of the installed daemon. Raises `SimError`, which says how to install it."""
    for place in (os.environ.get(VARIABLE, ""), "reachy-mini-daemon", IN_CHECKOUT):
        if place and (found := shutil.which(place)):
            return found
    raise SimError(
        "reachy-mini-daemon is not installed: run scripts/reachy-mini-daemon in a checkout, or install reachy-mini in "
        f"an environment of its own and set {VARIABLE} to the path of the daemon; --robot reachy-mini-sim needs neither"
    )


def simulated(settings: RobotConfig) -> RobotConfig:
    """The settings of a robot whose daemon listens on the port of its domain, on loopback."""
    options = {**settings.options, "url": f"http://127.0.0.1:{FIRST_PORT + settings.domain}"}
    desk = MapConfig(room="desk", size_m=(2.0, 2.0), geometry="none")
    return settings.model_copy(update={"options": options, "map": desk, "scene": SCENE})


def listen(settings: RobotConfig) -> socket.socket:
    """A socket that listens on the port of the domain. Raises `SimError` if another program has it."""
    port = FIRST_PORT + settings.domain
    try:
        return socket.create_server(("127.0.0.1", port))
    except OSError as e:
        raise SimError(f"port {port} of this machine is in use ({e.strerror}); the simulation needs it") from None


class BuiltInSimulator:
    """See `agentrob.robots.protocol.Simulator`: a daemon of our own."""

    def settings(self, settings: RobotConfig) -> RobotConfig:
        return simulated(settings)

    def serve(self, settings: RobotConfig, ended: threading.Event) -> None:
        daemon = SimulatedDaemon(listen(settings))
        try:
            print_ready(domain=settings.domain, interface=settings.interface)
            ended.wait()
        finally:
            daemon.close()


class DaemonSimulator:
    """See `agentrob.robots.protocol.Simulator`: the daemon of the robot's maker, without a network."""

    def settings(self, settings: RobotConfig) -> RobotConfig:
        find_daemon()
        return simulated(settings)

    def serve(self, settings: RobotConfig, ended: threading.Event) -> None:
        with running_daemon(listen(settings), f"http://127.0.0.1:{FIRST_PORT + settings.domain}") as process:
            print_ready(domain=settings.domain, interface=settings.interface)
            while not ended.wait(0.5):
                if process.poll() is not None:
                    raise SimError(f"reachy-mini-daemon ended with code {process.returncode}")


@contextlib.contextmanager
def running_daemon(listening: socket.socket, url: str, cache: Path | None = None) -> Iterator[subprocess.Popen[bytes]]:
    """Run the daemon in `--mockup-sim` until the end of the block; yields its process once it answers.

    `cache`: the folder of recorded moves, by default the user's own (`HF_HOME`). Raises `SimError` if it does not
    start.
    """
    found = find_daemon()
    with tempfile.TemporaryDirectory(prefix="reachy-mini-") as home:
        moves = cache or Path(os.environ.get("HF_HOME", Path.home() / ".cache/huggingface"))
        environment = {
            **os.environ, "HOME": home, "HF_HOME": str(moves), "HF_HUB_OFFLINE": "1", "REACHY_MINI_TELEMETRY": "0",
        }  # fmt: skip
        relay = [
            sys.executable,
            "-m",
            "agentrob_reachy_mini.isolated",
            str(listening.fileno()),
            "--",
            found,
            *ARGUMENTS,
        ]
        process = subprocess.Popen(
            [*_isolation(), *relay], env=environment, stdin=subprocess.DEVNULL, stdout=sys.stderr,
            pass_fds=[listening.fileno()], start_new_session=True,
        )  # fmt: skip
        listening.close()
        try:
            _wait_ready(process, url)
            yield process
        finally:
            _end(process)


def _isolation() -> tuple[str, ...]:
    """The command in front of the daemon's that keeps it off every network; empty where the system has none."""
    allowed = shutil.which(ISOLATION[0]) and subprocess.run(
        [*ISOLATION, "true"], check=False, capture_output=True, timeout=10
    )
    if allowed and allowed.returncode == 0:
        return ISOLATION
    print_line(note="this system has no network namespaces: the simulated Reachy Mini announces itself by mDNS")
    return ()


def _wait_ready(process: subprocess.Popen[bytes], url: str) -> None:
    daemon, end_s = Daemon(url), time.monotonic() + START_S
    try:
        while time.monotonic() < end_s:
            if process.poll() is not None:
                raise SimError(f"reachy-mini-daemon did not start (code {process.returncode}); its log says why")
            with contextlib.suppress(DaemonLost, DaemonRefused):
                daemon.state()
                return
            time.sleep(0.1)
        raise SimError(f"reachy-mini-daemon did not answer within {START_S:.0f} s")
    finally:
        daemon.close()


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
