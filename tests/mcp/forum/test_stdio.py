"""The stdio transport alone: what comes in is a message or passed over, what goes out is one whole line."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import anyio
import mcp_types as types
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcp.shared.message import SessionMessage

from agentrob.mcp.envelope import ToolError, failure, success
from agentrob.mcp.forum.pipes import LinesIn, LinesOut, refusal, written

PING = b'{"jsonrpc":"2.0","id":1,"method":"ping"}\n'


def lines(*parts: bytes, limit: int = 1000, refuse: Any = None) -> LinesIn:
    reader = asyncio.StreamReader(limit=limit)
    for part in parts:
        reader.feed_data(part)
    reader.feed_eof()
    return LinesIn(reader, refuse)


async def methods(read: LinesIn) -> list[str]:
    """The method of each message, `!` for nonsense."""
    found = [item async for item in read]
    return [getattr(m.message, "method", "?") if isinstance(m, SessionMessage) else "!" for m in found]


async def test_nonsense_is_told_empty_lines_and_lines_that_are_too_long_are_passed_over() -> None:
    long = b'{"jsonrpc":"2.0","method":"' + b"x" * 5_000 + b'"}\n'
    assert await methods(lines(PING, b"\n", b" \r\n", b"nonsense\n", long, PING)) == ["ping", "!", "!", "ping"]
    assert await methods(lines(PING[:-1])) == ["ping"], "the last line needs no end"
    assert await methods(lines()) == []


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
async def test_a_line_that_is_no_message_is_answered_and_the_next_one_is_read(
    line: bytes, code: int, id_: int | None
) -> None:
    told: list[bytes] = []

    async def refuse(line: bytes) -> None:
        told.append(refusal(line))

    assert await methods(lines(line + b"\n", PING, refuse=refuse)) == ["ping"]
    (answer,) = map(json.loads, told)
    assert (answer["jsonrpc"], answer["id"], answer["error"]["code"]) == ("2.0", id_, code)


@pytest.mark.parametrize(("first", "begins"), [(PING, True), (b"nonsense\n", False), (b"", False)])
async def test_looking_at_the_first_message_uses_nothing_up(first: bytes, begins: bool) -> None:
    read = lines(first, PING)
    assert await read.begins_with("ping") is (begins or not first)
    assert len(await methods(read)) == len([part for part in (first, PING) if part])
    with pytest.raises(anyio.EndOfStream):
        await read.receive()


async def test_what_is_sent_after_the_end_is_refused() -> None:
    out = LinesOut(None)  # type: ignore[arg-type]
    await out.aclose()
    with pytest.raises(anyio.ClosedResourceError):
        await out.send(SessionMessage(types.JSONRPCResponse(jsonrpc="2.0", id=1, result={})))


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.text(), lambda x: st.lists(x, max_size=3)
)


@given(st.dictionaries(st.text(), JSON, max_size=4), st.text(max_size=20), st.integers(0, 2**31) | st.text())
def test_an_envelope_goes_out_as_the_engine_would_write_it(
    data: dict[str, object], said: str, number: int | str
) -> None:
    for envelope in (success(said, data, "t"), failure(said, ToolError("refused", said, said), "t")):
        text = {"type": "text", "text": envelope.text}
        beside = {"content": [text], "isError": envelope.code != "ok", "_meta": {"x": said}}
        results = [{**beside, "structuredContent": how} for how in (envelope, envelope.structure())]
        ours, theirs = (written(types.JSONRPCResponse(jsonrpc="2.0", id=number, result=result)) for result in results)
        assert json.loads(ours) == json.loads(theirs)
        assert b"\n" not in ours
