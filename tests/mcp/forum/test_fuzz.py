"""Hostile input to the forum's tools: every result uses the envelope; nothing crashes, hangs or leaks a secret."""

from __future__ import annotations

import asyncio
import json
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agentrob.mcp.forum.arguments import input_schema
from agentrob.mcp.forum.tools import BY_NAME, TOOLS
from tests.forked_process import ForkedCommand
from tests.mcp.forum.hostile import deep, of_schema
from tests.mcp.forum.inside import memory_world, server_of
from tests.mcp.running_mcp import McpSetup

SECRET = "the-secret-token-of-nobody"
CODES = {"invalid_arguments", "not_found", "denied", "rate_limited", "unreachable", "refused", "not_offered",
         "not_allowed", "unknown_tool"}  # fmt: skip


@cache
def _strategy(name: str) -> st.SearchStrategy[Any]:
    return of_schema(input_schema(BY_NAME[name].arguments))


async def _call(name: str, arguments: Any) -> dict[str, Any]:
    """Call a tool; return the result in its wire form, as JSON."""
    world = memory_world()
    forum = world.sign_in("alice")
    topic = await forum.create_topic("robots", "A title", "hello", key="0")
    await forum.reply(topic.post.topic_id, "x" * 2_000, key="1")
    server, accounts = server_of(world, "alice")
    accounts.remember("carol", SECRET)
    said = await asyncio.wait_for(server._envelope(_Context(), name, arguments), 60)  # type: ignore[arg-type]
    await accounts.close()
    await server.close()
    return said.structure()


class _Context:
    """The attributes of a request context that a tool call uses."""

    protocol_version = "2026-07-28"
    session = None


@pytest.mark.parametrize("name", [t.name for t in TOOLS])
@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(data=st.data())
def test_a_tool_answers_any_arguments_in_the_envelope(name: str, data: st.DataObject) -> None:
    said = asyncio.run(_call(name, data.draw(_strategy(name))))
    assert set(said) - {"data", "error"} == {"ok", "tool", "trace_id"}
    assert said["ok"] or said["error"]["code"] in CODES, said
    assert SECRET not in json.dumps(said)


@pytest.mark.parametrize("name", [t.name for t in TOOLS])
def test_deep_and_huge_json_is_refused_in_the_envelope(name: str) -> None:
    for value in (deep(900), {"a": {"b": deep(300)}}, ["x" * 1_000] * 1_000, 10**400):
        schema = input_schema(BY_NAME[name].arguments)
        arguments = dict.fromkeys(schema["properties"], value) or {"x": value}
        said = asyncio.run(_call(name, arguments))
        assert said["error"]["code"] == "invalid_arguments"
        assert len(json.dumps(said)) < 3_000, "the error must not repeat what was given"


# ---------------------------------------------------------------------- on the wire of a real process
@pytest.fixture
def wire(setup: McpSetup, tmp_path: Path) -> Iterator[ForkedCommand]:
    process = setup.stdio("op", log=tmp_path / "log")
    try:
        yield process
    finally:
        process.kill()
        process.wait(60)
        process.close()
    assert setup.board.tokens["op"] not in (tmp_path / "log").read_text()


def test_malformed_lines_are_answered_or_skipped_and_the_server_continues(
    wire: ForkedCommand,
) -> None:
    def send(message: Any) -> None:
        assert wire.stdin is not None
        os.write(wire.stdin.fileno(), message if isinstance(message, bytes) else json.dumps(message).encode() + b"\n")

    def answer(number: int) -> dict[str, Any]:
        return next(a for line in iter(wire.stdout.readline, "") if (a := json.loads(line)).get("id") == number)

    client = {"protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "t", "version": "1"}}
    send({"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": client})
    answer(1)
    send({"jsonrpc": "2.0", "method": "notifications/initialized"})
    for nonsense in (
        b"[" * 20_000 + b"\n", b"{}\n", b"null\n", b'"x"\n', b"\x00\x01\xff\n", b'{"jsonrpc":"2.0"}\n', b"\r\n\r\n",
        b'{"jsonrpc":"2.0","id":2,"method":"tools/call"}\n',
        b'{"jsonrpc":"2.0","id":3,"method":"tools/call","params":7}\n',
        b'{"jsonrpc":"2.0","id":4,"method":"tools/call","params":{"name":5,"arguments":[]}}\n',
        b'{"jsonrpc":"2.0","id":5,"method":"no/such","params":{}}\n',
        b'{"jsonrpc":"2.0","method":"notifications/cancelled","params":{"requestId":999}}\n',
        b'{"jsonrpc":"2.0","id":6,"method":"resources/read","params":{"uri":"forum://topic/%ff%fe"}}\n',
        b'{"jsonrpc":"2.0","id":7,"method":"tools/call","params":{"name":"get_topic","arguments":{"topic_id":"\\ud800"}}}\n',
    ):  # fmt: skip
        send(nonsense)
    deep_call = b'{"jsonrpc":"2.0","id":8,"method":"tools/call","params":{"name":"get_topic","arguments":{"topic_id":'
    send(deep_call + b"[" * 300 + b"]" * 300 + b"}}}\n")
    send({"jsonrpc": "2.0", "id": 9, "method": "tools/call", "params": {"name": "list_boards", "arguments": {}}})
    assert answer(9)["result"]["structuredContent"]["ok"]
    assert wire.poll() is None


def test_an_oversized_line_is_skipped(wire: ForkedCommand) -> None:
    assert wire.stdin is not None
    client = {"protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "t", "version": "1"}}
    first = json.dumps({"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": client}).encode() + b"\n"
    wire.stdin.write(first)
    wire.stdin.flush()
    json.loads(wire.stdout.readline())
    for _ in range(40):
        left = memoryview(b"x" * 1024 * 1024)
        while left:
            left = left[os.write(wire.stdin.fileno(), left) :]
    os.write(wire.stdin.fileno(), b'\n{"jsonrpc":"2.0","id":2,"method":"ping"}\n')
    answered = next(a for line in iter(wire.stdout.readline, "") if (a := json.loads(line)).get("id") == 2)
    assert answered["result"] == {}
