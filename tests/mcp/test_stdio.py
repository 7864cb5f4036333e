"""The stdio transport answers a malformed line with an error and serves the next one."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from typing import Any, BinaryIO

import anyio
import pytest
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server

from agentrob.mcp import stdio
from agentrob.mcp.standard_pipes import pipe_files

PING = b'{"jsonrpc":"2.0","id":1,"method":"ping"}\n'


async def answers(monkeypatch: pytest.MonkeyPatch, expected: int, *lines: bytes) -> list[dict[str, Any]]:
    """Send lines to a server; return its responses. The client closes its end after the expected number of
    responses."""
    written: list[str] = []
    complete = anyio.Event()
    if not expected:
        complete.set()

    class Source:
        def __aiter__(self) -> Any:
            return self._lines()

        async def _lines(self) -> Any:
            for line in b"".join(lines).splitlines(keepends=True):
                yield line.decode("utf-8", "replace")
            await complete.wait()

    class Target:
        async def write(self, text: str) -> None:
            written.append(text)
            if len(written) >= expected:
                complete.set()

        async def flush(self) -> None:
            pass

    monkeypatch.setattr(stdio, "stdio_server", lambda *_: stdio_server(Source(), Target()))  # type: ignore[arg-type]
    server: Server[Any] = Server("test")
    with anyio.fail_after(20):
        await stdio.serve_stdio(server, server.create_initialization_options())
    assert all(text.count("\n") == 1 and text.endswith("\n") for text in written), "each answer is one whole line"
    return [json.loads(text) for text in written]


async def test_malformed_lines_are_answered_and_empty_lines_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
    said = await answers(monkeypatch, 3, PING, b"\n", b" \r\n", b"nonsense\n", PING)
    assert sorted(a["id"] is None for a in said) == [False, False, True]
    said = await answers(monkeypatch, 1, PING[:-1])
    assert [a["id"] for a in said] == [1], "the last line needs no end"
    assert await answers(monkeypatch, 0) == []


@pytest.mark.parametrize(
    ("line", "code", "id_"),
    [
        (b"nonsense", -32700, None),
        (b'{"jsonrpc":"2.0","id":7,', -32700, None),
        (b"\xff\xfe", -32700, None),
        (b"[" * 5_000, -32700, None),
        (b"[]", -32600, None),
        (b'[{"jsonrpc":"2.0","id":1,"method":"ping"}]', -32600, None),
        (b'{"jsonrpc":"1.0","id":7,"method":"ping"}', -32600, 7),
        (b"x" * 5_000, -32700, None),
    ],
)
async def test_a_line_that_is_not_a_message_is_answered_and_the_next_one_read(
    monkeypatch: pytest.MonkeyPatch, line: bytes, code: int, id_: int | None
) -> None:
    refused, ponged = sorted(await answers(monkeypatch, 2, line + b"\n", PING), key=lambda a: "result" in a)
    assert (refused["jsonrpc"], refused["id"], refused["error"]["code"]) == ("2.0", id_, code)
    assert (ponged["id"], ponged["result"]) == (1, {})


@pytest.fixture(params=["pipe", "socket"])
def ends(request: pytest.FixtureRequest) -> Iterator[tuple[BinaryIO, BinaryIO, BinaryIO, BinaryIO]]:
    """The ends that a server reads and writes, and those that its client does: pipes, or sockets as Node gives them."""
    with contextlib.ExitStack() as stack:
        if request.param == "pipe":
            (source, into), (out, target) = os.pipe(), os.pipe()
        else:
            pairs = (*socket.socketpair(), *socket.socketpair())
            source, into, out, target = (one.detach() for one in pairs)
        client = [stack.enter_context(os.fdopen(fd, mode, 0)) for fd, mode in ((into, "wb"), (out, "rb"))]
        yield os.fdopen(source, "rb", 0), os.fdopen(target, "wb", 0), client[0], client[1]


async def test_pipes_carry_lines_of_any_length_in_both_directions(
    ends: tuple[BinaryIO, BinaryIO, BinaryIO, BinaryIO],
) -> None:
    *server, into, out = ends
    sent = ["short\n", "机器人" * 100_000 + "\n", "\n", "no end"]

    def use() -> list[bytes]:
        into.write("".join(sent).encode())  # more than a pipe holds: it must be read meanwhile
        into.close()
        return list(out)

    with anyio.fail_after(60):
        client = asyncio.create_task(asyncio.to_thread(use))
        async with pipe_files(*server) as (source, target):
            assert [line async for line in source] == sent
            for line in sent:
                await target.write(line)
        assert b"".join(await client).decode() == "".join(sent)


async def test_writing_to_a_client_that_has_closed_its_end_is_an_error(
    ends: tuple[BinaryIO, BinaryIO, BinaryIO, BinaryIO],
) -> None:
    *server, _into, out = ends
    with anyio.fail_after(60):
        async with pipe_files(*server) as (_, target):
            waiting = asyncio.create_task(target.write("x" * 10_000_000))
            await asyncio.to_thread(out.read, 1)
            assert not waiting.done(), "a write ends when the pipe has all of it"
            out.close()
            with pytest.raises(ConnectionError):
                await waiting


def test_what_other_code_prints_does_not_get_between_the_messages() -> None:
    program = (
        "import asyncio, os, sys\n"
        "from agentrob.mcp.standard_pipes import are_pipes, standard_pipes\n"
        "async def main():\n"
        "    async with standard_pipes() as (source, target):\n"
        "        os.system('echo noise; cat')\n"
        "        await target.write('heard ' + await source.readline())\n"
        "assert are_pipes()\n"
        "asyncio.run(main())\n"
        "print('restored', sys.stdin.read())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], input=b"words\n", capture_output=True, timeout=60, check=True
    )
    assert done.stdout == b"heard words\nrestored \n"
    assert done.stderr == b"noise\n"
