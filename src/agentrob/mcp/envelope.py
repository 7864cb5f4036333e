"""The envelope of every tool answer: `{ok, tool, data | error, trace_id}`, for results and errors."""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel
from pydantic_core import from_json, to_json

from agentrob.errors import (
    AgentRobError,
    ForumDenied,
    ForumError,
    ForumLimited,
    ForumNotFound,
    ForumUnoffered,
    ForumUnreachable,
)

#: The JSON Schema of every tool's output; one for all keeps the list of tools short.
SCHEMA: dict[str, Any] = {"type": "object", "required": ["ok", "tool", "trace_id"]}


class ToolError(AgentRobError):
    """A tool error. `code` is stable, `hint` says what would work, `retryable` whether to call again later."""

    def __init__(
        self, code: str, message: str, hint: str = "", retryable: bool = False, retry_after_s: float | None = None
    ) -> None:
        super().__init__(message)
        self.code = code
        self.hint = hint
        self.retryable = retryable
        self.retry_after_s = retry_after_s


def new_trace_id() -> str:
    return secrets.token_hex(8)


@dataclass(frozen=True, slots=True)
class Envelope:
    """An envelope as compact JSON. `code` is "ok" or that of the error."""

    text: str
    code: str = "ok"

    def structure(self) -> dict[str, Any]:
        found: dict[str, Any] = from_json(self.text)
        return found


def success(tool: str, data: BaseModel | dict[str, Any], trace_id: str) -> Envelope:
    """The envelope of a result; a model's defaults are left out."""
    shown = data.model_dump_json(exclude_defaults=True) if isinstance(data, BaseModel) else _json(data)
    return Envelope(f'{{"ok":true,"tool":{_json(tool)},"data":{shown},"trace_id":"{trace_id}"}}')


def failure(tool: str, error: Exception, trace_id: str) -> Envelope:
    """The envelope of an error. Unexpected errors have the code `internal`, and their text is only logged."""
    tool_error = as_tool_error(error)
    body = {"ok": False, "tool": tool[:64], "error": error_body(tool_error), "trace_id": trace_id}
    return Envelope(_json(body), tool_error.code)


def _json(value: Any) -> str:
    return to_json(value).decode()


def error_body(error: ToolError) -> dict[str, Any]:
    """The error's fields; `retry_after_s` only when the forum named a time."""
    body = {"code": error.code, "message": str(error), "hint": error.hint, "retryable": error.retryable}
    return body if error.retry_after_s is None else {**body, "retry_after_s": error.retry_after_s}


def as_tool_error(error: Exception) -> ToolError:
    match error:
        case ToolError():
            return error
        case ForumUnoffered():
            return ToolError("not_offered", str(error), "this forum does not support it; do not try again")
        case ForumNotFound():
            return ToolError("not_found", str(error), "list_boards, list_posts and search_posts give ids that exist")
        case ForumDenied():
            return ToolError("denied", str(error), "the account lacks this right; login_account may switch to another")
        case ForumLimited():
            wait = f"wait {error.retry_after_s:g} s, then send it again with the same key"
            return ToolError("rate_limited", str(error), wait, True, error.retry_after_s)
        case ForumUnreachable():
            return ToolError("unreachable", str(error), "send it again with the same key in a moment", retryable=True)
        case ForumError():
            return ToolError("refused", str(error), "the forum rejected the content")
    return ToolError("internal", "something went wrong; the server's log has it under this trace id", "")
