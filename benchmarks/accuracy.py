"""How exactly a Go2 moves and turns against the simulator's true pose, by the driver's own loop in simulated time.

    python benchmarks/accuracy.py [--runs 10] [--seed 0] [--lag 0.04]

Full physics and the sensors' noise (2 mm, 0.2°, 0.3 % scale), without DDS: `--lag` seconds stand for the way from
odometry to command. Prints a table, and the shares within 5 cm and 4° over all runs.
"""

from __future__ import annotations

import argparse
import math
from collections import deque
from typing import NamedTuple

import numpy as np

from agentrob.model import ActionResult, Direction, Op, Pose, Primitive, RobotState
from agentrob.robots.go2 import GAIT
from agentrob.robots.motion import RATE_HZ, Velocity, wrap
from agentrob.robots.walk import TOLERANCE_DEG, TOLERANCE_M, axis, walk
from agentrob.sim.go2 import Go2
from agentrob.sim.sensors import Odometry
from agentrob.sim.world import PERIOD_S, World

F, B, L, R = Direction
STEPS = (
    *(Primitive(Op.MOVE, F, distance_m=d) for d in (0.2, 0.5, 1.0, 2.0, 4.0)),
    Primitive(Op.MOVE, B, distance_m=1.0),
    Primitive(Op.MOVE, L, distance_m=0.5),
    Primitive(Op.MOVE, F, distance_m=1.0, speed_mps=0.2),
    *(Primitive(Op.TURN, L, degrees=a) for a in (15.0, 45.0, 90.0, 180.0, 360.0)),
    Primitive(Op.TURN, R, degrees=90.0),
)


class SimulatedBody:
    """A Go2 in simulated time, as `agentrob.robots.walk.Body`."""

    def __init__(self, seed: int, lag_s: float) -> None:
        self.body = Go2()
        self.world = World([self.body], things=())
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
        """Forward and left from the start in metres, degrees turned."""
        dx, dy = self.body.xy_m - np.array(self._start[:2])
        c, s = math.cos(self._start[2]), math.sin(self._start[2])
        return c * dx + s * dy, -s * dx + c * dy, math.degrees(self._turned)


class Run(NamedTuple):
    off_m: float
    off_deg: float
    seconds: float
    result: ActionResult


def one(robot: SimulatedBody, step: Primitive) -> Run:
    robot.begin()
    gait = GAIT.at_most(0.5, math.radians(45))
    began_s = robot.now_s()
    result = walk(robot, step, gait, lambda _: None)
    seconds = robot.now_s() - began_s
    robot.run(0.6)
    forward, left, turned = robot.truth()
    x, y = axis(step.direction)
    sign = -1.0 if step.direction is R else 1.0
    asked_m, asked_deg = step.distance_m or 0.0, sign * (step.degrees or 0.0) if step.op is Op.TURN else 0.0
    off_m = math.hypot(forward - x * asked_m, left - y * asked_m) if step.op is Op.MOVE else math.hypot(forward, left)
    return Run(off_m, abs(turned - asked_deg), seconds, result)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--lag", type=float, default=0.04)
    given = parser.parse_args()
    robot, everything = SimulatedBody(given.seed, given.lag), list[Run]()
    print(f"{given.runs} runs each, control at {RATE_HZ:g} Hz, lag {given.lag * 1000:.0f} ms, seed {given.seed}")
    print(f"{'step':34} {'cm mean':>8} {'95%':>6} {'deg mean':>9} {'95%':>6} {'s mean':>7} {'max':>6}  outcomes")
    for step in STEPS:
        runs = [one(robot, step) for _ in range(given.runs)]
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
