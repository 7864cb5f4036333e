"""The request and the result of a preview. Poses are in the frame of the robot's room unless they say otherwise."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from dataclasses import dataclass, field, replace
from enum import StrEnum
from statistics import median
from typing import Any

from pydantic import TypeAdapter

from agentrob.config.robots import RobotConfig
from agentrob.model import Outcome, Plan, Pose, Primitive

Point = tuple[float, float, float]  # x in m, y in m, yaw in rad


class Basis(StrEnum):
    """The basis of a preview."""

    SIMULATION = "simulation"
    GEOMETRY = "geometry"


class Missing(StrEnum):
    """Why a preview is made of geometry alone."""

    NO_WORLD = "no_world"  # the owner names no world that describes the robot's surroundings
    NO_BODY = "no_body"  # the simulator has no body of this kind of robot
    OPERATION = "operation"  # it has an operation that this kind of robot declares itself
    NO_SIMULATOR = "no_simulator"  # the extra `sim` is not installed
    NO_PLACE = "no_place"  # the robot has no home, so where it stands is not known
    POSTURE = "posture"  # it does not stand, and the simulated one only begins standing
    FAILED = "failed"  # the simulation ended with an error
    SLOW = "slow"  # it took too long


@dataclass(frozen=True, slots=True)
class OtherRobot:
    """Another robot in the room, which stands where its agent last said."""

    name: str
    model: str
    pose: Pose


@dataclass(frozen=True, slots=True)
class PreviewRequest:
    """The plan, and how the robot stands now.

    `home` is where its home is in the room, `start` where it stands; `others_known` whether the forum said where other
    robots stand. `halted` is why it refuses all motion, empty if it
    does not. At least `least_runs` are made, and up to `most_runs` while they take no longer than `budget_s` in total.
    """

    robot: str
    settings: RobotConfig
    plan: Plan
    start: Pose | None
    home: Pose = Pose(0.0, 0.0, 0.0)
    mode: str = "idle"
    battery_percent: float | None = None
    halted: str = ""
    others: tuple[OtherRobot, ...] = ()
    others_known: bool = True
    seed: int = 0
    least_runs: int = 3
    most_runs: int = 5
    budget_s: float = 3.5


@dataclass(frozen=True, slots=True)
class RehearsedStep:
    """How one step ended in a run. `reason` and `message` are those of `ActionResult`."""

    primitive: Primitive
    outcome: Outcome
    reason: str = ""
    message: str = ""
    seconds: float = 0.0
    at: Point | None = None


@dataclass(frozen=True, slots=True)
class Run:
    """One run: where the body was ten times a second, and the least distance from its outline to each thing.

    `touched` are the things and robots that it touched. `steps` ends with the step that did not succeed.
    """

    path: tuple[Point, ...]
    seconds: float
    steps: tuple[RehearsedStep, ...]
    distances_m: dict[str, float] = field(default_factory=dict)
    touched: tuple[str, ...] = ()
    fell: bool = False

    @property
    def done(self) -> bool:
        return all(step.outcome is Outcome.DONE for step in self.steps)


@dataclass(frozen=True, slots=True)
class Ending:
    """A step at which runs ended, why, and how many of them did. `number` counts from 1."""

    number: int
    step: RehearsedStep
    runs: int


@dataclass(frozen=True, slots=True)
class Preview:
    """The expected result of a plan. Without a simulation there is one run: the path as if every step were exact.

    `planned` is that path. `world` names the world file and its hash, `frames` are the poses and joint angles of the
    first run for the viewer: [seconds, x, y, yaw, height, tilt (w, x, y, z), joints …].
    """

    robot: str
    basis: Basis
    plan: Plan
    start: Pose | None
    planned: tuple[Point, ...]
    runs: tuple[Run, ...]
    others: tuple[OtherRobot, ...] = ()
    others_known: bool = True
    missing: Missing | None = None
    seed: int = 0
    world: str = ""
    frames: tuple[tuple[float, ...], ...] = ()
    step_times_s: tuple[float, ...] = ()

    @property
    def median_s(self) -> float:
        return median(run.seconds for run in self.runs)

    @property
    def worst_s(self) -> float:
        return max(run.seconds for run in self.runs)

    @property
    def done(self) -> int:
        """How many runs did the whole plan."""
        return sum(run.done for run in self.runs)

    @property
    def distances_m(self) -> dict[str, float]:
        """The least distance to each thing in any run, the nearest first."""
        least: dict[str, float] = {}
        for run in self.runs:
            for name, metres in run.distances_m.items():
                least[name] = min(metres, least.get(name, metres))
        return dict(sorted(least.items(), key=lambda one: one[1]))

    @property
    def touched(self) -> tuple[str, ...]:
        return tuple(sorted({name for run in self.runs for name in run.touched}))

    @property
    def endings(self) -> tuple[Ending, ...]:
        """The steps at which runs ended, the most frequent first."""
        counted: Counter[tuple[int, str]] = Counter()
        first: dict[tuple[int, str], RehearsedStep] = {}
        for run in self.runs:
            if run.done or not run.steps:
                continue
            step = run.steps[-1]
            key = len(run.steps), step.reason or str(step.outcome)
            counted[key] += 1
            first.setdefault(key, step)
        return tuple(Ending(number, first[number, why], runs) for (number, why), runs in counted.most_common())

    @property
    def hash(self) -> str:
        """The hash to which an approval is bound: of the plan, its start, the surroundings and the findings."""
        data = _PREVIEW.dump_python(replace(self, frames=(), step_times_s=()), mode="json")
        return hashlib.sha256(json.dumps(data, sort_keys=True, separators=(",", ":")).encode()).hexdigest()

    def as_data(self) -> dict[str, Any]:
        """The preview for records and programs, without its paths."""
        return {
            "basis": str(self.basis),
            "missing": str(self.missing) if self.missing else "",
            "hash": self.hash,
            "seed": self.seed,
            "world": self.world,
            "runs": len(self.runs),
            "done": self.done,
            "median_s": round(self.median_s, 2),
            "worst_s": round(self.worst_s, 2),
            "distances_m": {name: round(metres, 3) for name, metres in self.distances_m.items()},
            "touched": list(self.touched),
            "refused": [
                {
                    "step": ending.number, "runs": ending.runs, "outcome": str(ending.step.outcome),
                    "reason": ending.step.reason, "message": ending.step.message,
                    "at": [round(v, 3) for v in ending.step.at] if ending.step.at else None,
                }
                for ending in self.endings
            ],
        }  # fmt: skip


_PREVIEW, _REQUEST = TypeAdapter(Preview), TypeAdapter(PreviewRequest)


def write_request(request: PreviewRequest) -> bytes:
    return _REQUEST.dump_json(request)


def read_request(text: bytes) -> PreviewRequest:
    return _REQUEST.validate_json(text)


def write_preview(preview: Preview) -> bytes:
    return _PREVIEW.dump_json(preview)


def read_preview(text: bytes | str) -> Preview:
    return _PREVIEW.validate_json(text)
