"""A served world, a driver process and a remote control, each in its own process, with the ground truth of the
robot."""

from __future__ import annotations

import asyncio
import itertools
import json
import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import httpx2

from agentrob.errors import RobotError
from agentrob.model import RobotState
from agentrob.robots.driver.client import DriverClient

#: Different from those of other test modules.
DOMAINS = range(191, 201)
SAMPLE_S = 0.03
#: At rest: it moves less than this for this long.
REST_M, REST_DEG, REST_S = 0.012, 1.5, 0.4
FENCE = {"x_min_m": -1.0, "x_max_m": 2.5, "y_min_m": -1.0, "y_max_m": 0.2}

#: Imports everything, then waits for a line, so that a successor starts at once.
DRIVER = """
import json, sys
from pathlib import Path
from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError
from agentrob.robots.driver.process import run_driver
import agentrob.robots.unitree.go2, agentrob.robots.driver.api, agentrob.process.dds
import unitree_sdk2py.go2.sport.sport_client, unitree_sdk2py.go2.video.video_client
name, folder, settings = sys.argv[1], Path(sys.argv[2]), json.loads(sys.argv[3])
print("warm", flush=True)
sys.stdin.readline()
try:
    run_driver(name, RobotConfig(model="go2", simulated=True, **settings), folder / f"{name}.sock", folder)
except RobotError as e:
    sys.exit(str(e))
"""

#: The vendor's client as a remote control: an input line is a call, an output line its return code. `drive` continues
#: until the next line.
REMOTE = """
import os, sys, threading
from agentrob.process import dds
from unitree_sdk2py.core import channel
from unitree_sdk2py.core.channel import ChannelFactoryInitialize
from unitree_sdk2py.go2.sport.sport_client import SportClient
dds.use_in(channel)
ChannelFactoryInitialize(int(sys.argv[1]), "lo")
sport = SportClient()
sport.SetTimeout(5.0)
sport.Init()
print("warm", flush=True)
enough = threading.Event()
def drive(vx, turn):
    while not enough.wait(0.05):
        sport.Move(vx, 0.0, turn)
hand = None
for line in sys.stdin:
    if hand:
        enough.set(); hand.join(); enough.clear(); hand = None
    word, *numbers = line.split()
    if word == "drive":
        hand = threading.Thread(target=drive, args=tuple(map(float, numbers)), daemon=True)
        hand.start()
        print(0, flush=True)
    else:
        print(getattr(sport, word)(), flush=True)
os._exit(0)
"""


class Sample(NamedTuple):
    """Return where the robot really is, and when that was read (monotonic)."""

    at_s: float
    time_s: float
    x_m: float
    y_m: float
    z_m: float
    yaw_deg: float
    contacts: tuple[str, ...]


def apart_m(a: Sample, b: Sample) -> float:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)


def still(a: Sample, b: Sample) -> bool:
    turned = (a.yaw_deg - b.yaw_deg + 180) % 360 - 180
    return apart_m(a, b) < REST_M and abs(turned) < REST_DEG


class Truth:
    """Polls the room's `/truth` all the time, which no controller of a robot may do."""

    def __init__(self, url: str) -> None:
        self._room = httpx2.Client(base_url=url, timeout=100)
        self._closed = threading.Event()
        self.seen = [self._look()]
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def _look(self) -> Sample:
        truth = self._room.get("/truth").json()
        robot = truth["robots"]["go2"]
        place = (float(robot[k]) for k in ("x_m", "y_m", "z_m", "yaw_deg"))
        return Sample(time.monotonic(), truth["time_s"], *place, tuple(robot["contacts"]))

    def _watch(self) -> None:
        while not self._closed.wait(SAMPLE_S):
            self.seen.append(self._look())

    def close(self) -> None:
        self._closed.set()
        self._thread.join(60)
        self._room.close()

    @property
    def now(self) -> Sample:
        return self.seen[-1]

    def since(self, at_s: float) -> list[Sample]:
        return [s for s in list(self.seen) if s.at_s >= at_s]

    def longest_pause_s(self, since_s: float) -> float:
        """Return the longest time for which the world did not advance between two samples; a reset does not count."""
        seen = self.since(since_s)
        pauses = (b.at_s - a.at_s - (b.time_s - a.time_s) for a, b in itertools.pairwise(seen) if b.time_s >= a.time_s)
        return max(pauses, default=0.0)

    def speeds_mps(self, since_s: float, window_s: float = 0.5) -> list[float]:
        """Averages over windows of simulated time, so that a slow machine does not change them."""
        seen, found = self.since(since_s), []
        for first in seen:
            later = [s for s in seen if s.time_s >= first.time_s + window_s]
            if later:
                found.append(apart_m(first, later[0]) / (later[0].time_s - first.time_s))
        return found

    async def until(self, true: Callable[[Sample], Any], limit_s: float = 60.0) -> Sample:
        """Return the first sample from now on that meets a condition."""
        began_s = time.monotonic()
        while not ((now := self.now).at_s >= began_s and true(now)):
            assert time.monotonic() - began_s < limit_s, f"it did not become true: {now}"
            await asyncio.sleep(SAMPLE_S)
        return now

    async def rest(self, since_s: float, limit_s: float = 60.0) -> float:
        """Wait until the robot has stood still for a moment; return the seconds of simulated time until then.

        Simulated time, because on a busy machine the simulation is slower than real time.
        """
        end_s = time.monotonic() + limit_s
        while True:
            seen = self.since(since_s)
            if seen and seen[-1].at_s >= since_s + REST_S:
                first = next(k for k in range(len(seen)) if all(still(seen[k], s) for s in seen[k:]))
                if seen[-1].at_s - seen[first].at_s >= REST_S:
                    return seen[first].time_s - seen[0].time_s
            assert time.monotonic() < end_s, "it does not come to rest"
            await asyncio.sleep(SAMPLE_S)

    async def distance_after_m(self, at_s: float, seconds: float) -> float:
        """Return the distance that it covered in a window of this many seconds of the world's time, starting this long
        after a moment."""
        start_s = (self.since(at_s) or [await self.until(lambda now: True)])[0].time_s
        await self.until(lambda now: now.time_s >= start_s + 2 * seconds)
        seen = self.since(at_s)
        return apart_m(next(s for s in seen if s.time_s >= start_s + seconds), seen[-1])


