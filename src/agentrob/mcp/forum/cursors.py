"""Opaque cursors: what to go on with, bound to the tool and the place they were given out for.

They hold nothing secret and need no signature: a made-up one only asks for a page that its maker might ask for anyway.
"""

from __future__ import annotations

import base64
import json
from typing import Any

from agentrob.mcp.envelope import ToolError


def seal(tool: str, place: str, **state: Any) -> str:
    """A cursor for the next call of this tool at this place (a board, a topic, a query)."""
    packed = json.dumps([tool, place, state], ensure_ascii=False, separators=(",", ":"))
    return base64.urlsafe_b64encode(packed.encode("utf-8", "surrogatepass")).decode().rstrip("=")


def place_in(state: dict[str, Any], name: str = "at") -> str | None:
    """The forum's own cursor in a cursor of ours."""
    found = state.get(name)
    if found is not None and not isinstance(found, str):
        raise ToolError("invalid_arguments", "that cursor was not given out", "send it as it was given")
    return found


def number_in(state: dict[str, Any], name: str) -> int:
    """A number in a cursor of ours; 0 when it is not there."""
    found = state.get(name, 0)
    if type(found) is not int or not 0 <= found < 2**31:
        raise ToolError("invalid_arguments", "that cursor was not given out", "send it as it was given")
    return found


def unseal(tool: str, place: str, cursor: str | None) -> dict[str, Any]:
    """What a cursor holds; empty without one. `ToolError` when it was given out for something else."""
    if cursor is None:
        return {}
    try:
        packed = base64.urlsafe_b64decode(cursor.encode("ascii") + b"=" * (-len(cursor) % 4))
        of_tool, of_place, state = json.loads(packed.decode("utf-8", "surrogatepass"))
        if (of_tool, of_place) == (tool, place) and isinstance(state, dict):
            return state
    except (ValueError, TypeError, RecursionError):
        pass
    raise ToolError("invalid_arguments", "that cursor does not belong here", f"send `next` of {tool} as it was given")
