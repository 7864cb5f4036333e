"""Let a Go2 and a G1 cross each other's path in one room, and count how often they touch.

    python benchmarks/crossing.py [--runs 200] [--seed 0] [--without-zones] [--json FILE]

Full physics with sensor noise, in simulated time, without forum and DDS: real guards, zones and control loops, each
robot in a thread of its own; the world goes on when both wait for it. The paths of each run cross in a random place at
a random angle; each is walked in one go, or in two steps with a turn between them. Half of the runs begin together, the
others up to 4 s apart. The range readings of both robots say that everything is free, so that only the zones keep them
apart; `--without-zones` is the control. Contacts are those of the physics, looked at every 20 ms from outside.

A run is stuck if a command has not ended after 120 s. A command may also end with the answer that the other robot
stands in its way; nothing then moves, as with an agent.
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from agentrob.config.robots import FenceConfig, RobotConfig
from agentrob.model import ActionResult, Capabilities, Direction, Op, Pose, Primitive, RobotState, StopResult
from agentrob.robots.control.controller import Gait, Velocity
from agentrob.robots.control.step_runner import run_step
from agentrob.robots.protocol import Watch
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from agentrob.robots.unitree import g1, go2
from agentrob.robots.zones.keeper import LocalKeeper
from agentrob.robots.zones.member import RoomMember
from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.bodies.sensors import Odometry
from agentrob.sim.world.legged import Legged
from agentrob.sim.world.scene import OPEN_FLOOR, Start
from agentrob.sim.world.world import World

ERROR_M = 0.1
STUCK_S = 120.0
KINDS: dict[str, tuple[Any, Gait]] = {"go2": (go2.Go2, go2.GAIT), "g1": (g1.G1, g1.GAIT)}
FREE_M = 4.0
EVERYWHERE = FenceConfig(x_min_m=-99, x_max_m=99, y_min_m=-99, y_max_m=99)


class Ended(Exception):
    """The run is over."""


class Lockstep:
    """Simulated time for several threads: the world is advanced while all of them wait."""

    def __init__(self, world: World, threads: int) -> None:
        self.world, self._threads = world, threads
        self._changed = threading.Condition()
        self._due: dict[int, float] = {}
        self._over = False

    def now_s(self) -> float:
        return float(self.world.time_s)

    def wait_until(self, time_s: float) -> None:
        me = threading.get_ident()
        with self._changed:
            self._due[me] = time_s
            self._changed.notify_all()
            self._changed.wait_for(lambda: me not in self._due or self._over)
            if self._over:
                raise Ended

    def leave(self) -> None:
        """Stop counting this thread."""
        with self._changed:
            self._threads -= 1
            self._changed.notify_all()

    def until_all_wait(self) -> bool:
        """Wait until all threads wait; return False once there is none left."""
        with self._changed:
            self._changed.wait_for(lambda: len(self._due) >= self._threads)
            return self._threads > 0

    def wake(self) -> None:
        """Wake the threads whose time has come."""
        with self._changed:
            self._due = {k: due for k, due in self._due.items() if due > self.now_s() + 1e-6}
            self._changed.notify_all()

    def end(self) -> None:
        with self._changed:
            self._over = True
            self._changed.notify_all()


class WorldRobot:
    """A body of the world as a robot (`agentrob.robots.protocol.Robot`), whose ranges show free space."""

    time_scale = 100.0  # the guard's clock is real, and simulated time faster

    def __init__(self, body: Legged, clock: Lockstep, rng: np.random.Generator) -> None:
        kind, gait = KINDS[body.name]
        self.capabilities: Capabilities = kind.describe(RobotConfig(model=body.name, simulated=True))
        limits = self.capabilities.limits
        self._gait = gait.at_most(limits.speed_mps, math.radians(limits.turn_dps))
        self._body, self._clock, self._rng = body, clock, rng
        self._odometry = Odometry(body, rng, noisy=True)
        self._state = self._sensed()

    def sense(self) -> None:
        """Once per period, in the world's thread."""
        self._odometry.update()
        self._state = self._sensed()

    def _sensed(self) -> RobotState:
        front, left, back, right = FREE_M + self._rng.normal(0, 0.01, 4)
        return RobotState(
            0.0, Pose(*self._odometry.read()), mode="idle", ranges_m=(front, left, back, right),
            upright=bool(self._body.upright > 0.5), battery_percent=90.0,
        )  # fmt: skip

    def state(self) -> RobotState:
        return self._state

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        return run_step(self, primitive, self._gait, watch)

    def stop(self) -> StopResult:
        self.rest()
        return StopResult(0.0, confirmed=False)

    def close(self) -> None: ...

    # ------------------------------------------------------------ agentrob.robots.control.step_runner.Body
    def now_s(self) -> float:
        return self._clock.now_s()

    def command(self, velocity: Velocity) -> None:
        self._body.walk(np.array(velocity))  # type: ignore[attr-defined]

    def rest(self) -> None:
        self._body.walk(np.zeros(3))  # type: ignore[attr-defined]

    def wait_until(self, time_s: float) -> None:
        self._clock.wait_until(time_s)


