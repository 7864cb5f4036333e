"""Hold what a robot does against the declaration of its operation: where it stays, and what it measured. Pure."""

from __future__ import annotations

import math
from dataclasses import replace

from agentrob.model import ActionResult, Operation, Outcome, Pose, Primitive
from agentrob.model.operations.declaration import CLASS_WORDS, Number

#: Odometry moves by this much while a body stands.
SLACK_M = 0.05


def left_its_place(primitive: Primitive, start: Pose | None, pose: Pose | None) -> str | None:
    """Return a sentence if the body is farther from where the step began than its operation declares.

    Walks and turns are measured by themselves, but for turns of a robot whose foot stays.
    """
    if (primitive.walks and not primitive.turns_in_place) or start is None or pose is None:
        return None
    operation, gone_m = primitive.operation, math.hypot(pose.x_m - start.x_m, pose.y_m - start.y_m)
    if gone_m <= operation.most_travel_m + SLACK_M:
        return None
    return (
        f"{operation.name} is declared as {CLASS_WORDS[operation.action_class]} that takes the robot at most "
        f"{operation.most_travel_m:g} m from its place, and took it {gone_m:.2f} m."
    )


def as_declared(result: ActionResult) -> ActionResult:
    """Return the result of a declared operation with its outcome by asked and measured values alone (law 18)."""
    step = result.primitive
    if step.declared is None or not result.ok:
        return result
    for quantity in step.declared.measured:
        asked = step.value(quantity.name)
        if not isinstance(step.declared.argument(quantity.name), Number) or not isinstance(asked, float | int):
            continue
        got = result.measured.get(quantity.name)
        if got is None or not math.isfinite(got):
            why = f"{result.message} It did not measure {quantity.name}.".strip()
            return replace(result, outcome=Outcome.UNKNOWN, reason="not_measured", message=why)
        if abs(got - asked) > quantity.tolerance:
            why = f"{quantity.name}: asked {asked:g} {quantity.unit}, measured {got:.4g} {quantity.unit}."
            return replace(result, outcome=Outcome.FAILED, reason="inaccurate", message=why)
    return result


def seconds_allowed(operation: Operation, primitive: Primitive) -> float:
    """Return after how many seconds the operation is ended, by its declaration."""
    return operation.time_limit_s + operation.seconds_asked(primitive.arguments)
