"""The stdio transport on the event loop itself: a line is a message, read and written without a thread in between.

The SDK's own reads and writes through worker threads, three hops a call. As there, what this process prints goes to
standard error meanwhile, so that nothing but messages is on the wire. A client that stops reading stops us from
writing, and is left when it closes its end.
"""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
import mcp_types as types
from mcp.shared._context_streams import create_context_streams
from mcp.shared.message import SessionMessage

#: For answers that are not written yet when the client closes its end.
LAST_WORDS_S = 2.0
#: A picture of 8 MiB as base64 in JSON fits; a longer line is passed over.
MAX_LINE = 16 * 1024 * 1024


@asynccontextmanager
async def stdio_pipes() -> AsyncIterator[tuple[Any, Any]]:
    """Streams of messages from standard input and to standard output, as `Server.run` takes them."""
    reader, writer = await _open()
    incoming, read_stream = create_context_streams[SessionMessage | Exception](0)
    write_stream, outgoing = create_context_streams[SessionMessage](0)

    async def read() -> None:
        async with incoming:
            while (line := await _line(reader)) != b"":
                if not line.strip():
                    continue
                try:
                    message = types.jsonrpc_message_adapter.validate_json(line, by_name=False)
                except Exception as e:  # nonsense, of which the engine makes an error
                    await incoming.send(e)
                    continue
                await incoming.send(SessionMessage(message))

    written = anyio.Event()

    async def write() -> None:
        async with outgoing:
            async for message in outgoing:
                writer.write(message.message.model_dump_json(by_alias=True, exclude_unset=True).encode() + b"\n")
                await writer.drain()
        written.set()

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(_until_gone, read)
        tasks.start_soon(_until_gone, write)
        yield read_stream, write_stream
        await write_stream.aclose()
        with anyio.move_on_after(LAST_WORDS_S):  # what is answered already still goes out, to a client that reads
            await written.wait()
        tasks.cancel_scope.cancel()


async def _until_gone(work: Any) -> None:
    """A closed pipe or stream is the end, and no failure."""
    try:
        await work()
    except (anyio.ClosedResourceError, anyio.BrokenResourceError, ConnectionError):
        await anyio.lowlevel.checkpoint()


async def _line(reader: asyncio.StreamReader) -> bytes:
    """The next line, b"" at the end. Of one that is too long nothing is kept but that it came: a line of nonsense."""
    too_long = False
    while True:
        try:
            line = await reader.readuntil(b"\n")
        except asyncio.IncompleteReadError as e:
            line = e.partial
        except asyncio.LimitOverrunError as e:
            await reader.readexactly(max(1, e.consumed))
            too_long = True
            continue
        return b"too long\n" if too_long and line else line


async def _open() -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """The wire, from copies of the descriptors; 0 is then the null device and 1 standard error."""
    loop = asyncio.get_running_loop()
    sys.stdout.flush()
    incoming, outgoing = os.fdopen(os.dup(0), "rb", 0), os.fdopen(os.dup(1), "wb", 0)
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.close(null)
    os.dup2(2, 1)
    reader = asyncio.StreamReader(limit=MAX_LINE)
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), incoming)
    transport, protocol = await loop.connect_write_pipe(asyncio.streams.FlowControlMixin, outgoing)
    transport.set_write_buffer_limits(high=0)  # `drain` waits until all is on the wire
    return reader, asyncio.StreamWriter(transport, protocol, None, loop)
