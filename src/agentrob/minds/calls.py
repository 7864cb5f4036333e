"""What a model asked for, checked against the schema of a tool or an answer. Pure; never raises for what models say."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from copy import deepcopy
from functools import lru_cache
from typing import Any

from pydantic import BaseModel, ValidationError

from agentrob.minds.chat import M, Tool, ToolCall
from agentrob.minds.faults import said

#: How many places of a text are tried as the beginning of a JSON object.
_TRIES = 20


def checked_call(call_id: str, name: str, raw: Any, tools: Sequence[Tool]) -> ToolCall:
    """A call with its arguments in the tool's schema, or with the problem to tell the model."""
    tool = next((t for t in tools if t.name == name), None)
    name = said(name, limit=80)
    if tool is None:
        known = ", ".join(t.name for t in tools) or "none"
        return ToolCall(call_id, name, None, f"There is no tool {name}. There are: {known}.", raw)
    arguments, problem = checked(raw, tool.arguments)
    return ToolCall(call_id, name, arguments, problem, raw)


def checked(raw: Any, kind: type[M]) -> tuple[M | None, str]:
    """The value in the schema and no problem, or None and what is wrong with it."""
    try:
        data = json.loads(raw) if isinstance(raw, str) else raw
        return kind.model_validate({} if data is None else data), ""
    except ValidationError as e:
        return None, explain(e)
    except (ValueError, RecursionError):
        return None, "This is no JSON object."


def explain(error: ValidationError) -> str:
    """What is wrong, for the model: at most five points, without the values."""
    points = [f"{'.'.join(map(str, e['loc'])) or 'it'}: {said(e['msg'])}" for e in error.errors()[:5]]
    return "; ".join(points)


def found_in(text: str, kind: type[M]) -> tuple[M | None, str]:
    """The first JSON object in a text that fits the schema, or what is wrong with the first one that there is."""
    problem = ""
    for data in _objects(text):
        value, wrong = checked(data, kind)
        if value is not None:
            return value, ""
        problem = problem or wrong
    return None, problem or "There is no JSON object in the answer."


def _objects(text: str) -> Iterator[dict[str, Any]]:
    decoder = json.JSONDecoder()
    at = -1
    for _ in range(_TRIES):
        at = text.find("{", at + 1)
        if at < 0:
            return
        try:
            data, end = decoder.raw_decode(text, at)
        except (ValueError, RecursionError):
            continue
        if isinstance(data, dict):
            yield data
            at = end - 1


def schema_of(kind: type[BaseModel]) -> dict[str, Any]:
    """The JSON schema of an answer or of a tool's arguments; a copy of its own for each caller."""
    return deepcopy(_schema_of(kind))


@lru_cache(maxsize=64)
def _schema_of(kind: type[BaseModel]) -> dict[str, Any]:
    """Made once: in a loop, the same tools are told in every turn."""
    return kind.model_json_schema()
