"""Measure RPC round trips and 20 Hz commands, compared with raw publish/subscribe on the same network.

    python benchmarks/rpc.py [--calls 2000] [--walks 6]

Everything is measured between processes on the loopback, on one DDS domain, with the demo's simulated Go2:

  raw round trip  a message to an echo process and back: two plain cyclonedds topics of the RPC's own types
  RPC, service    the SDK's client, as our driver uses it, calls the simulated `motion_switcher`: answered at once
  RPC, world      the same client calls `sport` (BalanceStand): answered by the thread that computes the physics
  raw 20 Hz       a loop that writes every 50 ms; when a second process receives it
  driver 20 Hz    our driver walks the Go2 forward and back; when a second reader on the domain receives each Move

Jitter is the deviation of the interval between two arrivals from 50 ms. The receiver gets the highest priority that
the system allows, since the robot's own computer would not be busy. Each is measured idle, beside one busy process, and
beside one for each core. Wanted: RPC p50 at most 0.6 ms, and 20 Hz jitter p99 at most 10 ms beside a busy process.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from agentrob.config.load import Config
from agentrob.model import Direction, Op, Plan, Primitive
from agentrob.process.child import Child, terminate_all
from agentrob.robots.driver.client import run_plan
from agentrob.robots.unitree import sdk
from agentrob.sim.domains import PrivateDomain
from agentrob.sim.services.dds import REQUESTS, RESPONSES, Node  # before any type of the SDK
from agentrob.wiring import app

# isort: split
from unitree_sdk2py.comm.motion_switcher.motion_switcher_client import MotionSwitcherClient
from unitree_sdk2py.go2.sport.sport_client import SportClient
from unitree_sdk2py.idl.unitree_api.msg.dds_ import (
    Request_,
    RequestHeader_,
    RequestIdentity_,
    RequestLease_,
    RequestPolicy_,
)

MOVE, PERIOD_S = 1008, 0.05
OURSELVES = (sys.executable, __file__)
SETTLE_S = 1.0  # until two processes have found each other on DDS
THERE = Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0)
BACK = Primitive(Op.MOVE, Direction.BACKWARD, distance_m=2.0)
Row = tuple[str, list[float]]  # name, and times in ms


def message(number: int) -> Any:
    identity = RequestIdentity_(number, 1)
    return Request_(RequestHeader_(identity, RequestLease_(0), RequestPolicy_(0, True)), '{"x": 0.1}', [])


# ---------------------------------------------------------------------- the other processes
def echo(domain: int) -> None:
    """Echo each message, until standard input ends."""
    node = Node(domain, "lo")
    back = node.writer("rt/benchmark/back", Request_, RESPONSES)
    _reader = node.reader("rt/benchmark/there", Request_, back.write)
    print("ready", flush=True)
    sys.stdin.read()


def listen(domain: int, topic: str) -> None:
    """Print the arrival time of each message (seconds of the monotonic clock), once standard input ends.

    It represents the robot's computer, which would not be busy, so it gets the highest priority that the system allows.
    """
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    came: list[float] = []

    def take(request: Any) -> None:
        if request.header.identity.api_id in (1, MOVE):
            came.append(time.monotonic())

    node = Node(domain, "lo")  # kept: what it holds ends with it
    _reader = node.reader(topic, Request_, take)
    print("ready", flush=True)
    sys.stdin.read()
    print(json.dumps(came))


@contextlib.contextmanager
def beside(*arguments: str | int) -> Iterator[Callable[[], str]]:
    """Run this file as another process; the yielded function ends it and returns its output."""
    process = subprocess.Popen(
        [*OURSELVES, *map(str, arguments)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(SETTLE_S)
    try:
        yield lambda: process.communicate()[0]
    finally:
        if process.poll() is None:
            process.communicate()


def run(*arguments: str | float) -> str:
    """Run this file as another process that ends by itself, and return its output."""
    return subprocess.run([*OURSELVES, *map(str, arguments)], check=True, stdout=subprocess.PIPE, text=True).stdout


@contextlib.contextmanager
def busy(count: int) -> Iterator[None]:
    """Keep this number of processes busy."""
    spinning = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for process in spinning:
            process.kill()
            process.wait()


def ping(domain: int, calls: int) -> None:
    """Print the milliseconds of each echo."""
    node, came = Node(domain, "lo"), threading.Event()
    there = node.writer("rt/benchmark/there", Request_, RESPONSES)
    _reader = node.reader("rt/benchmark/back", Request_, lambda _: came.set())
    time.sleep(SETTLE_S)
    times = []
    for number in range(calls):
        came.clear()
        began = time.perf_counter()
        there.write(message(number))
        assert came.wait(5), "an echo did not come"
        times.append(1000 * (time.perf_counter() - began))
    print(json.dumps(times))


def tick(domain: int, seconds: float) -> None:
    """Write a message every 50 ms."""
    node = Node(domain, "lo")  # kept: what it holds ends with it
    writer = node.writer("rt/benchmark/even", Request_, REQUESTS)
    time.sleep(SETTLE_S)
    began = time.monotonic()
    for number in range(round(seconds / PERIOD_S)):
        writer.write(message(number))
        time.sleep(max(0.0, began + (number + 1) * PERIOD_S - time.monotonic()))


# ---------------------------------------------------------------------- what is measured
def raw_round_trips(domain: int, calls: int) -> list[float]:
    with beside("--echo", domain):
        times: list[float] = json.loads(run("--ping", domain, calls))
    return times


def calls_of(call: Callable[[], int], calls: int) -> list[float]:
    times = []
    for _ in range(calls):
        began = time.perf_counter()
        assert call() == 0
        times.append(1000 * (time.perf_counter() - began))
    return times


def raw_jitter(domain: int, seconds: float) -> list[float]:
    with beside("--listen", domain, "rt/benchmark/even") as end:
        run("--tick", domain, seconds)
        return uneven(json.loads(end()))


def driver_jitter(domain: int, socket: Path, walks: int) -> list[float]:
    with beside("--listen", domain, "rt/api/sport/request") as end:
        # two metres there and back, one plan each, so that it always has room
        results = [r for _ in range(walks) for r in run_plan("bench", Plan((THERE, BACK)), "benchmark", socket=socket)]
        came = json.loads(end())
    assert all(result.path for result in results), [result.message for result in results]
    steps = [[t for t in came if result.started_s <= t <= result.ended_s] for result in results]
    return [ms for step in steps for ms in uneven(step[:-1])]  # the last Move of a step is its end, at once


def uneven(came: Sequence[float]) -> list[float]:
    return [1000 * abs(b - a - PERIOD_S) for a, b in itertools.pairwise(came)]


def measure(domain: int, socket: Path, clients: Sequence[Any], calls: int, walks: int) -> Iterator[Row]:
    sport, switcher = clients
    yield "raw round trip", raw_round_trips(domain, calls)
    yield "RPC, service", calls_of(lambda: int(switcher.CheckMode()[0]), calls)
    yield "RPC, world", calls_of(lambda: int(sport.BalanceStand()), calls)
    yield "raw 20 Hz, jitter", raw_jitter(domain, 12.0 * walks)
    yield "driver 20 Hz, jitter", driver_jitter(domain, socket, walks)


def table(beside_what: str, rows: Iterator[Row]) -> None:
    for what, times in rows:
        ordered, n = sorted(times), len(times)
        figures = (ordered[n // 2], ordered[n * 99 // 100], ordered[-1])
        print(f"| {what} | {beside_what} | {n} | " + " | ".join(f"{ms:.2f} ms" for ms in figures) + " |", flush=True)


def benchmark(calls: int, walks: int) -> None:
    children = list[Child]()
    with contextlib.closing(PrivateDomain()) as own, tempfile.TemporaryDirectory(prefix="agentrob-rpc-") as folder:
        work, domain = Path(folder), own.number
        try:
            children.append(Child("world", ["sim", "--domain", f"go2={domain}"], work / "world.log"))
            children[0].wait_ready()
            config = Config(data=folder, robots={"bench": app.simulated_robot("go2", domain)})
            config.write(work / "agentrob.toml")
            arguments = ["driver", "bench", "--config", str(work / "agentrob.toml")]
            children.append(Child("driver", arguments, work / "driver.log", {"AGENTROB_RUNTIME": folder}))
            socket = Path(children[1].wait_ready()["socket"])
            sdk.connect(domain, "lo")
            clients = sdk.clients((SportClient, 5.0), (MotionSwitcherClient, 5.0))
            load = ", ".join(f"{value:.1f}" for value in os.getloadavg())
            print(f"load average at the beginning: {load}; {os.cpu_count()} cores\n")
            print("| what | beside | n | p50 | p99 | worst |\n|---|---|---|---|---|---|")
            for count, beside_what in (
                (0, "nothing"),
                (1, "a busy process"),
                (os.cpu_count() or 2, "one for each core"),
            ):
                with busy(count):
                    table(beside_what, measure(domain, socket, clients, calls, walks))
        finally:
            terminate_all(children)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--calls", type=int, default=2000, help="round trips of each kind (default 2000)")
    parser.add_argument(
        "--walks", type=int, default=6, help="walks of 2 m there and back in each condition (default 6)"
    )
    parser.add_argument("--echo", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--listen", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--ping", nargs=2, type=int, help=argparse.SUPPRESS)
    parser.add_argument("--tick", nargs=2, type=float, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.echo is not None:
        echo(given.echo)
    elif given.listen:
        listen(int(given.listen[0]), given.listen[1])
    elif given.ping:
        ping(*given.ping)
    elif given.tick:
        tick(int(given.tick[0]), given.tick[1])
    else:
        benchmark(given.calls, given.walks)


if __name__ == "__main__":
    main()
