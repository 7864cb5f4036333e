"""Measure how long the preview of a command of about 15 s takes, from the request to the answer.

    python benchmarks/rehearsal.py [--trials 10] [--robot g1]

Each trial starts a process of low priority, as an agent does, which builds the shipped room and runs the plan three to
five times with noise under the guard, on two processors where there are. Wall time depends on what else the machine
does, which the load average shows; processor time does not.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import os
import resource
import statistics
import time

from agentrob.config.robots import RobotConfig
from agentrob.model import Direction, Op, Plan, Pose, Primitive
from agentrob.rehearsal.client import rehearse
from agentrob.rehearsal.preview import Basis, OtherRobot, PreviewRequest
from agentrob.wiring.app import capabilities_of, simulated_robot

F, B, L, R = Direction
PLANS = {
    "go2": Plan(
        (
            Primitive(Op.MOVE, F, distance_m=1.0),
            Primitive(Op.TURN, L, degrees=90.0),
            Primitive(Op.MOVE, F, distance_m=1.0),
            Primitive(Op.TURN, L, degrees=90.0),
        )
    ),
    "g1": Plan((Primitive(Op.MOVE, F, distance_m=0.6), Primitive(Op.HELLO))),
}
#: Where the other robot stands meanwhile.
OTHER = {
    "go2": OtherRobot("humanoid", "g1", Pose(0.0, 2.0, 0.0)),
    "g1": OtherRobot("quadruped", "go2", Pose(-1.4, -0.2, 0.0)),
}


def request(model: str, seed: int) -> PreviewRequest:
    settings: RobotConfig = simulated_robot(model, 0)
    home = Pose(*settings.map.home_at_m, math.radians(settings.map.home_facing_deg))
    return PreviewRequest(model, settings, PLANS[model], start=home, home=home, others=(OTHER[model],), seed=seed)


def children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


async def measure(model: str, trials: int) -> None:
    walls, processor, runs, lengths = list[float](), list[float](), list[int](), list[float]()
    for seed in range(trials):
        asked = request(model, seed)
        began_s, used_s = time.monotonic(), children_s()
        preview = await rehearse(asked, capabilities_of(model, asked.settings))
        walls.append(time.monotonic() - began_s)
        processor.append(children_s() - used_s)
        if preview.basis is not Basis.SIMULATION:
            raise SystemExit(f"not simulated: {preview.missing}")
        runs.append(len(preview.runs))
        lengths.append(preview.median_s)
    each = [cpu / count for cpu, count in zip(processor, runs, strict=True)]
    print(
        f"{model:4} {statistics.median(lengths):8.1f} {min(runs):>4}-{max(runs)} {statistics.median(walls):10.2f} "
        f"{max(walls):8.2f} {statistics.median(processor):10.2f} {statistics.median(each):12.2f}",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--robot", choices=sorted(PLANS), help="measure only this one")
    given = parser.parse_args()
    load = " ".join(f"{value:.1f}" for value in os.getloadavg())
    print(f"{given.trials} previews each; {os.cpu_count()} processors, load average {load}")
    print("robot  command s  runs  median s    max s  processor s  processor s/run")
    for model in sorted(PLANS, reverse=True):
        if given.robot in (None, model):
            asyncio.run(measure(model, given.trials))


if __name__ == "__main__":
    main()