class PacedMember(RoomMember):
    """A member that sees its robot in simulated time, not by the guard's real one."""

    def observe(self, odometry: Pose | None, age_s: float, at_home: Pose | None) -> None:
        return

    def sense(self, odometry: Pose | None, at_home: Pose | None) -> None:
        super().observe(odometry, 0.0, at_home)


@dataclass
class Walker:
    """One robot of a run, and what became of its command."""

    body: Legged
    robot: WorldRobot
    guard: Guard
    room: PacedMember | None
    steps: Sequence[Primitive]
    begins_s: float
    outcome: str = ""
    waited: Counter[str] = field(default_factory=Counter)


@dataclass(frozen=True)
class RunResult:
    contacts: int
    outcomes: dict[str, str]
    waited: dict[str, dict[str, int]]
    nearest_m: float
    seconds: float
    together_s: float
    fell: bool


def scenario(rng: np.random.Generator) -> dict[str, tuple[Start, list[Primitive], float]]:
    """Two paths that cross: of each robot its start, its steps and when it begins."""
    angle = rng.uniform(-math.pi, math.pi)
    found: dict[str, tuple[Start, list[Primitive], float]] = {}
    delays = [0.0, 0.0 if rng.random() < 0.5 else rng.uniform(0.5, 4.0)]
    rng.shuffle(delays)
    for name, delay_s in zip(KINDS, delays, strict=True):
        before_m, after_m = rng.uniform(1.9, 2.4), rng.uniform(1.9, 2.4)
        if rng.random() < 0.5:
            steps = [_move(before_m + after_m)]
        else:  # it turns beyond the crossing
            side = Direction.LEFT if rng.random() < 0.5 else Direction.RIGHT
            turn = Primitive(Op.TURN, side, degrees=float(rng.uniform(10, 40)))
            steps = [_move(before_m + 1.2), turn, _move(after_m - 1.2)]
        start = Start(-before_m * math.cos(angle), -before_m * math.sin(angle), angle)
        found[name] = start, steps, delay_s
        angle += rng.choice([-1, 1]) * rng.uniform(math.radians(50), math.radians(130))
    return found


def _move(distance_m: float) -> Primitive:
    return Primitive(Op.MOVE, Direction.FORWARD, distance_m=round(float(distance_m), 2))


def walk(walker: Walker, clock: Lockstep) -> None:
    """Carry out one command, as an agent does: enter the room, then do the steps."""
    try:
        clock.wait_until(clock.now_s() + walker.begins_s)
        for number, step in enumerate(walker.steps):
            while True:
                while (hindrance := walker.guard.enter_room(walker.steps[number:])) is not None and hindrance.passes:
                    walker.waited[hindrance.reason] += 1
                    clock.wait_until(clock.now_s() + 0.3)
                result = walker.guard.step(step, lambda _: None)
                if result.reason not in ("room_busy", "room_restless"):
                    break
            if not result.ok:
                walker.outcome = f"{result.outcome} {result.reason}".strip()
                return
        walker.outcome = "done"
    except Ended:
        walker.outcome = "stuck"
    finally:
        walker.guard.leave_room()
        clock.leave()


def run(world: World, bodies: dict[str, Legged], rng: np.random.Generator, folder: Path, zones: bool) -> RunResult:
    paths = scenario(rng)
    for name, (start, _, _) in paths.items():
        bodies[name].start = start
    world.reset()
    clock = Lockstep(world, len(paths))
    walkers = [_walker(bodies[name], clock, rng, folder, zones, *paths[name]) for name in paths]
    _until_home(walkers, world)
    threads = [threading.Thread(target=walk, args=(walker, clock), daemon=True) for walker in walkers]
    for thread in threads:
        thread.start()
    contacts, nearest_m, began_s, together_s, fell = 0, math.inf, world.time_s, 0.0, False
    while clock.until_all_wait():
        _tick(world, walkers)
        contacts += any("g1" in name or "go2" in name for name in walkers[0].body.touching())
        nearest_m = min(nearest_m, float(np.hypot(*(walkers[0].body.xy_m - walkers[1].body.xy_m))))
        moving = [np.hypot(*walker.body.heading_velocity()[:2]) > 0.1 for walker in walkers]
        together_s += 0.02 if all(moving) else 0.0
        fell = fell or any(walker.body.upright < 0.7 for walker in walkers)
        if world.time_s - began_s > STUCK_S:
            clock.end()
            break
        clock.wake()
    for thread in threads:
        thread.join(10)
    for walker in walkers:
        walker.guard.close()
    outcomes = {walker.body.name: walker.outcome for walker in walkers}
    waited = {walker.body.name: dict(walker.waited) for walker in walkers}
    return RunResult(contacts, outcomes, waited, nearest_m, world.time_s - began_s, together_s, fell)


