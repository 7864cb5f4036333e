"""The stdio transport on the event loop itself: a line is a message, read by whoever wants the next and written by who
says it.

The SDK's own reads and writes through worker threads and hands each message on from task to task. As there, what this
process prints goes to standard error meanwhile, so that nothing but messages is on the wire. A client that stops
reading stops us from writing, and is left when it closes its end. Files and devices, which no event loop can wait for,
are copied to and from pipes by a thread each.
"""

from __future__ import annotations

import asyncio
import os
import shutil
import stat
import sys
import threading
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from types import TracebackType
from typing import Self

import anyio
import mcp_types as types
from mcp.shared.message import SessionMessage
from pydantic_core import from_json, to_json

from agentrob.mcp.envelope import Said

#: For answers that are not written yet when the client closes its end.
LAST_WORDS_S = 2.0
#: A picture of 8 MiB as base64 in JSON fits; a longer line is passed over.
MAX_LINE = 16 * 1024 * 1024
#: Stands for a line that was longer.
TOO_LONG = b"too long\n"


@asynccontextmanager
async def stdio_pipes() -> AsyncIterator[tuple[LinesIn, LinesOut]]:
    """Streams of messages from standard input and to standard output, as `Server.run` takes them."""
    reader, writer, copying = await _open()
    out = LinesOut(writer)
    yield LinesIn(reader, out.refuse), out
    with anyio.move_on_after(LAST_WORDS_S):  # what is answered already still goes out, to a client that reads
        with suppress(ConnectionError):
            await writer.drain()
        if copying is not None:
            writer.close()
            await anyio.to_thread.run_sync(copying.join, abandon_on_cancel=True)


class _Stream:
    """What the engine opens and closes; the wire itself stays open until the process ends."""

    closed = False

    async def aclose(self) -> None:
        self.closed = True

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.aclose()


class LinesIn(_Stream):
    """The client's messages. What is none is refused by `refuse`, or without it comes as the error that it made."""

    def __init__(self, reader: asyncio.StreamReader, refuse: Callable[[bytes], Awaitable[None]] | None = None) -> None:
        self._reader = reader
        self._refuse = refuse
        self._first: SessionMessage | Exception | None = None

    async def begins_with(self, method: str) -> bool:
        """Whether the very first message is such a request; it is not used up by this."""
        self._first = await anext(self, None)
        message = self._first.message if isinstance(self._first, SessionMessage) else None
        return isinstance(message, types.JSONRPCRequest) and message.method == method

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> SessionMessage | Exception:
        if (first := self._first) is not None:
            self._first = None
            return first
        while line := await self._line():
            if line.isspace():
                continue
            message = read(line)
            if self._refuse is None or isinstance(message, SessionMessage):
                return message
            await self._refuse(line)
        raise StopAsyncIteration

    async def receive(self) -> SessionMessage | Exception:
        try:
            return await anext(self)
        except StopAsyncIteration:
            raise anyio.EndOfStream from None

    async def _line(self) -> bytes:
        """The next line, b"" at the end. Of one that is too long nothing is kept but that it came: a line of
        nonsense."""
        too_long = False
        while True:
            try:
                line = await self._reader.readuntil(b"\n")
            except asyncio.IncompleteReadError as e:
                line = e.partial
            except asyncio.LimitOverrunError as e:
                await self._reader.readexactly(max(1, e.consumed))
                too_long = True
                continue
            except ConnectionError:
                return b""
            return TOO_LONG if too_long and line else line


class LinesOut(_Stream):
    """Messages to the client, each whole, in the order in which they are said."""

    def __init__(self, writer: asyncio.StreamWriter) -> None:
        self._writer = writer

    async def send(self, item: SessionMessage) -> None:
        """Returns when it is on the wire."""
        if self.closed:
            raise anyio.ClosedResourceError
        await self._write(written(item.message))

    async def refuse(self, line: bytes) -> None:
        """Tell the client that a line of its was no message."""
        with suppress(anyio.BrokenResourceError):
            await self._write(refusal(line))

    async def _write(self, message: bytes) -> None:
        try:
            self._writer.write(message + b"\n")
            await self._writer.drain()
        except ConnectionError:
            raise anyio.BrokenResourceError from None


def refusal(line: bytes) -> bytes:
    """The answer to a line that is no message, as JSON-RPC wants it: what is no JSON, or JSON of another kind."""
    told, code, message = None, types.PARSE_ERROR, "this line is no JSON"
    with suppress(ValueError):
        data = from_json(line)
        code, message = types.INVALID_REQUEST, "this is no JSON-RPC 2.0 message; batches are not taken"
        if isinstance(data, dict) and isinstance(data.get("id"), str | int) and not isinstance(data["id"], bool):
            told = data["id"]
    if line == TOO_LONG:
        message = f"a line has {MAX_LINE} bytes at most"
    return to_json({"jsonrpc": "2.0", "id": told, "error": {"code": code, "message": message}})


def read(line: bytes) -> SessionMessage | Exception:
    """A message, or why it is none."""
    try:
        return SessionMessage(types.jsonrpc_message_adapter.validate_json(line, by_name=False))
    except Exception as e:
        return e


def written(message: types.JSONRPCMessage) -> bytes:
    """A message as JSON. An envelope is JSON already."""
    if isinstance(message, types.JSONRPCResponse):
        said = message.result.get("structuredContent")
        if isinstance(said, Said):
            rest = {name: value for name, value in message.result.items() if value is not said}
            answer = to_json({"jsonrpc": "2.0", "id": message.id, "result": rest})
            return answer[:-2] + b',"structuredContent":' + said.text.encode() + b"}}"
    return message.model_dump_json(by_alias=True, exclude_unset=True).encode()


async def _open() -> tuple[asyncio.StreamReader, asyncio.StreamWriter, threading.Thread | None]:
    """The wire, from copies of the descriptors, and the thread that copies the answers, if one does; 0 is then the null
    device and 1 standard error."""
    loop = asyncio.get_running_loop()
    sys.stdout.flush()
    source, target, copying = os.dup(0), os.dup(1), None
    if not _is_pipe(source):
        (source, end), file = os.pipe(), source
        _copy(file, end)
    if not _is_pipe(target):
        (end, target), file = os.pipe(), target
        copying = _copy(end, file)
    incoming, outgoing = os.fdopen(source, "rb", 0), os.fdopen(target, "wb", 0)
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.close(null)
    os.dup2(2, 1)
    reader = asyncio.StreamReader(limit=MAX_LINE)
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), incoming)
    transport, protocol = await loop.connect_write_pipe(asyncio.streams.FlowControlMixin, outgoing)
    transport.set_write_buffer_limits(high=0)  # `drain` waits until all is on the wire
    return reader, asyncio.StreamWriter(transport, protocol, None, loop), copying


def _is_pipe(descriptor: int) -> bool:
    mode = os.fstat(descriptor).st_mode
    return stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)


def _copy(source: int, target: int) -> threading.Thread:
    """Copy from one descriptor to the other until the end of either."""

    def copy() -> None:
        with suppress(OSError), os.fdopen(source, "rb", 0) as incoming, os.fdopen(target, "wb", 0) as outgoing:
            shutil.copyfileobj(incoming, outgoing)

    thread = threading.Thread(target=copy, name="copying", daemon=True)
    thread.start()
    return thread
