"""Converts robot data to JSON and back, for the driver's socket (docs/seams.md)."""

from __future__ import annotations

import base64
import unicodedata
from dataclasses import asdict
from datetime import datetime
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from agentrob.errors import RobotError
from agentrob.model import ActionResult, Capabilities, Lock, Pose, Posture, Primitive, RobotState, StopResult

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


def encode(
    fact: Capabilities | RobotState | Primitive | ActionResult | StopResult | Lock | Pose | Posture,
) -> dict[str, Any]:
    """Return JSON data: enums as strings, sets and tuples as lists, images as base64, infinity and NaN as null."""
    if not isinstance(fact, ActionResult):
        return _plain(asdict(fact))  # type: ignore[no-any-return]
    image = None if fact.image is None else base64.b64encode(fact.image).decode()
    return {**_plain(asdict(fact)), "image": image}


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
    return _read(_PRIMITIVE, data)


def decode_capabilities(data: Any) -> Capabilities:
    return _read(_CAPABILITIES, data)


def decode_state(data: Any) -> RobotState:
    """Decode a state; a null `age_s` means that no state was ever received."""
    age_s = data.get("age_s")
    return _read(_STATE, {**data, "age_s": float("inf") if age_s is None else age_s})


def decode_result(data: Any) -> ActionResult:
    image = data.get("image")
    return _read(_RESULT, {**data, "image": None if image is None else base64.b64decode(image)})


def decode_stop(data: Any) -> StopResult:
    return _read(_STOP, data)


def decode_lock(data: Any) -> Lock:
    return _read(_LOCK, data)


def decode_pose(data: Any) -> Pose:
    return _read(_POSE, data)


def decode_posture(data: Any) -> Posture:
    return _read(_POSTURE, {**data, "age_s": float("inf") if data.get("age_s") is None else data["age_s"]})


def _read(adapter: TypeAdapter[T], data: Any) -> T:
    try:
        return adapter.validate_python(data)
    except ValidationError as e:
        first = e.errors()[0]
        where = ".".join(str(p) for p in first["loc"])
        raise RobotError(f"{where or 'value'}: {first['msg']} (found {first['input']!r})") from None
