"""Standard input and output as asynchronous files that the event loop reads and writes, if both are pipes or sockets.

`anyio.AsyncFile`, the SDK's default, hands each line that is read, written and flushed to a thread and back, which
costs a third of a tool call. Its subclasses here do the same work in the event loop.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import stat
import sys
from collections.abc import AsyncIterator, Iterator
from typing import BinaryIO, TextIO

import anyio

_CHUNK_BYTES = 1 << 16


def are_pipes() -> bool:
    """Whether standard input and output are pipes or sockets; they can also be regular files or a terminal."""
    return _is_pipe(sys.stdin, 0) and _is_pipe(sys.stdout, 1)


@contextlib.asynccontextmanager
async def standard_pipes() -> AsyncIterator[tuple[anyio.AsyncFile[str], anyio.AsyncFile[str]]]:
    """Yield standard input and output.

    Meanwhile file descriptor 0 is the null device and 1 is standard error, as in the SDK's `stdio_server`: what other
    code or a child process prints does not get between the messages.
    """
    with open(os.devnull, "rb") as null, _redirected(0, null.fileno()) as source, _redirected(1, 2) as target:  # noqa: ASYNC230
        async with pipe_files(os.fdopen(os.dup(source), "rb", 0), os.fdopen(os.dup(target), "wb", 0)) as files:
            yield files


@contextlib.asynccontextmanager
async def pipe_files(
    source: BinaryIO, target: BinaryIO
) -> AsyncIterator[tuple[anyio.AsyncFile[str], anyio.AsyncFile[str]]]:
    """Yield asynchronous files that read lines of `source` and write to `target`, and close both at the end."""
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader(_CHUNK_BYTES)
    reading, _ = await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), source)
    writing, flow = await loop.connect_write_pipe(_FlowControl, target)
    writing.set_write_buffer_limits(0)  # so that a write has ended when the pipe has everything
    try:
        yield _PipeReader(sys.stdin, reader), _PipeWriter(sys.stdout, writing, flow)
    finally:
        reading.close()
        writing.close()


class _PipeReader(anyio.AsyncFile[str]):
    def __init__(self, file: TextIO, reader: asyncio.StreamReader) -> None:
        super().__init__(file)
        self._reader, self._rest = reader, bytearray()

    async def readline(self) -> str:
        """The next line, of any length; empty at the end."""
        searched = 0
        while (end := self._rest.find(b"\n", searched)) < 0:
            searched = len(self._rest)
            chunk = await self._reader.read(_CHUNK_BYTES)
            if not chunk:
                end = searched
                break
            self._rest += chunk
        line = self._rest[: end + 1]
        del self._rest[: end + 1]
        return line.decode("utf-8", "replace")


class _PipeWriter(anyio.AsyncFile[str]):
    def __init__(self, file: TextIO, transport: asyncio.WriteTransport, flow: _FlowControl) -> None:
        super().__init__(file)
        self._transport, self._flow = transport, flow

    async def write(self, b: str) -> int:
        """Write a text and wait until the pipe has it. Raises `ConnectionError` if the other end is closed."""
        self._transport.write(b.encode("utf-8"))
        await self._flow.drained()
        return len(b)

    async def flush(self) -> None:
        """`write` has flushed already."""


class _FlowControl(asyncio.Protocol):
    """Knows whether a transport has written everything, and whether the other end is closed."""

    def __init__(self) -> None:
        self._writable, self._lost = asyncio.Event(), False
        self._writable.set()

    def pause_writing(self) -> None:
        self._writable.clear()

    def resume_writing(self) -> None:
        self._writable.set()

    def connection_lost(self, exc: Exception | None) -> None:
        self._lost = True
        self._writable.set()

    async def drained(self) -> None:
        await self._writable.wait()
        if self._lost:
            raise BrokenPipeError("the client closed its end")


def _is_pipe(stream: TextIO, descriptor: int) -> bool:
    try:
        mode = os.fstat(descriptor).st_mode
        return stream.fileno() == descriptor and (stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode))
    except (AttributeError, OSError, ValueError):
        return False


@contextlib.contextmanager
def _redirected(descriptor: int, to: int) -> Iterator[int]:
    """Redirect a file descriptor; yield a duplicate of what it was, and restore it at the end."""
    before = os.dup(descriptor)
    try:
        os.dup2(to, descriptor)
        yield before
    finally:
        os.set_blocking(before, True)  # a pipe's transport made it non-blocking
        os.dup2(before, descriptor)
        os.close(before)
