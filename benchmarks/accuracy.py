"""Measure how accurately the driver's control loop moves and turns a robot, against the simulator's true pose.

    python benchmarks/accuracy.py [--robot g1] [--runs 10] [--seed 0] [--lag 0.04] [--only move] [--mps 0.4]

Each robot moves at its driver's default limits: the Go2 0.5 m/s and 45°/s, the G1, which has no range sensors, 0.2 m/s
and 28.6°/s. Simulated time, full physics and sensor noise (2 mm, 0.2°, 0.3 % scale), without DDS: `--lag` is the delay
in seconds from odometry to command. Prints a table, and the shares within 5 cm and 4° over all runs.
"""

from __future__ import annotations

import argparse
import math
from collections import deque
from typing import NamedTuple

import numpy as np

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Direction, Op, Pose, Primitive, RobotState
from agentrob.robots.control.controller import RATE_HZ, Gait, Velocity, wrap
from agentrob.robots.control.step_runner import TOLERANCE_DEG, TOLERANCE_M, run_step, unit_vector
from agentrob.robots.unitree import g1, go2
from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.bodies.sensors import Odometry
from agentrob.sim.world.legged import PERIOD_S
from agentrob.sim.world.scene import OPEN_FLOOR
from agentrob.sim.world.world import World

F, B, L, R = Direction
STEPS = (
    *(Primitive(Op.MOVE, F, distance_m=d) for d in (0.25, 0.5, 1.0, 2.0, 3.0)),
    Primitive(Op.MOVE, B, distance_m=0.5),
    Primitive(Op.MOVE, L, distance_m=0.5),
    Primitive(Op.MOVE, F, distance_m=1.0, speed_mps=0.2),
    *(Primitive(Op.TURN, L, degrees=a) for a in (15.0, 45.0, 90.0, 180.0, 360.0)),
    Primitive(Op.TURN, R, degrees=90.0),
)

GAITS = {"go2": (Go2, go2.Go2, go2.GAIT), "g1": (G1, g1.G1, g1.GAIT)}


def gait_of(kind: str, mps: float | None) -> Gait:
    """The driver's gait in simulation, with another speed if one is given."""
    _, driver, gait = GAITS[kind]
    limits = driver.describe(RobotConfig(model=kind, simulated=True)).limits
    return gait.at_most(mps or limits.speed_mps, math.radians(limits.turn_dps))


class SimulatedBody:
    """A robot in simulated time that implements `agentrob.robots.control.step_runner.Body`."""

    def __init__(self, kind: str, seed: int, lag_s: float) -> None:
        self.body = GAITS[kind][0]()
        self.world = World([self.body], OPEN_FLOOR)
        self._rng = np.random.default_rng(seed)
        self._lag = round(lag_s / PERIOD_S)

    def begin(self) -> None:
        self.world.reset()
        self._odometry = Odometry(self.body, self._rng, noisy=True)
        self._readings: deque[tuple[float, float, float]] = deque([(0.0, 0.0, 0.0)], maxlen=self._lag + 1)
        self._turned, self._yaw = 0.0, self.body.yaw_rad
        self._start = *self.body.xy_m, self.body.yaw_rad
        self.run(self._rng.uniform(0.0, 0.5))

    def run(self, seconds: float) -> None:
        self.wait_until(self.now_s() + seconds)

    def now_s(self) -> float:
        return float(self.world.time_s)

    def state(self) -> RobotState:
        return RobotState(0.0, Pose(*self._readings[0]))

    def command(self, velocity: Velocity) -> None:
        self.body.walk(np.array(velocity))

    def rest(self) -> None:
        self.body.walk(np.zeros(3))

    def wait_until(self, time_s: float) -> None:
        while self.now_s() < time_s - 1e-6:
            self.world.tick()
            self._odometry.update()
            self._readings.append(self._odometry.read())
            self._turned += wrap(self.body.yaw_rad - self._yaw)
            self._yaw = self.body.yaw_rad

    def truth(self) -> tuple[float, float, float]:
        """Metres forward and to the left of the start, and degrees turned."""
        dx, dy = self.body.xy_m - np.array(self._start[:2])
        c, s = math.cos(self._start[2]), math.sin(self._start[2])
        return c * dx + s * dy, -s * dx + c * dy, math.degrees(self._turned)


class Run(NamedTuple):
    off_m: float
    off_deg: float
    seconds: float
    result: ActionResult


def one(robot: SimulatedBody, step: Primitive, gait: Gait) -> Run:
    robot.begin()
    began_s = robot.now_s()
    result = run_step(robot, step, gait, lambda _: None)
    seconds = robot.now_s() - began_s
    robot.run(0.6)
    if robot.body.upright < 0.9:
        raise SystemExit(f"it fell on {step}")
    forward, left, turned = robot.truth()
    x, y = unit_vector(step)
    sign = -1.0 if step.direction is R else 1.0
    asked_m, asked_deg = step.distance_m or 0.0, sign * (step.degrees or 0.0) if step.op is Op.TURN else 0.0
    off_m = math.hypot(forward - x * asked_m, left - y * asked_m) if step.op is Op.MOVE else math.hypot(forward, left)
    return Run(off_m, abs(turned - asked_deg), seconds, result)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", choices=sorted(GAITS), default="go2")
    parser.add_argument("--only", choices=[str(Op.MOVE), str(Op.TURN)], help="measure only these rows")
    parser.add_argument("--mps", type=float, help="speed limit, instead of the driver's")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--lag", type=float, default=0.04)
    given = parser.parse_args()
    robot, gait = SimulatedBody(given.robot, given.seed, given.lag), gait_of(given.robot, given.mps)
    everything = list[Run]()
    print(f"{given.robot}, {gait.speed_mps:g} m/s, {math.degrees(gait.turn_rps):.1f}°/s at most")
    print(f"{given.runs} runs each, control at {RATE_HZ:g} Hz, lag {given.lag * 1000:.0f} ms, seed {given.seed}")
    print(f"{'step':34} {'cm mean':>8} {'95%':>6} {'deg mean':>9} {'95%':>6} {'s mean':>7} {'max':>6}  outcomes")
    for step in STEPS:
        if given.only not in (None, step.op):
            continue
        runs = [one(robot, step, gait) for _ in range(given.runs)]
        everything += runs
        m, deg, s = (np.array([r[k] for r in runs]) for k in range(3))
        outcomes = {str(r.result.outcome) for r in runs}
        name = f"{step.op} " + " ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in step.asked().values())
        print(
            f"{name:34} {100 * m.mean():8.1f} {100 * np.percentile(m, 95):6.1f} {deg.mean():9.1f} "
            f"{np.percentile(deg, 95):6.1f} {s.mean():7.1f} {s.max():6.1f}  {', '.join(sorted(outcomes))}",
            flush=True,
        )
    within = [r.off_m <= TOLERANCE_M and r.off_deg <= TOLERANCE_DEG for r in everything]
    m, deg = (np.array([r[k] for r in everything]) for k in range(2))
    print(
        f"all: {100 * np.percentile(m, 95):.1f} cm and {np.percentile(deg, 95):.1f}° at 95 %; "
        f"{100 * np.mean(within):.1f} % of {len(within)} within 5 cm and 4°"
    )


if __name__ == "__main__":
    main()
