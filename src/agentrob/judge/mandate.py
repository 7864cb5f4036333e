"""What a screened command may use up at most, so that whoever carries it out can do less but never more (law 7)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from agentrob.model import ActionResult, Capabilities, Mandate, Outcome, Plan, Primitive

#: Sums of decimal fractions are not exact; a tenth of a millimetre or degree is not an excess.
ROUNDING = 1e-4


def mandate_of(plan: Plan, capabilities: Capabilities) -> Mandate:
    """The mandate of a screened plan: exactly its calls, metres and degrees, and the robot's time for a command."""
    return Mandate(
        calls=dict(Counter(step.op for step in plan.steps)),
        distance_m=plan.distance_m,
        degrees=sum(step.degrees or 0.0 for step in plan.steps),
        seconds=capabilities.limits.command_s,
        steps=len(plan.steps),
    )


def within(mandate: Mandate, used: Sequence[ActionResult], step: Primitive) -> str | None:
    """Why `step` would exceed the mandate after `used`, in English, or None when it is within.

    Steps count by what was asked of them, whatever came of it: an attempt is used up. Only skipped ones do not count.
    """
    tried = [result for result in used if result.outcome is not Outcome.SKIPPED]
    steps = [*(result.primitive for result in tried), step]
    calls = sum(s.op is step.op for s in steps)
    distance_m = sum(s.distance_m or 0.0 for s in steps)
    degrees = sum(s.degrees or 0.0 for s in steps)
    seconds = sum(result.duration_s for result in tried)
    if len(steps) > mandate.steps:
        return f"The command allows {mandate.steps} steps; this would be step {len(steps)}."
    if calls > mandate.calls.get(step.op, 0):
        return f"The command allows {step.op} {mandate.calls.get(step.op, 0)} times; this would be time {calls}."
    if not distance_m <= mandate.distance_m + ROUNDING:
        return f"The command allows {mandate.distance_m:.2f} m in all; this would make {distance_m:.2f} m."
    if not degrees <= mandate.degrees + ROUNDING:
        return f"The command allows {mandate.degrees:.0f}° in all; this would make {degrees:.0f}°."
    if seconds >= mandate.seconds:
        return f"The command's time of {mandate.seconds:.0f} s is used up."
    return None
