"""Results of steps, stops and whole commands: requested beside measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from agentrob.model.commands import Command
from agentrob.model.decisions import Verdict
from agentrob.model.lifecycle import CommandState
from agentrob.model.plans import Plan, Primitive


class Outcome(StrEnum):
    """How a step ended. `unknown` means that the robot did not confirm."""

    DONE = "done"
    INACCURATE = "inaccurate"
    FAILED = "failed"
    REFUSED = "refused"
    STOPPED = "stopped"
    INTERRUPTED = "interrupted"
    UNKNOWN = "unknown"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class ActionResult:
    """One step, asked beside measured.

    `measured` has the keys of what was asked (`distance_m`, `degrees`) and what is worth knowing besides. It is empty
    where nothing was measured; `unmeasured` then says why, of a step that may have moved the robot: `odometry_lost` or
    `odometry_jump`. `reason` is
    a stable word (obstacle, fence, deadline, stale_state, lease_lapsed, stop, stalled, unsupported, busy, …), `message`
    an English sentence. `path` is the odometry during the step: (seconds, x_m, y_m, yaw_rad), `commanded` what was sent
    to the body meanwhile: (seconds, forward_mps, left_mps, turn_rps). `image` is a JPEG. `started_s` and `ended_s` are
    monotonic.
    """

    primitive: Primitive
    outcome: Outcome
    measured: Mapping[str, float] = field(default_factory=dict)
    reason: str = ""
    message: str = ""
    started_s: float = 0.0
    ended_s: float = 0.0
    path: tuple[tuple[float, float, float, float], ...] = ()
    image: bytes | None = None
    animated: bool = False
    commanded: tuple[tuple[float, float, float, float], ...] = ()
    unmeasured: str = ""

    @property
    def ok(self) -> bool:
        return self.outcome is Outcome.DONE

    @property
    def moved(self) -> bool:
        """Whether the driver was given this step and did not refuse it, so that the robot moved or may have moved."""
        return self.outcome not in (Outcome.SKIPPED, Outcome.REFUSED)

    @property
    def duration_s(self) -> float:
        return self.ended_s - self.started_s

    def as_data(self) -> dict[str, Any]:
        """The step as data: what was asked beside what was measured; without its path and picture."""
        return {
            "op": str(self.primitive.op),
            "asked": self.primitive.asked(),
            "measured": {key: round(value, 4) for key, value in self.measured.items()},
            **({"unmeasured": self.unmeasured} if self.unmeasured else {}),
            "outcome": str(self.outcome),
            "reason": self.reason,
            "message": self.message,
            "duration_s": round(self.duration_s, 3),
        }


@dataclass(frozen=True, slots=True)
class StopResult:
    """The result of a stop.

    `latency_ms`: from asked to zero velocity commanded. `confirmed`: the robot's own state shows rest. `ended_s`: what
    was accepted until then, by the monotonic clock of the driver's host, is over.
    """

    latency_ms: float
    confirmed: bool
    was_moving: bool = False
    coasted_m: float | None = None
    message: str = ""
    ended_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Report:
    """Everything the final reply says. `status` is a final state. `timings_ms` counts from the moment the forum
    accepted the post. `goal` is what a model was to look for, in our words; `approved_by` is the handle of the account
    that approved the command, if it needed an approval. `findings` are sentences about what was found on the way;
    `hint` is a sentence of ours, with a post that is understood."""

    command: Command
    status: CommandState
    verdict: Verdict | None = None
    plan: Plan = Plan()
    results: tuple[ActionResult, ...] = ()
    message: str = ""
    stop: StopResult | None = None
    timings_ms: Mapping[str, float] = field(default_factory=dict)
    goal: str = ""
    approved_by: str = ""
    findings: tuple[str, ...] = ()
    hint: str = ""
