"""Run a plan several times in a simulated world, with the driver's own guard and control loop."""

from __future__ import annotations

import hashlib
import math
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

from agentrob.model import ActionResult, Capabilities, Outcome, Pose, Primitive
from agentrob.rehearsal.geometry import HALF_M, least_distances, outlines, planned_path, robot_bodies, seen_from
from agentrob.rehearsal.motions import Motions, motions_of
from agentrob.rehearsal.preview import Basis, Point, Preview, PreviewRequest, RehearsedStep, Run
from agentrob.rehearsal.side_by_side import Budget, make_runs
from agentrob.rehearsal.simulated_robot import SimulatedRobot
from agentrob.robots.control.controller import RATE_HZ
from agentrob.robots.safety.guard import Guard, SimulatedTime
from agentrob.robots.safety.lock import Halt
from agentrob.robots.safety.ranges import WINDOW_S
from agentrob.robots.unitree import g1 as g1_driver
from agentrob.robots.unitree import go2 as go2_driver
from agentrob.screening.mandate import mandate_of
from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.world.legged import PERIOD_S, Legged
from agentrob.sim.world.scene import PlacedBody, Scene, Start, Thing, load
from agentrob.sim.world.world import World

#: How well it is known where the robot stands: one standard deviation of each run's start.
PLACE_M, PLACE_RAD = 0.01, math.radians(1.0)
#: Before the first step and after the last one: the body comes to rest, and the guard sees enough of its sensors.
BEFORE_S, AFTER_S = 1.2 * WINDOW_S, 0.4
#: From one step to the next: the agent asks again whether it may go on.
BETWEEN_S = 0.2
#: Every so many periods the body's pose and contacts are kept.
EVERY = 5
#: What ends below this or begins above the robot does not stand in its way.
FLAT_M = 0.02
HEIGHT_M = {"go2": 0.45, "g1": 1.35}
#: Other robots are columns of this size in the simulation.
OTHER_RADIUS_M = {"go2": 0.36, "g1": 0.25}
OTHER_HEIGHT_M = {"go2": 0.40, "g1": 1.30}


def capabilities_of(request: PreviewRequest) -> Capabilities:
    """The robot's capabilities, as its driver declares them."""
    kind = g1_driver.G1 if request.settings.model == "g1" else go2_driver.Go2
    return kind.describe(request.settings)


def simulate(request: PreviewRequest, clock: Callable[[], float] = time.monotonic, processes: int = 1) -> Preview:
    """The preview of a robot that the simulator has a body of. Raises `SimError` if its world cannot be read.

    With two `processes` runs are made side by side; this one must then have no other thread.
    """
    start = request.start
    assert start is not None
    budget = Budget(request.least_runs, request.most_runs, request.budget_s, clock)
    simulation = Simulation(request)
    runs = make_runs(simulation.run, budget, processes)
    return Preview(
        request.robot, Basis.SIMULATION, request.plan, start, planned_path(start, request.plan), tuple(runs),
        request.others, request.others_known, seed=request.seed, world=simulation.world_hash,
        frames=tuple(simulation.frames), step_times_s=tuple(simulation.step_times_s),
    )  # fmt: skip


@dataclass
class _Trace:
    """The trace of one run."""

    path: list[Point] = field(default_factory=list)
    touched: set[str] = field(default_factory=set)
    ticks: int = 0


