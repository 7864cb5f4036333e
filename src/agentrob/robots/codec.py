"""Converts robot data to JSON and back, for the driver's socket (docs/reference/interfaces.md)."""

from __future__ import annotations

import base64
import unicodedata
from dataclasses import asdict, fields
from datetime import datetime
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from agentrob.errors import RobotError
from agentrob.model import (
    ActionResult,
    Capabilities,
    Hindrance,
    Lock,
    Pose,
    Posture,
    Primitive,
    RobotState,
    StopResult,
)
from agentrob.model.operations.data import as_data, operation_of

T = TypeVar("T")

NAME_CHARACTERS = 100

_PRIMITIVE = TypeAdapter(Primitive)
_CAPABILITIES = TypeAdapter(Capabilities)
_STATE = TypeAdapter(RobotState)
_RESULT = TypeAdapter(ActionResult)
_STOP = TypeAdapter(StopResult)
_LOCK = TypeAdapter(Lock)
_POSE = TypeAdapter(Pose)
_POSTURE = TypeAdapter(Posture)
_HINDRANCE = TypeAdapter(Hindrance)


def encode(
    fact: Capabilities | RobotState | Primitive | ActionResult | StopResult | Lock | Pose | Posture | Hindrance,
) -> dict[str, Any]:
    """Return JSON data: enums as strings, sets and tuples as lists, images as base64, infinity and NaN as null."""
    if isinstance(fact, Primitive):
        return _primitive(fact)
    if isinstance(fact, Capabilities):
        can: dict[str, Any] = _plain({f.name: getattr(fact, f.name) for f in fields(fact)})
        return can | {"limits": asdict(fact.limits), "declared": [as_data(one) for one in fact.declared]}
    if not isinstance(fact, ActionResult):
        return _plain(asdict(fact))  # type: ignore[no-any-return]
    image = None if fact.image is None else base64.b64encode(fact.image).decode()
    facts = {f.name: getattr(fact, f.name) for f in fields(fact)}
    return {
        **_plain({k: v for k, v in facts.items() if k != "primitive"}),
        "primitive": _primitive(fact.primitive),
        "image": image,
    }


def _primitive(step: Primitive) -> dict[str, Any]:
    """Return a step as JSON data: its arguments as an object, without the declaration of its operation."""
    facts = {f.name: getattr(step, f.name) for f in fields(step) if f.name not in ("arguments", "declared")}
    return _plain(facts | {"arguments": dict(step.arguments)})  # type: ignore[no-any-return]


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, frozenset):
        return sorted(str(v) for v in value)
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, datetime):
        return value.isoformat(timespec="milliseconds")
    if isinstance(value, float) and value - value != 0.0:  # infinity and NaN are not JSON
        return None
    return None if isinstance(value, bytes) else value


def display_name(text: str) -> str:
    """Return a name as one line of at most 100 characters, without control or invisible characters.

    The result is still untrusted text: escape it before showing it.
    """
    visible = "".join(" " if unicodedata.category(c) in ("Cc", "Zl", "Zp") else c for c in text[:1000])
    kept = "".join(c for c in visible if unicodedata.category(c)[0] != "C")
    return " ".join(kept.split())[:NAME_CHARACTERS].strip()


def decode_primitive(data: Any) -> Primitive:
    return _read(_PRIMITIVE, _with_pairs(data))


def decode_capabilities(data: Any) -> Capabilities:
    """Decode what a robot can do, with the operations that it declares."""
    try:
        declared = tuple(operation_of(one) for one in data.get("declared", ()))
    except ValueError as e:
        raise RobotError(f"declared: {e}") from None
    return _read(_CAPABILITIES, {**data, "declared": declared})


def decode_state(data: Any) -> RobotState:
    """Decode a state; a null `age_s` means that no state was ever received."""
    age_s = data.get("age_s")
    return _read(_STATE, {**data, "age_s": float("inf") if age_s is None else age_s})


def decode_result(data: Any) -> ActionResult:
    image = data.get("image")
    decoded = {"image": None if image is None else base64.b64decode(image), "primitive": _with_pairs(data["primitive"])}
    return _read(_RESULT, {**data, **decoded})


def _with_pairs(step: Any) -> Any:
    """Return a step's data with its arguments as `Primitive` has them; no declaration comes from outside."""
    arguments = step.get("arguments") if isinstance(step, dict) else None
    if not isinstance(arguments, dict):
        return {k: v for k, v in step.items() if k != "declared"} if isinstance(step, dict) else step
    return {**step, "arguments": tuple(arguments.items()), "declared": None}


def decode_stop(data: Any) -> StopResult:
    return _read(_STOP, data)


def decode_lock(data: Any) -> Lock:
    return _read(_LOCK, data)


def decode_pose(data: Any) -> Pose:
    return _read(_POSE, data)


def decode_posture(data: Any) -> Posture:
    return _read(_POSTURE, {**data, "age_s": float("inf") if data.get("age_s") is None else data["age_s"]})


def decode_hindrance(data: Any) -> Hindrance:
    """Decode why a robot may not move in its room; a null `silent_s` means that its driver was never heard."""
    return _read(_HINDRANCE, {**data, "silent_s": float("inf") if data["silent_s"] is None else data["silent_s"]})


def _read(adapter: TypeAdapter[T], data: Any) -> T:
    try:
        return adapter.validate_python(data)
    except ValidationError as e:
        first = e.errors()[0]
        where = ".".join(str(p) for p in first["loc"])
        raise RobotError(f"{where or 'value'}: {first['msg']} (found {first['input']!r})") from None
