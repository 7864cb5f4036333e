"""Compute the upper bounds of a screened command, so that its execution can do less but never more (law 7)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from agentrob.language.goal import Aim, Goal
from agentrob.model import ActionResult, BaseMotion, Capabilities, Mandate, Outcome, Plan, Primitive

#: Tolerance for rounding errors in sums of distances (metres) and angles (degrees).
ROUNDING = 1e-4
#: The motions that each aim implies: a robot that only looks does not walk.
_IMPLIED = {
    Aim.APPROACH: tuple(BaseMotion),
    Aim.FACE: (BaseMotion.ROTATION,),
    Aim.FIND: (BaseMotion.ROTATION,),
    Aim.LOOK: (),
    Aim.SEE: (),
    Aim.COLOURS: (),
    Aim.HOME: tuple(BaseMotion),
    Aim.STEP: (),
}


def mandate_of(plan: Plan, capabilities: Capabilities) -> Mandate:
    """Return the mandate of a screened plan: exactly its calls, metres and degrees, and the robot's time limit."""
    return Mandate(
        calls=dict(Counter(step.op for step in plan.steps)),
        distance_m=plan.distance_m,
        degrees=sum(step.degrees or 0.0 for step in plan.steps),
        seconds=capabilities.limits.command_s,
        steps=len(plan.steps),
    )


def goal_mandate(goal: Goal, most: Mandate, capabilities: Capabilities) -> Mandate:
    """Return the mandate of a screened goal: the operations it implies, within `most` and the limits of a command.

    `most` is what the robot's owner allows for visual goals: metres, degrees, seconds, steps, speed, and pictures in
    `calls`. Steps that the goal names are added, as often as they are named, within the same limits.
    """
    limits, named = capabilities.limits, Plan(goal.steps)
    implied = {motion for task in goal.tasks for motion in _implied(task.aim, task.where)}
    searching = {one.name: one.base_motion for one in capabilities.operations if one.base_motion in implied}
    motions = min(most.steps, limits.command_steps)
    calls = Counter(step.op for step in goal.steps)
    calls.update(dict.fromkeys(searching, motions))
    for operation in capabilities.operations:
        calls[operation.name] += most.calls.get(operation.name, 0) if operation.picture else 0
    looking_m = most.distance_m if BaseMotion.TRANSLATION in searching.values() else 0.0
    looking_deg = most.degrees if BaseMotion.ROTATION in searching.values() else 0.0
    return Mandate(
        calls={op: min(count, most.steps) for op, count in calls.items() if count},
        distance_m=min(looking_m + named.distance_m, limits.command_m),
        degrees=looking_deg + sum(step.degrees or 0.0 for step in goal.steps),
        seconds=min(most.seconds, limits.command_s),
        steps=most.steps,
        speed_mps=min(most.speed_mps or limits.speed_mps, limits.speed_mps),
        motions=motions,
    )


def _implied(aim: Aim, where: str) -> tuple[BaseMotion, ...]:
    return (BaseMotion.ROTATION,) if aim is Aim.LOOK and where else _IMPLIED[aim]


def mandate_violation(mandate: Mandate, used: Sequence[ActionResult], step: Primitive) -> str | None:
    """Return why `step` would exceed the mandate after `used`, in English, or None if it is within.

    A malformed step, for example with a negative or missing amount, always violates it. Steps count with the amounts
    that were requested, whatever their outcome; only skipped steps do not count.
    """
    tried = [result for result in used if result.outcome is not Outcome.SKIPPED]
    steps = [*(result.primitive for result in tried), step]
    calls = sum(s.op is step.op for s in steps)
    motions = sum(s.moves for s in steps)
    distance_m = sum(s.travel_m for s in steps)
    degrees = sum(s.degrees or 0.0 for s in steps)
    seconds = sum(result.duration_s for result in tried)
    as_declared = step.walks or step.operation.objection(step.arguments) is None
    if not (step.well_formed and as_declared):
        return f"{step.op} {step.asked()} is not a valid step."
    if len(steps) > mandate.steps:
        return f"The command allows {mandate.steps} steps; this would be step {len(steps)}."
    if step.moves and mandate.motions is not None and motions > mandate.motions:
        return f"The command allows {mandate.motions} motions; this would be motion {motions}."
    if calls > mandate.calls.get(step.op, 0):
        return f"The command allows {step.op} {mandate.calls.get(step.op, 0)} times; this would be time {calls}."
    if not distance_m <= mandate.distance_m + ROUNDING:
        return f"The command allows {mandate.distance_m:.2f} m in all; this would make {distance_m:.2f} m."
    if not degrees <= mandate.degrees + ROUNDING:
        return f"The command allows {mandate.degrees:.0f}° in all; this would make {degrees:.0f}°."
    if step.translates and mandate.speed_mps is not None and not (step.speed_mps or math.inf) <= mandate.speed_mps:
        return f"The command allows {mandate.speed_mps:g} m/s at most."
    if seconds >= mandate.seconds:
        return f"The command's time of {mandate.seconds:.0f} s is used up."
    return None
