"""Measure a ROS 2 base against an rclpy node over Fast DDS: accuracy by the truth of its world, and stops.

    scripts/ros2-peers
    .venv/bin/python benchmarks/ros2.py [--only accuracy|stop] [--runs 10] [--trials 100]

`accuracy`: the driver's robot in this process moves a simulated differential base (wheels with a lag and slip, encoders
of their own, 50 Hz odometry) at its default limits; errors are against the base's true pose, along and across the way.
`stop`: a driver process is told to stop while it drives, on its stop channel, until the rclpy node has received zero
velocity on /cmd_vel, with no other velocity after it.
"""

from __future__ import annotations

import argparse
import asyncio
import itertools
import math
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from agentrob_ros2.base import Ros2Base

from agentrob.config.load import Config
from agentrob.model import Direction, Op, Outcome, Primitive
from agentrob.process.child import Child, terminate_all
from agentrob.robots.control.controller import wrap
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.stop import stop_robot

sys.path.insert(0, str(Path(__file__).parents[1] / "plugins/ros2/tests"))
from ros2_peer import Peer

F, B, L, R = Direction
STEPS = (
    *(Primitive(Op.MOVE, F, distance_m=d) for d in (0.25, 0.5, 1.0, 2.0)),
    Primitive(Op.MOVE, B, distance_m=0.5),
    Primitive(Op.MOVE, F, distance_m=1.0, speed_mps=0.2),
    *(Primitive(Op.TURN, L, degrees=a) for a in (15.0, 45.0, 90.0, 180.0)),
    Primitive(Op.TURN, R, degrees=90.0),
)
WANTED_M, WANTED_DEG, WANTED_MS = 0.05, 4.0, 50.0


class Error(NamedTuple):
    """The true error: metres along and across the way, and degrees."""

    along_m: float
    across_m: float
    turn_deg: float

    @property
    def ok(self) -> bool:
        return math.hypot(self.along_m, self.across_m) <= WANTED_M and abs(self.turn_deg) <= WANTED_DEG


def accuracy(runs: int) -> None:
    peer = Peer()
    peer.ask(clear=True)
    robot = Ros2Base(peer.settings())
    found: dict[Primitive, list[Error]] = {step: [] for step in STEPS}
    failed = 0
    try:
        wait_ready(robot)
        for _, step in itertools.product(range(runs), STEPS):
            peer.ask(pose=[0.0, 0.0, 0.0])
            result = robot.step(step, lambda _: None)
            failed += result.outcome is not Outcome.DONE
            found[step].append(error_of(step, peer.ask()))
    finally:
        robot.close()
        peer.close()
    print("| step | along, worst | across, worst | turned, worst | within 5 cm and 4° |\n|---|---|---|---|---|")
    for step, errors in found.items():
        asked = f"{step.distance_m:g} m" if step.distance_m else f"{step.degrees:g}°"
        speed = f" at {step.speed_mps:g} m/s" if step.speed_mps else ""
        along, across, turned = (max(abs(e[i]) for e in errors) for i in range(3))
        share = sum(e.ok for e in errors) / len(errors)
        print(
            f"| {step.op} {step.direction} {asked}{speed} | {100 * along:.1f} cm | {100 * across:.1f} cm "
            f"| {turned:.1f}° | {share:.0%} |"
        )
    errors = [error for all_of_step in found.values() for error in all_of_step]
    share = sum(e.ok for e in errors) / len(errors)
    print(f"\n{len(errors)} steps, {share:.1%} within 5 cm and 4° by the truth (wanted: 95 %)")
    print(f"{failed} steps were not reported as done")


def error_of(step: Primitive, truth: dict[str, float]) -> Error:
    x, y, yaw = truth["x_m"], truth["y_m"], truth["yaw_rad"]
    if step.op is Op.MOVE:
        sign = 1.0 if step.direction is F else -1.0
        return Error(sign * x - (step.distance_m or 0.0), y, math.degrees(wrap(yaw)))
    sign = 1.0 if step.direction is L else -1.0
    return Error(x, y, math.degrees(wrap(yaw - sign * math.radians(step.degrees or 0.0))))


def wait_ready(robot: Ros2Base) -> None:
    end_s = time.monotonic() + 30.0
    while robot.state().age_s > 0.2 or None in robot.state().ranges_m:
        if time.monotonic() > end_s:
            raise SystemExit(robot.silence())
        time.sleep(0.02)


def stops(trials: int) -> None:
    peer = Peer()
    peer.ask(clear=True)
    settings = peer.settings()
    with tempfile.TemporaryDirectory(prefix="agentrob-ros2-") as folder:
        Config(data=folder, robots={"base": settings}).write(Path(folder) / "agentrob.toml")
        arguments = ["driver", "base", "--config", f"{folder}/agentrob.toml"]
        driver = Child("driver", arguments, Path(folder) / "driver.log", {"AGENTROB_RUNTIME": folder})
        try:
            path = Path(driver.wait_ready()["socket"])
            found = asyncio.run(stop_often(peer, path, settings, trials))
        finally:
            terminate_all([driver])
            peer.close()
    found.sort()
    p50, p95, p99 = (found[min(len(found) - 1, math.ceil(share * len(found)) - 1)] for share in (0.5, 0.95, 0.99))
    print("| trials | p50 | p95 | p99 | worst | p99 at most | ok |\n|---|---|---|---|---|---|---|")
    ok = p99 <= WANTED_MS
    print(
        f"| {len(found)} | {p50:.1f} ms | {p95:.1f} ms | {p99:.1f} ms | {found[-1]:.1f} ms | {WANTED_MS:.0f} ms "
        f"| {'yes' if ok else 'no'} |"
    )


async def stop_often(peer: Peer, path: Path, settings: object, trials: int) -> list[float]:
    found: list[float] = []
    ways = itertools.cycle([Primitive(Op.MOVE, F, distance_m=1.5), Primitive(Op.MOVE, B, distance_m=1.5)])
    async with DriverClient("base", path) as client:
        while not (await client.state()).homed:  # noqa: ASYNC110  the driver tells nobody
            await asyncio.sleep(0.05)
        while len(found) < trials:
            async with client.lease("benchmark") as lease:
                step = asyncio.ensure_future(client.step(lease, next(ways), 30.0))
                while abs(((await client.state()).velocity_mps or (0.0, 0.0))[0]) < 0.3:
                    if step.done():
                        raise SystemExit(f"the step ended early: {step.result()}")
                    await asyncio.sleep(0.01)
                peer.ask(commands=True)
                asked_s = time.monotonic()
                await asyncio.to_thread(stop_robot, "base", settings, "benchmark")
                await step
            heard = [c for c in peer.ask(commands=True)["commands"] if c[0] >= asked_s]
            moving = [at_s for at_s, forward, turn in heard if forward or turn]
            last_s = max(moving, default=asked_s)
            found.append(1000 * (min(at_s for at_s, *_ in heard if at_s > last_s or not moving) - asked_s))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=("accuracy", "stop"))
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--trials", type=int, default=100)
    args = parser.parse_args()
    parts = {"accuracy": lambda: accuracy(args.runs), "stop": lambda: stops(args.trials)}
    for name, part in parts.items():
        if args.only in (None, name):
            part()


if __name__ == "__main__":
    main()
