"""Measure a Reachy Mini against its maker's daemon in `--mockup-sim`: how exact it is, and how fast it stops.

    scripts/reachy-mini-daemon
    .venv/bin/python benchmarks/reachy_mini.py [--only accuracy|stop] [--runs 5] [--trials 100]

`accuracy`: angles by the daemon's own state, against what was asked. The mockup has no physics: this is what the way
of the commands adds, not what motors do. `stop`: a driver process is told to stop while the body turns, on its stop
channel, until the daemon says that it cancelled the move; after that it sends its motors nowhere else.
How far the body still turns after that is reported too.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import math
import socket
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from agentrob_reachy_mini.daemon import Daemon, DaemonLost
from agentrob_reachy_mini.pose import BodyPose, apart_rad
from agentrob_reachy_mini.robot import ReachyMini
from agentrob_reachy_mini.simulator import running_daemon
from websockets.sync.client import connect

from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.model import Direction, Op, Outcome, Primitive
from agentrob.process.child import Child, terminate_all
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.stop import stop_robot

WANTED_MS, TURNING_RPS, LIMIT_S = 50.0, 0.3, 30.0
L, R = Direction.LEFT, Direction.RIGHT


def act(name: str, **values: float | str) -> Primitive:
    return Primitive(name, arguments=tuple(values.items()))


#: What is asked, by which measured angle, and its sign.
STEPS = (
    (Primitive(Op.TURN, L, degrees=30.0), "body_yaw", 30.0),
    (Primitive(Op.TURN, L, degrees=120.0), "body_yaw", 120.0),
    (Primitive(Op.TURN, R, degrees=90.0), "body_yaw", -90.0),
    (act("look_up", angle_deg=20.0), "pitch", -20.0),
    (act("look_down", angle_deg=30.0), "pitch", 30.0),
    (act("glance", side="left", angle_deg=50.0), "neck_yaw", 50.0),
    (act("tilt_head", side="right", angle_deg=20.0), "roll", 20.0),
)


@contextmanager
def simulated() -> Iterator[RobotConfig]:
    """The daemon on a free port, and the settings of its robot."""
    listening = socket.create_server(("127.0.0.1", 0))
    url = f"http://127.0.0.1:{listening.getsockname()[1]}"
    with running_daemon(listening, url):
        yield RobotConfig(model="reachy-mini", simulated=True, home_on_start=True, options={"url": url})


def pose_of(daemon: Daemon) -> BodyPose:
    """Its pose, also on a machine so busy that an answer comes late."""
    for _ in range(20):
        with suppress(DaemonLost):
            return daemon.state().pose
    return daemon.state().pose


def straighten(daemon: Daemon) -> None:
    end_s = time.monotonic() + LIMIT_S
    while time.monotonic() < end_s:
        with suppress(DaemonLost):
            if not daemon.running():
                if apart_rad(pose_of(daemon), BodyPose()) < 0.01:
                    return
                daemon.goto(BodyPose(), 1.0)
        time.sleep(0.02)
    raise SystemExit("it does not come to rest")


def accuracy(runs: int) -> None:
    print("| step | error, worst |\n|---|---|")
    with simulated() as settings:
        robot, daemon = ReachyMini(settings), Daemon(settings.options["url"])
        for step, axis, degrees in STEPS:
            worst = 0.0
            for _ in range(runs):
                straighten(daemon)
                result = robot.step(step, lambda _: None)
                if result.outcome is not Outcome.DONE:
                    raise SystemExit(result.message)
                worst = max(worst, abs(math.degrees(getattr(pose_of(daemon), axis)) - degrees))
            asked = " ".join(str(value) for value in (step.op, *step.asked().values()))
            print(f"| {asked} | {worst:.2f}° |")
        robot.close()
        daemon.close()


class Ending(NamedTuple):
    """When the daemon said that it cancelled the move (monotonic seconds), and where the body was then."""

    at_s: float
    pose: BodyPose


class Observer:
    """Listens to what the daemon tells of its moves, over a WebSocket of its own, from `begin` on."""

    def __init__(self, url: str) -> None:
        self._daemon = Daemon(url)
        self._told = connect(f"ws{url.removeprefix('http')}/api/move/ws/updates", proxy=None)
        self.ending: Ending | None = None

    def begin(self) -> threading.Thread:
        self.ending = None
        thread = threading.Thread(target=self._observe)
        thread.start()
        return thread

    def _observe(self) -> None:
        end_s = time.monotonic() + LIMIT_S
        with suppress(TimeoutError):
            while json.loads(self._told.recv(max(0.0, end_s - time.monotonic())))["type"] != "move_cancelled":
                pass
            self.ending = Ending(time.monotonic(), pose_of(self._daemon))


def stops(trials: int) -> None:
    with simulated() as settings, tempfile.TemporaryDirectory(prefix="agentrob-reachy-") as folder:
        Config(data=folder, robots={"rosie": settings}).write(Path(folder) / "agentrob.toml")
        arguments = ["driver", "rosie", "--config", f"{folder}/agentrob.toml"]
        driver = Child("driver", arguments, Path(folder) / "driver.log", {"AGENTROB_RUNTIME": folder})
        try:
            path = Path(driver.wait_ready()["socket"])
            found, turned = asyncio.run(stop_often(path, settings, trials))
        finally:
            terminate_all([driver])
    found.sort()
    p50, p95, p99 = (found[min(len(found) - 1, math.ceil(share * len(found)) - 1)] for share in (0.5, 0.95, 0.99))
    print("| trials | p50 | p95 | p99 | worst | p99 at most | ok |\n|---|---|---|---|---|---|---|")
    print(
        f"| {len(found)} | {p50:.1f} ms | {p95:.1f} ms | {p99:.1f} ms | {found[-1]:.1f} ms | {WANTED_MS:.0f} ms "
        f"| {'yes' if p99 <= WANTED_MS else 'no'} |"
    )
    print(f"\nAfter that the body turned by at most {turned:.2f}°.")


async def stop_often(path: Path, settings: RobotConfig, trials: int) -> tuple[list[float], float]:
    """Milliseconds of each stop, and the most degrees that the body turned after one. A trial whose step the busy
    machine ended before the stop does not count."""
    url, found, turned_deg = settings.options["url"], list[float](), 0.0
    observer, daemon = Observer(url), Daemon(url)
    async with DriverClient("rosie", path) as client:
        while not (await client.state()).homed:  # noqa: ASYNC110  the driver tells nobody
            await asyncio.sleep(0.05)
        for _ in range(2 * trials):
            async with client.lease("benchmark") as lease:
                ended_ms = await stop_once(client, lease, settings, observer)
            if ended_ms is not None and observer.ending is not None:
                found.append(ended_ms)
                turned_deg = max(turned_deg, math.degrees(apart_rad(pose_of(daemon), observer.ending.pose)))
            if len(found) == trials:
                return found, turned_deg
    raise SystemExit(f"the machine is too busy: only {len(found)} of {2 * trials} steps were not ended by it")


async def stop_once(client: DriverClient, lease: str, settings: RobotConfig, observer: Observer) -> float | None:
    """Milliseconds from the request until the daemon cancelled the move; None for a step that ended before it."""
    pose = (await client.state()).pose
    side = R if pose is not None and pose.yaw_rad > 0 else L
    step = asyncio.ensure_future(client.step(lease, Primitive(Op.TURN, side, degrees=90.0), 30.0))
    while abs((await client.state()).yaw_rate_rps or 0.0) < TURNING_RPS:
        if step.done():
            return None
        await asyncio.sleep(0.01)
    thread, asked_s = observer.begin(), time.monotonic()
    await asyncio.to_thread(stop_robot, "rosie", settings, "benchmark")
    result = await step
    await asyncio.to_thread(thread.join)
    if result.reason != "stop" or observer.ending is None:
        return None
    return 1000 * (observer.ending.at_s - asked_s)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=("accuracy", "stop"), default="")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--trials", type=int, default=100)
    args = parser.parse_args()
    if args.only != "stop":
        accuracy(args.runs)
    if args.only != "accuracy":
        stops(args.trials)


if __name__ == "__main__":
    main()
