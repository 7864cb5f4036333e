"""Validate a model's tool calls and answers against their schemas. Pure; never raises for what a model says."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from copy import deepcopy
from functools import lru_cache
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from agentrob.minds.llm.chat import M, Tool, ToolCall
from agentrob.minds.llm.errors import one_line

#: How many positions in a text are tried as the beginning of a JSON object.
_TRIES = 200
#: How many invalid parts are removed from an answer.
_REPAIRS = 4
#: Models write raw line breaks into strings.
_JSON = json.JSONDecoder(strict=False)


def checked_call(call_id: str, name: str, raw: Any, tools: Sequence[Tool]) -> ToolCall:
    """Return a call with arguments in the tool's schema, or with the problem to tell the model."""
    tool = next((t for t in tools if t.name == name), None)
    name = one_line(name, limit=80)
    if tool is None:
        known = ", ".join(t.name for t in tools) or "none"
        return ToolCall(call_id, name, None, f"There is no tool {name}. There are: {known}.", raw)
    arguments, problem = checked(raw, tool.arguments)
    return ToolCall(call_id, name, arguments, problem, raw)


def checked(raw: Any, kind: type[M]) -> tuple[M | None, str]:
    """Return the validated value and no problem, or None and what is wrong."""
    try:
        data = json.loads(raw) if isinstance(raw, str) else raw
        return kind.model_validate({} if data is None else data), ""
    except ValidationError as e:
        return None, explain(e)
    except (ValueError, RecursionError):
        return None, "This is not a JSON object."


def answered(raw: Any, kind: type[M]) -> tuple[M | None, str]:
    """Like `checked`, for answers: unknown keys, and nulls for fields with a default, are ignored."""
    try:
        data = _JSON.decode(raw) if isinstance(raw, str) else deepcopy(raw)
        for _ in range(_REPAIRS):
            try:
                return kind.model_validate({} if data is None else data), ""
            except ValidationError as e:
                if not [error for error in e.errors() if _left_out(data, error)]:
                    return None, explain(e)
        return checked(data, kind)
    except (ValueError, RecursionError):
        return None, "This is not a JSON object."


def _left_out(data: Any, error: ErrorDetails) -> bool:
    """Remove one unknown key, or one null where a value is required; return False if the error is neither."""
    if error["type"] != "extra_forbidden" and error["input"] is not None:
        return False
    *path, last = error["loc"]
    for part in path:
        data = data[part]
    if not isinstance(data, dict) or last not in data:
        return False
    del data[last]
    return True


def explain(error: ValidationError) -> str:
    """Explain to the model what is wrong: at most five points, without the values."""
    points = [f"{'.'.join(map(str, e['loc'])) or 'it'}: {one_line(e['msg'])}" for e in error.errors()[:5]]
    return "; ".join(points)


def found_in(text: str, kind: type[M]) -> tuple[M | None, str]:
    """Return the answer in a text's JSON objects (`final_of`), or what is wrong with the last one.

    Text before the end of a model's thoughts (`</think>`) is a draft and counts only if nothing follows.
    """
    _, _, said_last = text.rpartition("</think>")
    for part in dict.fromkeys((said_last, text)):
        value, problem = final_of(list(_objects(part)), kind)
        if value is not None:
            return value, ""
    broken = getattr(kind, "from_broken", None)  # an object that breaks off may say enough
    value = broken(said_last) if broken is not None else None
    return value, "" if value is not None else problem


def final_of(given: Sequence[Any], kind: type[M]) -> tuple[M | None, str]:
    """Return the last valid one of several answers; an answer that refuses (`kind.refuses`) takes precedence."""
    found, problem = list[M](), "There is no JSON object in the answer."
    for raw in given:
        value, wrong = answered(raw, kind)
        if value is not None:
            found.append(value)
        problem = wrong or problem
    if not found:
        return None, problem
    refusing = [value for value in found if getattr(value, "refuses", False)]
    return (refusing or found)[-1], ""


def _objects(text: str) -> Iterator[dict[str, Any]]:
    at = -1
    for _ in range(_TRIES):
        at = text.find("{", at + 1)
        if at < 0:
            return
        try:
            data, end = _JSON.raw_decode(text, at)
        except (ValueError, RecursionError):
            continue
        if isinstance(data, dict):
            yield data
            at = end - 1


def schema_of(kind: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON schema of an answer or of a tool's arguments, as a fresh copy."""
    return deepcopy(_schema_of(kind))


@lru_cache(maxsize=64)
def _schema_of(kind: type[BaseModel]) -> dict[str, Any]:
    """Cache the schema: in a loop, the same tools are described in every turn."""
    return kind.model_json_schema()
