"""Serves an MCP server over standard input and output, and answers lines that are no JSON-RPC message."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
import mcp_types as types
from anyio.streams.memory import MemoryObjectReceiveStream
from mcp.server.lowlevel import Server
from mcp.server.models import InitializationOptions
from mcp.server.stdio import stdio_server
from mcp.shared.message import SessionMessage
from pydantic import ValidationError

Incoming = SessionMessage | Exception


async def serve_stdio(server: Server[Any], options: InitializationOptions) -> None:
    """Serve one client until it closes standard input, or until it can no longer be written to."""
    try:
        async with stdio_server() as (read, write), _answer_malformed(read, write) as messages:
            await server.run(messages, write, options)
    except* (ConnectionError, anyio.BrokenResourceError):  # the client closed its end
        pass


@asynccontextmanager
async def _answer_malformed(read: Any, write: Any) -> AsyncIterator[MemoryObjectReceiveStream[Incoming]]:
    """The messages of `read`; a malformed line is answered with a JSON-RPC error, where the SDK only logs it."""
    send, messages = anyio.create_memory_object_stream[Incoming]()

    async def relay() -> None:
        async with send:
            async for item in read:
                if isinstance(item, SessionMessage):
                    await send.send(item)
                elif (error := malformed(item)) is not None:
                    await write.send(SessionMessage(error))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(relay)
        yield messages
        tasks.cancel_scope.cancel()


def malformed(error: Exception) -> types.JSONRPCError | None:
    """The answer to a line that failed validation, as JSON-RPC 2.0 wants it; None for an empty line."""
    found = error.errors(include_url=False, include_context=False) if isinstance(error, ValidationError) else []
    if found and found[0]["type"] == "json_invalid":
        if isinstance(line := found[0]["input"], str) and not line.strip():
            return None
        return _error(None, types.PARSE_ERROR, "this line is not JSON")
    request = next((e["input"] for e in found if isinstance(e["input"], dict)), {})
    number = request.get("id")
    if not isinstance(number, str | int) or isinstance(number, bool):
        number = None
    return _error(number, types.INVALID_REQUEST, "this is not a JSON-RPC 2.0 message; batches are not supported")


def _error(number: types.RequestId | None, code: int, message: str) -> types.JSONRPCError:
    return types.JSONRPCError(jsonrpc="2.0", id=number, error=types.ErrorData(code=code, message=message))
