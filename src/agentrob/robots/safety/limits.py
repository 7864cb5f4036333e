"""Checks that a step is well formed and within the robot's limits (law 10). Pure; NaN and infinity always fail."""

from __future__ import annotations

from agentrob.model import Capabilities, Direction, Number, Op, Primitive

TURNS = (Direction.LEFT, Direction.RIGHT)
#: The smallest step that a robot can do and measure.
LEAST_M, LEAST_DEG, LEAST_MPS = 0.01, 1.0, 0.05


def beyond_limits(primitive: Primitive, capabilities: Capabilities) -> tuple[str, str] | None:
    """Return None if the step is allowed, else a stable code and a sentence that names the limit."""
    limits = capabilities.limits
    if primitive.op is Op.MOVE:
        return _move(primitive, capabilities)
    if primitive.op is not Op.TURN:
        return _arguments(primitive, capabilities)
    degrees = primitive.degrees
    if primitive.direction not in TURNS or degrees is None or not degrees >= LEAST_DEG:
        return "invalid", f"A turn needs a direction (left or right) and at least {LEAST_DEG:g}°."
    if not degrees <= limits.step_deg:
        return "limit_step_deg", f"{degrees:g}° is more than the {limits.step_deg:g}° that one step may turn."
    return None


def _arguments(primitive: Primitive, capabilities: Capabilities) -> tuple[str, str] | None:
    """Hold the arguments of any other operation against its declaration."""
    operation = capabilities.operation(primitive.op)
    if operation is None:
        return "unsupported", f"This robot cannot {primitive.op}."
    wrong = operation.objection(primitive.arguments)
    if wrong is None:
        return None
    argument, value = wrong
    if argument is None:
        known = ", ".join(a.name for a in operation.arguments) or "none"
        return "invalid", f"{operation.name} has no argument {value!r}; its arguments: {known}."
    if value is None:
        return "invalid", f"{operation.name} needs {argument.name}: {argument.range}."
    word = "limit_argument" if isinstance(argument, Number) and isinstance(value, float | int) else "invalid"
    return word, f"{argument.name} of {operation.name} is {value}; allowed: {argument.range}."


def _move(primitive: Primitive, capabilities: Capabilities) -> tuple[str, str] | None:
    limits, distance_m, speed_mps = capabilities.limits, primitive.distance_m, primitive.speed_mps
    if primitive.direction is None or distance_m is None or not distance_m >= LEAST_M:
        return "invalid", f"A move needs a direction and a distance of at least {LEAST_M:g} m."
    if primitive.direction not in capabilities.move_directions:
        known = ", ".join(sorted(capabilities.move_directions))
        return "unsupported", f"This robot cannot move {primitive.direction}; it can: {known}."
    if not distance_m <= limits.step_m:
        return "limit_step_m", f"{distance_m:g} m is more than the {limits.step_m:g} m that one step may go."
    if speed_mps is not None and not speed_mps >= LEAST_MPS:
        return "invalid", f"A speed must be at least {LEAST_MPS:g} m/s."
    if speed_mps is not None and not speed_mps <= limits.speed_mps:
        return "limit_speed_mps", f"{speed_mps:g} m/s is more than the {limits.speed_mps:g} m/s that are allowed."
    return None
