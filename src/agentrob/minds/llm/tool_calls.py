"""Validate a model's tool calls and answers against their schemas; for models without tool calls, ask for them in the
prompt and parse them from the text. Pure; never raises for what a model says.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from copy import deepcopy
from functools import lru_cache
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from agentrob.minds.llm.chat import M, Message, ModelReply, Question, Tool, ToolCall, ToolResult, UserMessage
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
        return ToolCall(call_id, name, None, f"There is no tool {name}. Valid: {known}.", raw)
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
    """Return the last valid one of several answers; an answer that refuses (`kind.refuses`) takes precedence.

    pydantic-ai's tool output takes the first valid one, and so could drop a refusal (law 7).
    """
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


# ---------------------------------------------------------------------- models without tool calls
class _PromptedCall(BaseModel):
    model_config = ConfigDict(extra="ignore")

    tool: str
    arguments: dict[str, Any] = {}


def with_prompted_tools(system_prompt: str, conversation: Sequence[Message], tools: Sequence[Tool]) -> Question:
    """Return the question as text: tools are described in the prompt, calls are JSON and results our messages."""
    lines = [f"- {t.name}: {t.description} Arguments: {json.dumps(schema_of(t.arguments))}" for t in tools]
    how = [
        "",
        "You have these tools:",
        *lines,
        'To use one, answer only with {"tool": "its name", "arguments": {…}}; its result is the next message.',
        "To end, answer in plain words without JSON.",
    ]
    return Question("\n".join([system_prompt, *(how if tools else ())]), [_as_text(m) for m in conversation])


def prompted_reply(text: str, number: int, tools: Sequence[Tool]) -> ModelReply:
    """Parse a text into at most one tool call, or plain words. `number` makes the call's id."""
    call, _ = found_in(text, _PromptedCall)
    if call is None or not tools:
        return ModelReply(text.strip())
    return ModelReply("", (checked_call(f"call_{number}", call.tool, call.arguments, tools),))


def _as_text(message: Message) -> Message:
    if isinstance(message, ModelReply):
        calls = [json.dumps({"tool": c.name, "arguments": _data(c.raw)}, ensure_ascii=False) for c in message.calls]
        return ModelReply("\n".join([message.text, *calls] if message.text else calls))
    if isinstance(message, ToolResult):
        return UserMessage(f"Result of {message.call.name}: {message.content}", message.images)
    return message


def _data(raw: Any) -> Any:
    if isinstance(raw, str):
        try:
            return json.loads(raw)
        except (ValueError, RecursionError):
            return {}
    return raw