def _walker(
    body: Legged, clock: Lockstep, rng: np.random.Generator, folder: Path, zones: bool,
    start: Start, steps: list[Primitive], begins_s: float,
) -> Walker:  # fmt: skip
    robot = WorldRobot(body, clock, rng)
    settings = RobotConfig(model=body.name, simulated=True, home_on_start=True, fence=EVERYWHERE)
    room = None
    if zones:
        keeper = LocalKeeper(folder / "room.sqlite", lambda: "boot", clock.now_s)
        home = Pose(start.x_m, start.y_m, start.yaw_rad)
        room = PacedMember(body.name, "room", keeper, home=home, error_m=ERROR_M, clock=clock.now_s)
    guard = Guard(robot, settings, Halt(folder / f"{body.name}.halt"), room=room)
    return Walker(body, robot, guard, room, steps, begins_s)


def _until_home(walkers: list[Walker], world: World) -> None:
    """Wait until the guards, which see the standing robots in real time, have set their homes; then until each robot
    has been reported at rest."""
    end_s = time.monotonic() + 30
    while not all(walker.guard.state().homed for walker in walkers):
        if time.monotonic() > end_s:
            raise SystemExit("a robot was not homed")
        time.sleep(0.02)
    for _ in range(60):
        _tick(world, walkers)


def _tick(world: World, walkers: list[Walker]) -> None:
    world.tick()
    for walker in walkers:
        walker.robot.sense()
        if walker.room is not None:
            walker.room.sense(walker.robot.state().pose, walker.guard.posture(joints=False).pose)
            walker.room.exchange()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--without-zones", action="store_true", help="the control: nobody waits for anybody")
    parser.add_argument("--json", type=Path, help="write the result of each run to this file")
    given = parser.parse_args()
    logging.getLogger("agentrob").setLevel(logging.ERROR)
    bodies: dict[str, Legged] = {"go2": Go2("go2"), "g1": G1("g1")}
    world = World(list(bodies.values()), OPEN_FLOOR)
    rng, results, began_s = np.random.default_rng(given.seed), list[RunResult](), time.monotonic()
    for number in range(given.runs):
        with tempfile.TemporaryDirectory(prefix="agentrob-crossing-") as folder:
            results.append(run(world, bodies, rng, Path(folder), not given.without_zones))
        if (number + 1) % 20 == 0 or results[-1].contacts:
            print(f"{number + 1} runs, {time.monotonic() - began_s:.0f} s: {results[-1]}", flush=True)
        if given.json:
            given.json.write_text(json.dumps([vars(result) for result in results]))
    report(results, zones=not given.without_zones)


def report(results: list[RunResult], *, zones: bool) -> None:
    outcomes = Counter(outcome for result in results for outcome in result.outcomes.values())
    waits = sum(any(reasons for reasons in result.waited.values()) for result in results)
    print(f"{len(results)} runs of crossing paths, {'with' if zones else 'without'} zones")
    print(f"runs with a contact between the robots: {sum(result.contacts > 0 for result in results)}")
    print(f"runs in which a robot fell: {sum(result.fell for result in results)}")
    print(f"stuck: {outcomes.pop('stuck', 0)}")
    print("commands: " + ", ".join(f"{how} {count}" for how, count in outcomes.most_common()))
    print(f"runs in which one waited for the other: {waits}")
    print(f"runs in which both moved at the same time: {sum(result.together_s > 0.2 for result in results)}")
    nearest = np.array([result.nearest_m for result in results])
    print(f"between their middles: nearest {nearest.min():.2f} m, median of the runs {np.median(nearest):.2f} m")
    seconds = np.array([result.seconds for result in results])
    print(f"simulated seconds a run: median {np.median(seconds):.1f}, longest {seconds.max():.1f}")


if __name__ == "__main__":
    main()
