"""The tools of the visual loop: the robot's operations within its mandate, and results as text for the model. Pure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from enum import Enum
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, create_model

from agentrob.minds.llm.chat import Tool
from agentrob.model import ActionResult, Capabilities, Direction, Mandate, Op, Outcome, Primitive, RobotState

#: Smallest amounts that a robot can do and measure.
LEAST_M, LEAST_DEG, LEAST_MPS = 0.02, 1.0, 0.05
FINISH = "finish"
#: Lines and characters per line that a model may write; reports show the first hundred characters.
SAID_LINES, SAID_CHARS = 4, 240
_GESTURES = {
    Op.HELLO: "Waves.",
    Op.HEART: "Makes a heart.",
    Op.CLAP: "Claps.",
    Op.SHAKE: "Offers to shake hands.",
    Op.BACKFLIP: "Flips backwards.",
    Op.SIT: "Sits down.",
    Op.STAND: "Stands up.",
    Op.STRETCH: "Stretches.",
}


class _Closed(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Nothing(_Closed):
    """No arguments."""


class Finish(_Closed):
    """The end, in the model's words."""

    outcome: Literal["done", "not_possible", "unsure"]
    saw: Annotated[list[Annotated[str, Field(max_length=SAID_CHARS)]], Field(max_length=SAID_LINES)] = []
    did: Annotated[str, Field(max_length=SAID_CHARS)] = ""


def tool_name(op: Op) -> str:
    """Return the tool name of an operation: `act_move`, …, `get_front_image`."""
    return str(op) if op is Op.GET_FRONT_IMAGE else f"act_{op}"


def tools_of(mandate: Mandate, capabilities: Capabilities) -> tuple[Tool, ...]:
    """Return the tools that a mandate allows, with its bounds, and `finish`."""
    found = []
    for op in Op:
        if not mandate.calls.get(op) or op not in capabilities.ops:
            continue
        if op is Op.MOVE:
            found.append(_move(mandate, capabilities))
        elif op is Op.TURN:
            found.append(_turn(mandate, capabilities))
        elif op is Op.GET_FRONT_IMAGE:
            found.append(Tool(tool_name(op), "Takes a picture with the front camera and shows it to you.", Nothing))
        else:
            found.append(Tool(tool_name(op), _GESTURES.get(op, f"Does: {op}."), Nothing))
    return (*found, Tool(FINISH, "Ends the work and says what was seen and done.", Finish))


def step_of(name: str, arguments: BaseModel, mandate: Mandate) -> tuple[Primitive, bool]:
    """Return the step of a validated call, and whether to take a picture after it."""
    said: dict[str, Any] = arguments.model_dump()
    op = next(o for o in Op if tool_name(o) == name)
    direction = Direction(said["direction"].value) if "direction" in said else None
    speed = (said.get("speed_mps") or mandate.speed_mps) if op is Op.MOVE else None
    step = Primitive(op, direction, said.get("distance_m"), said.get("degrees"), speed)
    return step, bool(said.get("look"))


def _move(mandate: Mandate, capabilities: Capabilities) -> Tool:
    most_m = min(mandate.distance_m, capabilities.limits.step_m)
    most_mps = min(mandate.speed_mps or capabilities.limits.speed_mps, capabilities.limits.speed_mps)
    arguments = create_model(
        "Move",
        __base__=_Closed,
        direction=(_choice("MoveDirection", [d for d in Direction if d in capabilities.move_directions]), ...),
        distance_m=(Annotated[float, Field(ge=LEAST_M, le=most_m, allow_inf_nan=False)], ...),
        speed_mps=(Annotated[float, Field(ge=LEAST_MPS, le=most_mps, allow_inf_nan=False)] | None, None),
        look=(bool, Field(default=False, description="take a picture afterwards")),
    )
    return Tool(tool_name(Op.MOVE), "Walks so many metres in a straight line, without turning.", arguments)


def _turn(mandate: Mandate, capabilities: Capabilities) -> Tool:
    most_deg = min(mandate.degrees, capabilities.limits.step_deg)
    arguments = create_model(
        "Turn",
        __base__=_Closed,
        direction=(_choice("TurnDirection", [Direction.LEFT, Direction.RIGHT]), ...),
        degrees=(Annotated[float, Field(ge=LEAST_DEG, le=most_deg, allow_inf_nan=False)], ...),
        look=(bool, Field(default=False, description="take a picture afterwards")),
    )
    return Tool(tool_name(Op.TURN), "Turns on the spot.", arguments)


def _choice(name: str, directions: Sequence[Direction]) -> Any:
    return Enum(name, [(d.name, d.value) for d in directions], type=str)


# ---------------------------------------------------------------------- what the model is told
def result_message(result: ActionResult, state: RobotState | None, left: dict[str, Any]) -> str:
    """Return a result as JSON: what was measured, why it ended, the robot's sensors, and the remaining budget."""
    facts: dict[str, Any] = {"outcome": str(result.outcome)}
    if result.primitive.op in (Op.MOVE, Op.TURN):
        facts["asked"] = result.primitive.asked()
        known = {k: round(v, 3) for k, v in result.measured.items() if k in ("distance_m", "degrees")}
        facts["measured"] = known or (f"unknown: {result.unmeasured}" if result.unmeasured else "unknown")
    if result.outcome is not Outcome.DONE:
        facts |= {"reason": result.reason, "message": result.message}
    return json.dumps({**facts, **state_data(state), "left": left}, ensure_ascii=False)


def problem_message(problem: str, left: dict[str, Any]) -> str:
    """Return a rejected call as JSON, with the remaining budget."""
    return json.dumps({"outcome": "not done", "problem": problem, "left": left}, ensure_ascii=False)


def state_data(state: RobotState | None) -> dict[str, Any]:
    """Return what the model needs to know of the robot's state."""
    if state is None:
        return {"state": "unknown"}
    names = ("front", "left", "back", "right")
    ranges = {n: round(r, 2) for n, r in zip(names, state.ranges_m, strict=True) if r}
    return {"state": {"mode": state.mode, "battery_percent": state.battery_percent, "free_m": ranges or "unknown"}}


def remaining(mandate: Mandate, used: Sequence[ActionResult], calls: int, seconds: float) -> dict[str, Any]:
    """Return what is left of a mandate after these results; `calls` and `seconds` are the loop's."""
    tried = [r.primitive for r in used if r.outcome is not Outcome.SKIPPED]
    left: dict[str, Any] = {"calls": max(0, calls), "seconds": max(0, round(seconds))}
    for op in (Op.MOVE, Op.TURN, Op.GET_FRONT_IMAGE):
        if not mandate.calls.get(op):
            continue
        if op is Op.MOVE:
            left["metres"] = max(0.0, round(mandate.distance_m - sum(s.distance_m or 0.0 for s in tried), 2))
        elif op is Op.TURN:
            left["degrees"] = max(0.0, round(mandate.degrees - sum(s.degrees or 0.0 for s in tried)))
        else:
            left["pictures"] = max(0, mandate.calls[op] - sum(s.op is op for s in tried))
    return left
