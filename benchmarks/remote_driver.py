"""Measure stops, leases and cut links between an agent and a driver on two hosts.

    python benchmarks/remote_driver.py [--trials 100] [--hold 300] [--cuts 10] [--json]

Needs root, /dev/net/tun and openssl. Two network namespaces stand for the hosts, joined by a link that delays and
loses IP packets (instruments/lossy_link.py); TCP, and TLS 1.3 with certificates on both sides, are real, the robot is a
fake one.

  a stop     while the robot walks, the client asks for a stop; time until the driver has ended the lease, which is when
             it commands zero velocity, and until the client has the answer, when the robot rests. Both processes have
             one monotonic clock, which only this benchmark makes use of
  the lease  the robot walks to and fro for `--hold` seconds under one lease after the other; lapses are counted
  a cut      the link loses everything while the robot walks; time until it stands still, seen on the Unix socket
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from instruments.lossy_link import SIDES, Link, lossy_link, usable

from agentrob.config.robots import RobotConfig
from agentrob.errors import LeaseLost, RobotError
from agentrob.model import Direction, Op, Primitive, RobotState
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.remote import driver_client

ROBOT, PORT = "bench", 8093
WALKS = [Primitive(Op.MOVE, direction, distance_m=4.5, speed_mps=0.2) for direction in Direction][:2]
NEW = "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -noenc -days 2"
SIGNED = "-CA ca.pem -CAkey ca.key -addext basicConstraints=critical,CA:FALSE"


class Condition(NamedTuple):
    said: str
    delay_s: float
    loss: float


CONDITIONS = (
    Condition("no delay", 0.0, 0.0),
    Condition("100 ms each way", 0.1, 0.0),
    Condition("100 ms each way, 2 % of the packets lost", 0.1, 0.02),
)


def main(argv: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=100, help="stops per link")
    parser.add_argument("--hold", type=float, default=300.0, help="seconds of walking per link")
    parser.add_argument("--cuts", type=int, default=10, help="cuts per link")
    parser.add_argument("--link", type=int, choices=range(len(CONDITIONS)), help="only this one")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--agent", help=argparse.SUPPRESS)
    given = parser.parse_args(argv)
    if given.agent:
        asyncio.run(agent(json.loads(given.agent), given.trials, given.hold, given.cuts))
        return 0
    if not usable():
        print("The link is absent: this benchmark needs root and /dev/net/tun.")
        return 0
    rows = []
    for condition in CONDITIONS if given.link is None else CONDITIONS[given.link :][:1]:
        rows.append({"link": condition.said, **measured(condition, given)})
        print(json.dumps(rows[-1]) if given.json else _line(rows[-1]), flush=True)
    return 0


def _line(row: dict[str, Any]) -> str:
    stop, rest, cut = (sorted(row[key]) for key in ("stop_ms", "answer_ms", "cut_ms"))
    cells = [row["link"], str(len(stop))]
    cells += [f"{_share(stop, p):.0f} ms" for p in (50, 99, 100)] + [f"{_share(rest, 50):.0f} ms"]
    cells += [f"{row['lapses']} in {row['held_s']:.0f} s", f"{_share(cut, 50):.0f} / {_share(cut, 100):.0f} ms"]
    return f"| {' | '.join(cells)} |"


def _share(ordered: list[float], percent: float) -> float:
    return ordered[min(len(ordered) - 1, int(len(ordered) * percent / 100))] if ordered else float("nan")


# ---------------------------------------------------------------------- both hosts
def measured(condition: Condition, given: argparse.Namespace) -> dict[str, Any]:
    """The figures of one link."""
    with tempfile.TemporaryDirectory() as temporary, lossy_link(condition.delay_s, condition.loss) as link:
        folder = Path(temporary)
        _certificates(folder)
        settings = {
            "model": "fake", "simulated": True, "home_on_start": True, "driver_listen": f"{SIDES['robot']}:{PORT}",
            "fence": {"x_min_m": -99, "x_max_m": 99, "y_min_m": -99, "y_max_m": 99},
            "options": {"room": [-99, 99, -99, 99], "faults": {"stop_s": 0.03}},
        }  # fmt: skip
        config = folder / "agentrob.toml"
        _write_config(config, {**settings, **_paths(folder, "driver")})
        env = {**os.environ, "AGENTROB_RUNTIME": temporary, "AGENTROB_DATA": temporary}
        command = [*link.inside("robot"), sys.executable, "-m", "agentrob", "driver", ROBOT, "--config", str(config)]
        with _child(command, env) as driver:
            ready = json.loads(driver.stdout.readline())  # type: ignore[union-attr]
            far = {"model": "fake", "driver_url": f"https://{SIDES['robot']}:{PORT}", **_paths(folder, "agent")}
            sizes = ["--trials", str(given.trials), "--hold", str(given.hold), "--cuts", str(given.cuts)]
            with _child(
                [*link.inside("agent"), sys.executable, __file__, "--agent", json.dumps(far), *sizes], env
            ) as us:
                return asyncio.run(_follow(us, link, Path(ready["socket"])))


async def _follow(us: subprocess.Popen[str], link: Link, socket: Path) -> dict[str, Any]:
    """Cut the link when the agent's side asks for it, and return its figures."""
    cut_ms: list[float] = []
    assert us.stdin is not None
    assert us.stdout is not None
    async with DriverClient(ROBOT, socket) as near:
        while line := await asyncio.to_thread(us.stdout.readline):
            told = json.loads(line)
            if told != "cut":
                return {**told, "cut_ms": cut_ms}
            link.cut()
            cut_s = time.monotonic()
            await _until(near, lambda state: abs((state.velocity_mps or (1.0, 0.0))[0]) < 0.02)
            cut_ms.append(1000 * (time.monotonic() - cut_s))
            await asyncio.sleep(1.0)
            link.cut(False)
            us.stdin.write("\n")
            us.stdin.flush()
    raise RuntimeError(f"the agent's side ended early; {(socket.parent.parent / 'log').read_text()}")


