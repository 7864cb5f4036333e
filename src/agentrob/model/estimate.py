"""Estimate how long a plan takes, rather too long than too short."""

from __future__ import annotations

from agentrob.model.operations.built_in import Direction, Op
from agentrob.model.plans import Plan, Primitive
from agentrob.model.robots import Capabilities

#: Seconds per walk or turn for starting, settling, correcting and measuring at rest. The G1 sways long and
#: corrects by whole strides (`docs/safety/figures.md` has its times).
SETTLING_S = 2.0
SETTLING_OF_MODEL_S = {"g1": 8.0}
#: Four-legged robots walk sideways more slowly than ahead.
SIDEWAYS_MPS = 0.3


def seconds_of(plan: Plan, capabilities: Capabilities) -> float:
    """Estimated duration of the whole plan in seconds, at the speeds asked for or else at the robot's limits."""
    return sum(step_seconds(step, capabilities) for step in plan.steps)


def step_seconds(step: Primitive, capabilities: Capabilities) -> float:
    """Estimated duration of one step in seconds."""
    limits = capabilities.limits
    settling_s = SETTLING_OF_MODEL_S.get(capabilities.model, SETTLING_S)
    if step.op is Op.MOVE:
        speed_mps = min(limits.speed_mps, step.speed_mps or limits.speed_mps)
        if step.direction in (Direction.LEFT, Direction.RIGHT):
            speed_mps = min(speed_mps, SIDEWAYS_MPS)
        return (step.distance_m or 0.0) / speed_mps + settling_s
    if step.op is Op.TURN:
        return (step.degrees or 0.0) / limits.turn_dps + settling_s
    operation = capabilities.operation(step.op) or step.operation
    return operation.takes_s + operation.seconds_asked(step.arguments)
