"""Estimate how long a plan takes, rather too long than too short."""

from __future__ import annotations

from agentrob.model.plans import Direction, Op, Plan, Primitive
from agentrob.model.robots import Capabilities

#: Seconds per walk or turn for starting, settling, correcting and measuring at rest. The G1 sways long and
#: corrects by whole strides (`docs/figures.md` has its times).
SETTLING_S = 2.0
SETTLING_OF_MODEL_S = {"g1": 8.0}
#: Four-legged robots walk sideways more slowly than ahead.
SIDEWAYS_MPS = 0.3
#: Whole gestures, in seconds, the longer one where two robots do it (`docs/gestures.md` has the simulated ones).
GESTURE_S = {
    Op.HELLO: 8.0,
    Op.HEART: 13.0,
    Op.CLAP: 6.0,
    Op.SHAKE: 8.0,
    Op.BACKFLIP: 6.0,
    Op.SIT: 3.0,
    Op.STAND: 3.0,
    Op.STRETCH: 8.0,
    Op.GET_FRONT_IMAGE: 1.0,
}


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
    return GESTURE_S.get(step.op, max(GESTURE_S.values()))  # no measured time: assume the longest
