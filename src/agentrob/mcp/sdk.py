"""How a server imports the SDK: whoever spawns one waits for its first answer."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from agentrob.process.quick import quick_imports

#: What the SDK imports to serve over HTTP, whether it does or not; and the models of both eras of the protocol, of
#: which a client speaks one.
_LATER = (
    "mcp.server.auth.middleware.auth_context",
    "mcp.server.auth.middleware.bearer_auth",
    "mcp.server.auth.provider",
    "mcp.server.auth.routes",
    "mcp.server.auth.settings",
    "mcp.server.streamable_http",
    "mcp.server.streamable_http_manager",
    "mcp_types._v2025_11_25",
    "mcp_types._v2026_07_28",
    "starlette.applications",
    "starlette.middleware",
    "starlette.middleware.authentication",
    "starlette.routing",
)


@contextmanager
def sdk_imports(http: bool) -> Iterator[None]:
    """Import a server over stdio, or `http`, within this. What was imported for stdio cannot serve over HTTP too."""
    unused = ("greenlet", "rich") if http else ("greenlet", "rich", "uvicorn")
    later = () if http else _LATER
    with quick_imports(folders=("mcp", "mcp.server"), without=unused, later=later, models_later=True):
        yield
