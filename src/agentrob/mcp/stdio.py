"""Serve an MCP server over standard input and output; answer malformed lines with a JSON-RPC error."""

from __future__ import annotations

import contextlib
from types import TracebackType
from typing import Any, Self

import anyio
import mcp_types as types
from mcp.server.lowlevel import Server
from mcp.server.models import InitializationOptions
from mcp.server.stdio import stdio_server
from mcp.shared.message import SessionMessage
from pydantic import ValidationError

from agentrob.mcp.standard_pipes import are_pipes, standard_pipes


async def serve_stdio(server: Server[Any], options: InitializationOptions) -> None:
    """Serve one client until it closes standard input, or until it can no longer be written to."""
    try:
        async with contextlib.AsyncExitStack() as stack:
            files = await stack.enter_async_context(standard_pipes()) if are_pipes() else ()
            read, write = await stack.enter_async_context(stdio_server(*files))
            await server.run(_WellFormed(read, write), write, options)
    except* (ConnectionError, anyio.BrokenResourceError):  # the client closed its end
        pass


class _WellFormed:
    """The messages of a stream. A malformed line is answered with a JSON-RPC error, where the SDK would only log it."""

    def __init__(self, read: Any, write: Any) -> None:
        self._read, self._write = read, write

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> SessionMessage | Exception:
        async for item in self._read:
            if isinstance(item, SessionMessage):
                return item
            if (error := malformed(item)) is not None:
                await self._write.send(SessionMessage(error))
        raise StopAsyncIteration

    async def receive(self) -> SessionMessage | Exception:
        try:
            return await anext(self)
        except StopAsyncIteration:
            raise anyio.EndOfStream from None

    async def aclose(self) -> None:
        await self._read.aclose()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.aclose()


def malformed(error: Exception) -> types.JSONRPCError | None:
    """The JSON-RPC 2.0 error for a line that failed validation; None for an empty line."""
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
