"""The stdio transport answers a malformed line with an error and serves the next one."""

from __future__ import annotations

import json
from typing import Any

import anyio
import pytest
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server

from agentrob.mcp import stdio

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

    monkeypatch.setattr(stdio, "stdio_server", lambda: stdio_server(Source(), Target()))  # type: ignore[arg-type]
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
