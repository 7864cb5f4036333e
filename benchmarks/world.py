"""Measure the speed and cost of the simulated world: `python benchmarks/world.py [--domain N] [--seconds S]`.

First in simulated time without a network, then served in real time with a Go2 and a G1: idle, both walking, and both
walking while three cameras (both robots' and the room's) are read ten times a second. Prints one line each.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx2
import numpy as np

from agentrob.sim.services.dds import Node  # patches DDS: before IDL types

# isort: split
from cyclonedds.core import Listener
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from unitree_sdk2py.idl.unitree_api.msg.dds_ import (
    Request_,
    RequestHeader_,
    RequestIdentity_,
    RequestLease_,
    RequestPolicy_,
    Response_,
)

GET_IMAGE_SAMPLE, MOVE, SET_VELOCITY = 1001, 1008, 7105
#: The call that makes each robot walk in a small circle, and its parameters.
WALKS = {
    "go2": (MOVE, {"x": 0.5, "y": 0.0, "z": 1.0}),
    "g1": (SET_VELOCITY, {"velocity": [0.2, 0.0, 0.5], "duration": 1.0}),
}


def in_simulated_time(seconds: float) -> None:
    from agentrob.sim.bodies.g1 import G1
    from agentrob.sim.bodies.go2 import Go2
    from agentrob.sim.world.world import World

    began = time.perf_counter()
    go2, g1 = Go2(), G1()
    world = World([go2, g1])
    print(f"built and standing in {time.perf_counter() - began:.2f} s")
    for name, velocities in (("standing", ([0, 0, 0],) * 2), ("walking in circles", ([0.5, 0, 1.0], [0.2, 0, 0.5]))):
        for body, velocity in zip((go2, g1), velocities, strict=True):
            body.walk(np.array(velocity, float))
        began = time.perf_counter()
        world.run(seconds)
        print(f"{name}, no cameras, no DDS: {seconds / (time.perf_counter() - began):.1f} times real time")


class Caller:
    """Sends requests to one robot without waiting for answers; counts the answers."""

    def __init__(self, robot: str, domain: int) -> None:
        self.robot = robot
        self.node = Node(domain, "lo")
        self.images: list[float] = []
        self.sport = self.node.writer("rt/api/sport/request", Request_, _reliable())
        self.video = self.node.writer("rt/api/videohub/request", Request_, _reliable())
        participant = self.node._participant
        topic = Topic(participant, "rt/api/videohub/response", Response_)
        self.answers = DataReader(participant, topic, listener=Listener(on_data_available=self._on_image))
        self.asked = 0.0

    def _on_image(self, reader: Any) -> None:
        for _ in reader.take(16):
            self.images.append(time.monotonic() - self.asked)

    def move(self) -> None:
        call, parameter = WALKS[self.robot]
        self.sport.write(_request(call, json.dumps(parameter)))

    def image(self) -> None:
        self.asked = time.monotonic()
        self.video.write(_request(GET_IMAGE_SAMPLE, ""))


def _reliable() -> Any:
    from agentrob.sim.services.dds import RESPONSES

    return RESPONSES


def _request(api_id: int, parameter: str) -> Any:
    identity = RequestIdentity_(time.monotonic_ns(), api_id)
    header = RequestHeader_(identity, RequestLease_(0), RequestPolicy_(0, api_id != GET_IMAGE_SAMPLE))
    return Request_(header, parameter, [])


def repeatedly(hz: float, call: Callable[[], Any], until: threading.Event) -> threading.Thread:
    def loop() -> None:
        due = time.monotonic()
        while not until.wait(max(0.0, due - time.monotonic())):
            call()
            due = max(due + 1 / hz, time.monotonic())

    thread = threading.Thread(target=loop, daemon=True)
    thread.start()
    return thread


def cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def phase(name: str, world: subprocess.Popen[str], url: str, seconds: float, loops: list[tuple[float, Any]]) -> None:
    until = threading.Event()
    threads = [repeatedly(hz, call, until) for hz, call in loops]
    time.sleep(1.0)
    before = httpx2.get(url + "/health").json()
    cpu, began = cpu_s(world.pid), time.monotonic()
    time.sleep(seconds)
    real = time.monotonic() - began
    cpu = (cpu_s(world.pid) - cpu) / real
    after = httpx2.get(url + "/health").json()
    until.set()
    for thread in threads:
        thread.join()
    factor = (after["time_s"] - before["time_s"]) / real
    frames = (after["frames_rendered"] - before["frames_rendered"]) / real
    print(
        f"{name}: real-time factor {factor:.3f}, {cpu:.2f} of a core, tick {after['tick_ms']:.1f} ms, "
        f"{frames:.1f} pictures/s ({after['camera']}, {after['frame_ms']:.0f} ms each)"
    )


def served(domain: int, seconds: float) -> None:
    began = time.monotonic()
    domains = {"go2": domain, "g1": domain + 1}
    options = [word for robot, number in domains.items() for word in ("--domain", f"{robot}={number}")]
    command = [sys.executable, "-m", "agentrob.sim.server", *options]
    world = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert world.stdout is not None
    try:
        ready = json.loads(world.stdout.readline())
        print(f"start to ready: {time.monotonic() - began:.2f} s")
        url = ready["http"]
        callers = [Caller(robot, number) for robot, number in domains.items()]
        phase("served, idle", world, url, seconds, [])
        walking: list[tuple[float, Any]] = [(20, caller.move) for caller in callers]
        phase("served, both walking", world, url, seconds, walking)
        overview = httpx2.Client()
        looking = [*((10, caller.image) for caller in callers), (10, lambda: overview.get(url + "/overview.jpg"))]
        phase("served, both walking, three cameras at 10 Hz", world, url, seconds, walking + looking)
        truth = httpx2.get(url + "/truth").json()["robots"]
        print("upright at the end: " + ", ".join(f"{name} {pose['upright']:.3f}" for name, pose in truth.items()))
        for caller in callers:
            if caller.images:
                p50, p99 = np.percentile(caller.images, [50, 99]) * 1000
                print(
                    f"{caller.robot} GetImageSample: p50 {p50:.0f} ms, p99 {p99:.0f} ms, {len(caller.images)} answers"
                )
    finally:
        began = time.monotonic()
        world.terminate()
        world.wait(10)
        print(f"SIGTERM to end: {time.monotonic() - began:.2f} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--domain", type=int, default=221)
    parser.add_argument("--seconds", type=float, default=10.0)
    given = parser.parse_args()
    print(f"load average before: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    in_simulated_time(given.seconds)
    served(given.domain, given.seconds)


if __name__ == "__main__":
    main()