class Process:
    """Start `python -c script`, which reports that it is warm and then waits for lines."""

    def __init__(self, script: str, *arguments: str, errors: int | None = None) -> None:
        command = [sys.executable, "-c", script, *arguments]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True
        )
        self._warm = False

    def warm(self) -> Process:
        """Wait until it is warm."""
        if not self._warm:
            self._warm = self.line() == "warm"
            assert self._warm, "it ended before it was ready"
        return self

    def line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def say(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()

    def ask(self, text: str) -> str:
        self.warm().say(text)
        return self.line()

    def end(self) -> None:
        self.process.kill()
        self.process.communicate()


class SimScene:
    """The whole scene; one per module."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.settings: dict[str, Any] = {}
        self.world, self.domain, url = _serve()
        self.room = httpx2.Client(base_url=url, timeout=100)
        self.truth = Truth(url)
        self.remote = Process(REMOTE, str(self.domain), errors=subprocess.DEVNULL)
        self.driver: Process | None = None
        self.successor: Process | None = None
        self.drive()

    def new_driver(self, name: str = "quadruped", errors: int | None = subprocess.DEVNULL, **settings: Any) -> Process:
        """Start a driver that waits for a line before it takes the robot."""
        given = {"domain": self.domain, "fence": FENCE, **settings}
        return Process(DRIVER, name, str(self.folder), json.dumps(given), errors=errors)

    def drive(self, **settings: Any) -> None:
        """Make sure that a driver with these settings holds the robot."""
        if self.driver is not None and self.settings == settings and self.driver.process.poll() is None:
            return
        if self.driver is not None:
            self.driver.end()
        self.driver, self.settings = self.new_driver(**settings), settings
        assert json.loads(self.driver.ask(""))["ready"] == "driver"

    def faults(self, **faults: Any) -> float:
        """Make the calls; return when they were made (monotonic)."""
        answer = self.room.post("/faults", json=faults)
        assert answer.status_code == 200, answer.text
        return time.monotonic()

    def client(self) -> DriverClient:
        return DriverClient("quadruped", self.folder / "quadruped.sock")

    async def begin(self, robot: DriverClient) -> Sample:
        """Reset everything: the robot is at its start, released and homed."""
        assert self.room.post("/reset").json() == {"reset": True}
        near_since_s = math.inf
        end_s = time.monotonic() + 60

        def near(state: RobotState) -> bool:
            pose = state.pose
            return state.age_s < 0.2 and pose is not None and max(abs(pose.x_m), abs(pose.y_m)) < 0.05

        while not time.monotonic() - near_since_s >= 0.4:  # the guard has seen the jump of the reset too
            assert time.monotonic() < end_s
            near_since_s = min(near_since_s, time.monotonic()) if near(await robot.state()) else math.inf
            await asyncio.sleep(0.03)
        await robot.release("owner")  # not earlier: the states of the last test may have halted it
        await self.home(robot)
        return await self.truth.until(lambda _: True)

    async def home(self, robot: DriverClient, limit_s: float = 60.0) -> None:
        """Set home at the robot's position as soon as it stands still enough: a body at rest still sways a little."""
        end_s = time.monotonic() + limit_s
        while True:
            try:
                return await robot.home("owner")
            except RobotError:
                assert time.monotonic() < end_s, "it never stood still enough"
                await asyncio.sleep(0.03)

    def longest_pause_s(self, since_s: float) -> float:
        """See `tests.pauses.PausableWorld`."""
        return self.truth.longest_pause_s(since_s)

    def close(self) -> None:
        self.truth.close()
        self.room.close()
        for process in (self.remote, self.driver, self.successor):
            if process is not None:
                process.end()
        self.world.terminate()
        self.world.communicate(timeout=100)


def _serve() -> tuple[subprocess.Popen[str], int, str]:
    """Start a world without cameras on the first free domain."""
    for domain in DOMAINS:
        process = subprocess.Popen(
            [sys.executable, "-m", "agentrob.sim.server", "--domain", str(domain)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "MUJOCO_GL": "off"},
        )
        assert process.stdout is not None
        if line := process.stdout.readline():
            return process, domain, json.loads(line)["http"]
        assert "already held" in process.communicate()[1]
    raise AssertionError(f"every domain of {DOMAINS} is taken")
