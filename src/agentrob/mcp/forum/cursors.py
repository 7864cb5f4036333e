"""Opaque page cursors, bound to a tool and to its list (of a board, a topic or a query).

They hold no secret and need no signature: a forged one can only request a page that its maker may read anyway.
"""

from __future__ import annotations

import base64
import json
from typing import Any

from agentrob.mcp.envelope import ToolError


def seal(tool: str, place: str, **state: Any) -> str:
    """A cursor for the next call of this tool for this board, topic or query."""
    packed = json.dumps([tool, place, state], ensure_ascii=False, separators=(",", ":"))
    return base64.urlsafe_b64encode(packed.encode("utf-8", "surrogatepass")).decode().rstrip("=")


def place_in(state: dict[str, Any], name: str = "at") -> str | None:
    """The forum's own cursor inside a cursor."""
    found = state.get(name)
    if found is not None and not isinstance(found, str):
        raise ToolError("invalid_arguments", "this cursor is not valid", "send `next` or `more` unchanged")
    return found


def number_in(state: dict[str, Any], name: str) -> int:
    """A number inside a cursor; 0 if it is missing."""
    found = state.get(name, 0)
    if type(found) is not int or not 0 <= found < 2**31:
        raise ToolError("invalid_arguments", "this cursor is not valid", "send `next` or `more` unchanged")
    return found


def unseal(tool: str, place: str, cursor: str | None) -> dict[str, Any]:
    """The contents of a cursor; empty without one. `ToolError` if it belongs to another tool or list."""
    if cursor is None:
        return {}
    try:
        packed = base64.urlsafe_b64decode(cursor.encode("ascii") + b"=" * (-len(cursor) % 4))
        of_tool, of_place, state = json.loads(packed.decode("utf-8", "surrogatepass"))
        if (of_tool, of_place) == (tool, place) and isinstance(state, dict):
            return state
    except (ValueError, TypeError, RecursionError):
        pass
    raise ToolError("invalid_arguments", "this cursor belongs to another list", f"send `next` of {tool} unchanged")
