"""Measure the simulated SO-101 arm: stops at its interface, picking up the red cube, and angles.

    .venv/bin/python benchmarks/so101.py [--only stop|pick|angles] [--trials 100] [--cubes 20] [--runs 5]

`stop`: a driver process is told to stop while the arm waves, on its stop channel, until the arm's world, a process of
its own, has received the goal to stay where it is, with no other goal after it.
`pick`: the red cube lies anywhere within reach before the arm, turned any way; it counts as picked up if it is 5 cm
above the table at the end by the truth of the world.
`angles`: what a step asked for, and where the joints are by the truth of the world.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import random
import sys
import tempfile
import time
from pathlib import Path

from agentrob_so101.arm import So101
from agentrob_so101.picking import AXIS_M
from agentrob_so101.pose import ArmPose, farthest_deg

from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.model import Op, Primitive
from agentrob.process.child import Child, terminate_all
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.stop import stop_robot

sys.path.insert(0, str(Path(__file__).parents[1] / "plugins/so101/tests"))
from so101_world import WorldProcess, until

WANTED_MS, LIFTED_M = 50.0, 0.05
#: Where the cube lies: metres from the axis of the pan joint, degrees to either side.
NEAR_M, FAR_M, ASIDE_DEG = 0.14, 0.26, 55.0


def stops(trials: int) -> None:
    with tempfile.TemporaryDirectory(prefix="agentrob-so101-") as folder:
        world = WorldProcess(Path(folder))
        settings = world.settings()
        Config(data=folder, robots={"arm": settings}).write(Path(folder) / "agentrob.toml")
        arguments = ["driver", "arm", "--config", f"{folder}/agentrob.toml"]
        driver = Child("driver", arguments, Path(folder) / "driver.log", {"AGENTROB_RUNTIME": folder})
        try:
            path = Path(driver.wait_ready()["socket"])
            found = asyncio.run(stop_often(world, path, settings, trials))
        finally:
            terminate_all([driver])
            world.close()
    found.sort()
    p50, p95, p99 = (found[min(len(found) - 1, math.ceil(share * len(found)) - 1)] for share in (0.5, 0.95, 0.99))
    print("| trials | p50 | p95 | p99 | worst | p99 at most | ok |\n|---|---|---|---|---|---|---|")
    print(
        f"| {len(found)} | {p50:.1f} ms | {p95:.1f} ms | {p99:.1f} ms | {found[-1]:.1f} ms | {WANTED_MS:.0f} ms "
        f"| {'yes' if p99 <= WANTED_MS else 'no'} |"
    )


async def stop_often(world: WorldProcess, path: Path, settings: RobotConfig, trials: int) -> list[float]:
    found: list[float] = []
    async with DriverClient("arm", path) as client:
        while not (await client.state()).homed:  # noqa: ASYNC110  the driver tells nobody
            await asyncio.sleep(0.05)
        while len(found) < trials:
            async with client.lease("benchmark") as lease:
                step = asyncio.ensure_future(client.step(lease, Primitive(Op.HELLO), 40.0))
                while (await client.state()).mode != "gesture":
                    if step.done():
                        raise SystemExit(f"the step ended early: {step.result()}")
                    await asyncio.sleep(0.01)
                world.apply(goals=True)
                asked_s = time.monotonic()
                await asyncio.to_thread(stop_robot, "arm", settings, "benchmark")
                await step
            last_s = max((at_s for at_s, _ in world.apply(goals=True)["goals"]), default=asked_s)
            found.append(1000 * (last_s - asked_s))
    return found


def picks(cubes: int) -> None:
    chosen, lifted, reported = random.Random(101), 0, 0
    with tempfile.TemporaryDirectory(prefix="agentrob-so101-") as folder:
        world = WorldProcess(Path(folder))
        robot = So101(world.settings())
        operation = robot.capabilities.operation("pick_up_cube")
        try:
            for _ in range(cubes):
                away_m, aside = chosen.uniform(NEAR_M, FAR_M), math.radians(chosen.uniform(-ASIDE_DEG, ASIDE_DEG))
                place = [AXIS_M + away_m * math.cos(aside), away_m * math.sin(aside), chosen.uniform(0.0, math.pi / 2)]
                world.apply(cube=place)
                result = robot.step(Primitive("pick_up_cube", declared=operation), lambda _: None)
                up = world.apply()["cube"][2] > LIFTED_M
                lifted, reported = lifted + up, reported + (result.ok == up)
                if not up:
                    print(f"not lifted from {place}: {result.reason} {result.message}")
        finally:
            robot.close()
            world.close()
    print(f"{lifted} of {cubes} cubes picked up by the truth; {reported} of {cubes} reports say what is true")


def angles(runs: int) -> None:
    worst, pointed = 0.0, 0.0
    with tempfile.TemporaryDirectory(prefix="agentrob-so101-") as folder:
        world = WorldProcess(Path(folder))
        robot = So101(world.settings())
        point = robot.capabilities.operation("point")
        assert point is not None
        until(lambda: robot.state().age_s < 0.2, "a state")
        try:
            for run in range(runs):
                for way in ("left", "right", "up"):
                    said = {"way": way, "angle": 20.0 + 15.0 * (run % 5)}
                    step = Primitive("point", arguments=point.complete(said), declared=point)
                    result = robot.step(step, lambda _: None)
                    told = ArmPose(*(result.measured[f"{name}_deg"] for name in ArmPose._fields[:-1]))
                    worst = max(worst, farthest_deg(told, world.pose())[1])
                    pointed = max(pointed, abs(result.measured["angle"] - said["angle"]))
        finally:
            robot.close()
            world.close()
    print(f"{3 * runs} times pointed: at most {pointed:.1f}° from the angle asked for; joints told within {worst:.1f}°")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=("stop", "pick", "angles"))
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--cubes", type=int, default=20)
    parser.add_argument("--runs", type=int, default=5)
    args = parser.parse_args()
    parts = {
        "stop": lambda: stops(args.trials), "pick": lambda: picks(args.cubes), "angles": lambda: angles(args.runs)
    }  # fmt: skip
    for name, part in parts.items():
        if args.only in (None, name):
            part()


if __name__ == "__main__":
    main()