async def _until(robot: DriverClient, true: Callable[[RobotState], bool]) -> None:
    async with asyncio.timeout(60):
        while True:
            if true(await robot.state()):
                return
            await asyncio.sleep(0.005)


@contextlib.contextmanager
def _child(command: list[str], env: dict[str, str]) -> Any:
    with Path(env["AGENTROB_DATA"], "log").open("a") as log:
        child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, text=True, env=env)
        try:
            yield child
        finally:
            child.terminate()
            child.wait(10)


def _certificates(folder: Path) -> None:
    for arguments in (
        "-subj /CN=authority -keyout ca.key -out ca.pem",
        f"-subj /CN=driver -addext subjectAltName=IP:{SIDES['robot']} {SIGNED} -keyout driver.key -out driver.pem",
        f"-subj /CN=agent {SIGNED} -keyout agent.key -out agent.pem",
    ):
        subprocess.run([*NEW.split(), *arguments.split()], cwd=folder, check=True, capture_output=True)


def _paths(folder: Path, name: str) -> dict[str, str]:
    files = {"driver_cert": f"{name}.pem", "driver_key": f"{name}.key", "driver_ca": "ca.pem"}
    return {key: str(folder / file) for key, file in files.items()}


def _write_config(path: Path, settings: dict[str, Any]) -> None:
    from agentrob.config.load import Config

    Config(robots={ROBOT: RobotConfig.model_validate(settings)}).write(path)


# ---------------------------------------------------------------------- the agent's host
async def agent(settings: dict[str, Any], trials: int, hold_s: float, cuts: int) -> None:
    """Measure, and print the figures as one line of JSON; asks for each cut by a line."""
    remote = RobotConfig.model_validate(settings)
    async with driver_client(ROBOT, remote) as robot:
        await _until(robot, lambda state: state.homed)
        await asyncio.sleep(1.0)
        figures = {**await _stops(robot, trials), **await _held(robot, hold_s)}
    for number in range(cuts):
        async with driver_client(ROBOT, remote) as robot:
            await robot.state()
            await asyncio.sleep(1.5)
            with contextlib.suppress(RobotError):
                async with robot.lease("cut") as lease:
                    step = asyncio.create_task(robot.step(lease, WALKS[number % 2], 60))
                    await asyncio.sleep(1.0 + random.random() * 0.2)
                    print(json.dumps("cut"), flush=True)
                    await asyncio.to_thread(sys.stdin.readline)
                    step.cancel()
    print(json.dumps(figures), flush=True)


async def _stops(robot: DriverClient, trials: int) -> dict[str, Any]:
    stop_ms, answer_ms = [], []
    while len(stop_ms) < trials:
        async with robot.lease("stops") as lease:
            step = asyncio.create_task(robot.step(lease, WALKS[len(stop_ms) % 2], 60))
            await asyncio.sleep(0.6 + random.random() * 0.4)
            asked_s = time.monotonic()
            stopped = await robot.stop("the benchmark")
            answered_s = time.monotonic()
            assert stopped.confirmed
            await step
        _, reached_s = robot._own_stop
        stop_ms.append(1000 * (reached_s - asked_s))
        answer_ms.append(1000 * (answered_s - asked_s))
    return {"stop_ms": stop_ms, "answer_ms": answer_ms}


async def _held(robot: DriverClient, hold_s: float) -> dict[str, Any]:
    lapses, number, began_s = 0, 0, time.monotonic()
    while time.monotonic() - began_s < hold_s:
        number += 1
        try:
            async with robot.lease("walks") as lease:
                lapses += (await robot.step(lease, WALKS[number % 2], 60)).reason == "lease_lapsed"
        except LeaseLost:
            lapses += 1
    return {"lapses": lapses, "held_s": time.monotonic() - began_s}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
