"""The tools of the visual loop: the robot's operations within its mandate, and results as text for the model. Pure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from enum import Enum
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, create_model

from agentrob.language.messages.plan_text import operation_name
from agentrob.minds.llm.chat import Tool
from agentrob.model import (
    BUILT_IN,
    ActionResult,
    BaseMotion,
    Capabilities,
    Direction,
    Mandate,
    Number,
    Operation,
    Outcome,
    Primitive,
    RobotState,
    Unit,
)
from agentrob.model.operations.built_in import undeclared

#: Smallest amounts that a robot can do and measure.
LEAST_M, LEAST_DEG, LEAST_MPS = 0.02, 1.0, 0.05
FINISH = "finish"
#: Lines and characters per line that a model may write; reports show the first hundred characters.
SAID_LINES, SAID_CHARS = 4, 240
_FIELD = {
    Unit.METRES: "in metres", Unit.DEGREES: "in degrees", Unit.SECONDS: "in seconds",
    Unit.METRES_PER_SECOND: "in metres per second", Unit.PERCENT: "in percent", Unit.COUNT: "a number",
}  # fmt: skip


#: What is assumed of an operation that is not built in: it gives no picture.
_SHUT = undeclared("unknown")


class _Closed(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Nothing(_Closed):
    """No arguments."""


class Finish(_Closed):
    """The end, in the model's words."""

    outcome: Literal["done", "not_possible", "unsure"]
    saw: Annotated[list[Annotated[str, Field(max_length=SAID_CHARS)]], Field(max_length=SAID_LINES)] = []
    did: Annotated[str, Field(max_length=SAID_CHARS)] = ""


def tool_name(operation: Operation) -> str:
    """Return the tool name of an operation: `act_move`, …; one that only senses has its own name, `get_front_image`."""
    return f"act_{operation.name}" if operation.moves else operation.name


def tools_of(mandate: Mandate, capabilities: Capabilities) -> tuple[Tool, ...]:
    """Return the tools that a mandate allows, with its bounds, and `finish`."""
    found = []
    for operation in capabilities.operations:
        if not mandate.calls.get(operation.name):
            continue
        if operation.base_motion is BaseMotion.TRANSLATION:
            found.append(_move(operation, mandate, capabilities))
        elif operation.base_motion is BaseMotion.ROTATION:
            found.append(_turn(operation, mandate, capabilities))
        else:
            shown = " It is shown to you." if operation.picture else ""
            does = f"The robot's operation “{operation_name(operation, 'en')}”.{shown}"
            found.append(Tool(tool_name(operation), does, _arguments(operation)))
    return (*found, Tool(FINISH, "Ends the work and says what was seen and done.", Finish))


def step_of(name: str, arguments: BaseModel, mandate: Mandate, capabilities: Capabilities) -> tuple[Primitive, bool]:
    """Return the step of a validated call, and whether to take a picture after it."""
    values: dict[str, Any] = arguments.model_dump()
    operation = next(one for one in capabilities.operations if tool_name(one) == name)
    if operation.base_motion is None:
        settled = {k: v.value if isinstance(v, Enum) else v for k, v in values.items() if v is not None}
        return capabilities.bound(Primitive(operation.name, arguments=operation.complete(settled))), False
    direction = Direction(values["direction"].value)
    speed = (values.get("speed_mps") or mandate.speed_mps) if operation.base_motion is BaseMotion.TRANSLATION else None
    step = Primitive(operation.name, direction, values.get("distance_m"), values.get("degrees"), speed)
    return capabilities.bound(step), bool(values.get("look"))


def _arguments(operation: Operation) -> type[BaseModel]:
    """Return the arguments of an operation that the robot declares, with its bounds, as the arguments of a tool."""
    found: dict[str, Any] = {}
    for argument in operation.arguments:
        default: Any = ... if argument.needed else argument.default
        if isinstance(argument, Number):
            bounds = Field(ge=argument.least, le=argument.most, allow_inf_nan=False, description=_FIELD[argument.unit])
            amount: Any = Annotated[float, bounds]
            found[argument.name] = (amount | None if argument.optional else amount, default)
        else:
            found[argument.name] = (_choice(argument.name, [one.name for one in argument.options]), default)
    return create_model(operation.name, __base__=_Closed, **found) if found else Nothing


def _move(operation: Operation, mandate: Mandate, capabilities: Capabilities) -> Tool:
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
    return Tool(tool_name(operation), "Walks so many metres in a straight line, without turning.", arguments)


def _turn(operation: Operation, mandate: Mandate, capabilities: Capabilities) -> Tool:
    most_deg = min(mandate.degrees, capabilities.limits.step_deg)
    arguments = create_model(
        "Turn",
        __base__=_Closed,
        direction=(_choice("TurnDirection", [Direction.LEFT, Direction.RIGHT]), ...),
        degrees=(Annotated[float, Field(ge=LEAST_DEG, le=most_deg, allow_inf_nan=False)], ...),
        look=(bool, Field(default=False, description="take a picture afterwards")),
    )
    return Tool(tool_name(operation), "Turns on the spot.", arguments)


def _choice(name: str, values: Sequence[str]) -> Any:
    return Enum(name, [(value.upper(), str(value)) for value in values], type=str)


# ---------------------------------------------------------------------- answers to the model
def result_message(result: ActionResult, state: RobotState | None, left: dict[str, Any]) -> str:
    """Return a result as JSON: what was measured, why it ended, the robot's sensors, and the remaining budget."""
    facts: dict[str, Any] = {"outcome": str(result.outcome)}
    if quantities := {quantity.name for quantity in result.primitive.operation.measured}:
        facts["asked"] = result.primitive.asked()
        known = {k: round(v, 3) for k, v in result.measured.items() if k in quantities}
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
    allowed = [Primitive(op) for op, count in mandate.calls.items() if count]
    if any(step.translates for step in allowed):
        left["metres"] = max(0.0, round(mandate.distance_m - sum(s.travel_m for s in tried), 2))
    if any(step.rotates for step in allowed):
        left["degrees"] = max(0.0, round(mandate.degrees - sum(s.degrees or 0.0 for s in tried)))
    if pictures := sum(count for op, count in mandate.calls.items() if BUILT_IN.get(op, _SHUT).picture):
        left["pictures"] = max(0, pictures - sum(s.operation.picture for s in tried))
    return left