class Simulation:
    """One world, in which the plan is run again and again. `frames` and `step_times_s` are those of the first run."""

    def __init__(self, request: PreviewRequest) -> None:
        self._request, self._model = request, request.settings.model
        self._capabilities = capabilities_of(request)
        self._scene = load(request.settings.rehearsal.world)
        self.world_hash = f"{self._scene.name} {hashlib.sha256(self._scene.model_dump_json().encode()).hexdigest()}"
        self._names = {_other_name(number): f"@{other.name}" for number, other in enumerate(request.others)}
        self._body: Legged = G1("robot") if self._model == "g1" else Go2("robot")
        assert request.start is not None
        self._body.start = Start(request.start.x_m, request.start.y_m, request.start.yaw_rad)
        self._world = World([self._body], _with_others(self._scene, request))
        self._motions: Motions = motions_of(self._body, lambda: float(self._world.time_s))
        self.frames: list[tuple[float, ...]] = []
        self.step_times_s: list[float] = []

    def run(self, number: int) -> Run:
        """Do the plan once, from nearly the same place."""
        request, rng = self._request, np.random.default_rng([request_seed(self._request), number])
        start = request.start
        assert start is not None
        dx, dy, dyaw = rng.normal(0, 1, 3) * (PLACE_M, PLACE_M, PLACE_RAD) if number else (0.0, 0.0, 0.0)
        self._body.start = Start(start.x_m + dx, start.y_m + dy, start.yaw_rad + dyaw)
        self._world.ticks = 0  # so that a run does not depend on those before it
        self._world.reset()
        self._motions.reset(rng)
        trace, began_s = _Trace(), float(self._world.time_s) + BEFORE_S
        robot = SimulatedRobot(
            self._motions, self._world, self._capabilities, seen_from(request.home, start), rng,
            request.battery_percent, lambda: self._note(trace, number, began_s),
        )  # fmt: skip
        steps = tuple(self._steps(robot, trace, number, began_s))
        seconds = robot.now_s() - began_s
        robot.wait(AFTER_S)
        bodies = [*_things(self._scene, self._model), *robot_bodies(request.others)]
        distances = least_distances(trace.path, bodies, HALF_M[self._model])
        if (wall_m := _wall_m(self._scene, trace.path, HALF_M[self._model])) is not None:
            distances["wall"] = wall_m
        fell = self._body.upright < 0.5
        return Run(tuple(trace.path), round(seconds, 3), steps, distances, tuple(sorted(trace.touched)), fell)

    def _steps(self, robot: SimulatedRobot, trace: _Trace, number: int, began_s: float) -> Iterator[RehearsedStep]:
        """Do the steps under the guard, until one does not succeed."""
        settings = self._request.settings
        with tempfile.TemporaryDirectory() as folder:
            halt = Halt(Path(folder) / "halt.json")
            if self._request.halted:
                halt.set("the robot's driver", self._request.halted)
            simulated_time = SimulatedTime(robot.now_s, robot.wait)
            guard = Guard(robot, settings, halt, simulated_time=simulated_time, home=Pose(0.0, 0.0, 0.0))
            _observe(robot, guard, BEFORE_S)
            until_s = began_s + mandate_of(self._request.plan, self._capabilities).seconds
            for step in self._request.plan.steps:
                if number == 0:
                    self.step_times_s.append(round(robot.now_s() - began_s, 3))
                began_step_s = robot.now_s()
                result = guard.step(step, lambda _: None, max(0.1, until_s - began_step_s))
                yield _rehearsed(step, result, robot.now_s() - began_step_s, self._here())
                if not result.ok:
                    return
                _observe(robot, guard, BETWEEN_S)

    def _here(self) -> Point:
        x_m, y_m = self._body.xy_m
        return float(x_m), float(y_m), float(self._body.yaw_rad)

    def _note(self, trace: _Trace, number: int, began_s: float) -> None:
        """Keep where the body is and what it touches."""
        trace.ticks += 1
        if trace.ticks % EVERY or self._world.time_s < began_s:
            return
        x_m, y_m, yaw_rad = self._here()
        trace.path.append((round(x_m, 3), round(y_m, 3), round(yaw_rad, 3)))
        trace.touched |= {self._named(name) for name in self._body.touching()}
        if number == 0:
            self.frames.append(self._frame(float(self._world.time_s) - began_s))

    def _named(self, touched: str) -> str:
        if touched in self._names:
            return self._names[touched]
        if touched.startswith(("wall", "skirting")):
            return "wall"
        return _thing_of(self._scene, touched)

    def _frame(self, at_s: float) -> tuple[float, ...]:
        body, (x_m, y_m, yaw_rad) = self._body, self._here()
        attitude, level, inverse, tilt = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
        mujoco.mju_mat2Quat(attitude, body.rotation.ravel())
        level[:] = math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2)
        mujoco.mju_negQuat(inverse, level)
        mujoco.mju_mulQuat(tilt, inverse, attitude)
        return tuple(round(float(v), 4) for v in (at_s, x_m, y_m, yaw_rad, body.z_m, *tilt, *body.joints_rad))


def request_seed(request: PreviewRequest) -> int:
    """The seed of the runs' noise."""
    return request.seed & 0xFFFFFFFF


def _observe(robot: SimulatedRobot, guard: Guard, seconds: float) -> None:
    """Let the robot stand while the guard watches it, as it does between steps."""
    until_s = robot.now_s() + seconds
    while robot.now_s() < until_s - PERIOD_S / 2:
        robot.wait(1 / RATE_HZ)
        guard.observe()


def _rehearsed(step: Primitive, result: ActionResult, seconds: float, at: Point) -> RehearsedStep:
    quiet = result.outcome is Outcome.DONE
    where = (round(at[0], 3), round(at[1], 3), round(at[2], 3))
    message = "" if quiet else result.message
    return RehearsedStep(step, result.outcome, result.reason, message, round(seconds, 3), where)


# -------------------------------------------------------------------- the room
def _other_name(number: int) -> str:
    return f"other_robot_{number}"


def _with_others(scene: Scene, request: PreviewRequest) -> Scene:
    """The scene with a column for each other robot. It is not checked again: robots stand anywhere by now."""
    others = tuple(
        Thing(
            name=_other_name(number).replace("_", " "),
            shape="column",
            at_m=(other.pose.x_m, other.pose.y_m),
            radius_m=OTHER_RADIUS_M.get(other.model, 0.4),
            height_m=OTHER_HEIGHT_M.get(other.model, 1.0),
        )
        for number, other in enumerate(request.others)
    )
    return scene.model_copy(update={"thing": (*scene.thing, *others)})


def _things(scene: Scene, model: str) -> Iterator[tuple[str, PlacedBody]]:
    """The obstacles for a robot of this height, by the names of the world file."""
    for thing in scene.thing:
        for body in thing.bodies():
            low_m, high_m = body.at_m[2] - body.size_m[-1], body.at_m[2] + body.size_m[-1]
            if body.solid and low_m < HEIGHT_M[model] and high_m > FLAT_M:
                yield thing.name, body


def _thing_of(scene: Scene, body_name: str) -> str:
    """The thing that a body of the model belongs to."""
    return next((thing.name for thing in scene.thing for body in thing.bodies() if body.name == body_name), body_name)


def _wall_m(scene: Scene, path: list[Point], half_m: tuple[float, float]) -> float | None:
    """The least distance to a wall; None in a room without walls."""
    if not scene.room.height_m:
        return None
    inside = np.array(scene.room.size_m) / 2 - np.abs(outlines(path, half_m))
    return max(0.0, float(inside.min()))
