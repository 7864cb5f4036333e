"""Server processes in front of a real board: stdio and HTTP, several concurrent users, misbehaving clients."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import subprocess
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import httpx2
import mcp_types as types
import pytest
import structlog
from mcp_types import PROTOCOL_VERSION_META_KEY

from agentrob.mcp.client import ForumClient, ServerUnavailable, ToolFailed
from agentrob.process.child import Child, terminate_all
from tests.board.running_board import RunningBoard
from tests.mcp.running_mcp import LIMIT_S, McpSetup

INITIALIZE = {
    "jsonrpc": "2.0",
    "id": 1,
    "method": "initialize",
    "params": {"protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}},
}
ACCEPT = {"Accept": "application/json, text/event-stream", "Content-Type": "application/json"}


@pytest.fixture(scope="module")
def served(board: RunningBoard, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Serve over HTTP with the real command: `op` may write, `member` may only read."""
    setup = McpSetup(board, tmp_path_factory.mktemp("http"), {"listen": "127.0.0.1:0"})
    setup.user("op", write=True)
    setup.user("member")
    setup.user("admin", write=True, toolsets=["core", "social", "admin"])
    child = Child("mcp", setup.words("--http"), setup.folder / "mcp.log", setup.env)
    try:
        yield child.wait_ready()["url"]
    finally:
        terminate_all([child])


def as_user(url: str, name: str) -> ForumClient:
    return ForumClient.connect(url, f"mcp-token-for-user-{name}")


# ---------------------------------------------------------------------- stdio
async def test_a_client_uses_a_stdio_server_from_start_to_end(setup: McpSetup) -> None:
    async with setup.client("op") as client:
        assert [b.id for b in (await client.list_boards()).boards] == ["robots", "talk"]
        post = (await client.create_topic("talk", "A title", "hello", status="greeting", key="life")).post
        assert post.author.name == "op"
        assert (await client.get_topic(post.topic_id)).posts[0].body == "hello"


def test_standard_streams_may_be_regular_files(setup: McpSetup, tmp_path: Path) -> None:
    asked, answered = tmp_path / "asked.jsonl", tmp_path / "answered.jsonl"
    asked.write_text("".join(json.dumps(INITIALIZE | {"id": number}) + "\n" for number in (1, 2)))
    with asked.open() as source, answered.open("w") as target:
        done = subprocess.run(
            setup.command(), stdin=source, stdout=target, env=setup.environment("op"), timeout=LIMIT_S, check=False
        )
    assert done.returncode == 0
    first, *_ = map(json.loads, answered.read_text().splitlines())
    assert (first["id"], first["result"]["serverInfo"]["name"]) == (1, "agentrob-forum")


async def test_the_logs_of_server_and_board_have_the_trace_id_of_the_answer(setup: McpSetup, tmp_path: Path) -> None:
    command, *args = setup.command()
    note = tmp_path / "log"
    with structlog.testing.capture_logs() as of_board:
        async with ForumClient.spawn(
            "sh", "-c", f'exec "$0" "$@" 2> {note}', command, *args, env=setup.environment("op")
        ) as client:
            with pytest.raises(ToolFailed) as said:
                await client.get_topic("999999")
    assert any(x.get("trace_id") == said.value.trace_id for x in of_board if x["event"] == "board.traced")
    assert any("mcp.call" in x and said.value.trace_id in x for x in note.read_text().splitlines())


@pytest.mark.slow
async def test_a_killed_server_is_restarted_by_the_next_call(setup: McpSetup, tmp_path: Path) -> None:
    command, *args = setup.command()
    note = tmp_path / "pid"
    async with ForumClient.spawn(
        "sh", "-c", f'echo $$ > {note}; exec "$0" "$@"', command, *args, env=setup.environment("op")
    ) as client:
        await client.list_boards()
        os.kill(int(note.read_text()), signal.SIGKILL)
        async with asyncio.timeout(LIMIT_S):
            while True:
                with contextlib.suppress(ServerUnavailable):
                    assert (await client.list_boards()).boards
                    break


async def test_a_slow_call_times_out_and_the_connection_continues(setup: McpSetup) -> None:
    async with setup.client("op") as client:
        topic_id = (await client.create_topic("talk", "Quiet", "hello")).post.topic_id
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.3):
                await client.subscribe_topic(topic_id, wait_s=30)
        assert (await client.list_boards()).boards


def test_a_half_closed_pipe_ends_the_server_and_malformed_input_does_not(setup: McpSetup, tmp_path: Path) -> None:
    process = setup.stdio("op", log=tmp_path / "log")
    assert process.stdin is not None
    try:
        for line in (b"nonsense\n", b"[]\n", b"\xff\xfe\n", b"{" * 5_000 + b"\n", b'{"jsonrpc":"2.0","id":7}\n', b"\n"):
            process.stdin.write(line)
        process.stdin.write(json.dumps(INITIALIZE).encode() + b"\n")
        process.stdin.flush()
        answers = (json.loads(line) for line in process.stdout)
        refused = [next(answers)["error"]["code"] for _ in range(4)]
        assert refused == [types.PARSE_ERROR, types.INVALID_REQUEST, types.PARSE_ERROR, types.PARSE_ERROR]
        assert next(a for a in answers if a.get("id") == 1)["result"]["serverInfo"]["name"] == "agentrob-forum"
        for number, meta in ((2, {PROTOCOL_VERSION_META_KEY: "2026-07-28"}), (3, 5)):
            asked = {"method": "tools/list", "params": {"_meta": meta}}
            process.stdin.write(json.dumps({"jsonrpc": "2.0", "id": number, **asked}).encode() + b"\n")
            process.stdin.flush()
            assert next(a for a in answers if a.get("id") == number)["error"]["code"] < 0
        process.stdin.close()
        assert process.wait(60) == 0
    finally:
        process.kill()
        process.stdout.close()


def test_the_server_ends_when_a_client_that_stopped_reading_closes_its_end(setup: McpSetup, tmp_path: Path) -> None:
    process = setup.stdio("op", log=tmp_path / "log")
    assert process.stdin is not None
    initialized = {"jsonrpc": "2.0", "method": "notifications/initialized"}
    try:
        process.stdin.write(json.dumps(INITIALIZE).encode() + b"\n" + json.dumps(initialized).encode() + b"\n")
        for n in range(2, 100):  # far more responses than a pipe can hold
            process.stdin.write(json.dumps({"jsonrpc": "2.0", "id": n, "method": "tools/list"}).encode() + b"\n")
        process.stdin.close()
        process.stdout.close()
        process.wait(60)
    finally:
        process.kill()


# ---------------------------------------------------------------------- HTTP
async def test_concurrent_users_write_under_their_own_names_without_loss(served: str) -> None:
    async with as_user(served, "op") as op, as_user(served, "admin") as admin:
        topic_id = (await op.create_topic("talk", "Both", "hello")).post.topic_id
        writes = [c.reply_to_topic(topic_id, f"{who} {n}", key=f"both-{n}")
                  for n in range(20) for who, c in (("op", op), ("admin", admin))]  # fmt: skip
        await asyncio.gather(*writes)
        posts = (await op.get_topic(topic_id, limit=100)).posts[1:]
    assert sorted(p.body for p in posts) == sorted(f"{who} {n}" for n in range(20) for who in ("op", "admin"))
    assert all(p.body.startswith(p.author.name) for p in posts)


async def test_a_read_only_user_sees_and_may_call_no_writing_tools(served: str) -> None:
    async with as_user(served, "member") as member:
        assert (await member.list_boards()).boards
        with pytest.raises(ToolFailed) as refused:
            await member.create_topic("talk", "Mine", "hello")
        assert refused.value.code == "not_allowed"
        with pytest.raises(ToolFailed) as refused:
            await member.login_account("admin")
        assert refused.value.code == "not_allowed"


@pytest.mark.parametrize("token", [None, "x", "wrong-token-of-nobody", "mcp-token-for-user-opx"])
def test_law_1_nobody_is_anonymous_over_http(served: str, token: str | None) -> None:
    headers = ACCEPT | ({"Authorization": f"Bearer {token}"} if token is not None else {})
    answer = httpx2.post(served, json=INITIALIZE, headers=headers, timeout=60)
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"].startswith("Bearer")


@pytest.mark.parametrize(
    ("headers", "status"),
    [({"Origin": "https://evil.example"}, 403), ({"Host": "evil.example"}, 421), ({"Origin": "null"}, 403)],
)
def test_cross_origin_and_dns_rebinding_requests_are_refused(served: str, headers: dict[str, str], status: int) -> None:
    signed_in = ACCEPT | {"Authorization": "Bearer mcp-token-for-user-op"}
    assert httpx2.post(served, json=INITIALIZE, headers=signed_in | headers, timeout=60).status_code == status
    assert httpx2.post(served, json=INITIALIZE, headers=signed_in, timeout=60).status_code == 200


async def test_law_1_a_session_cannot_be_taken_over_with_another_token(served: str) -> None:
    async with httpx2.AsyncClient(headers=ACCEPT, timeout=60) as http:
        op = {"Authorization": "Bearer mcp-token-for-user-op"}
        first = await http.post(served, json=INITIALIZE, headers=op)
        session = {"Mcp-Session-Id": first.headers["mcp-session-id"], "MCP-Protocol-Version": "2025-11-25"}
        call = {"jsonrpc": "2.0", "id": 2, "method": "tools/list"}
        stolen = await http.post(
            served, json=call, headers=session | {"Authorization": "Bearer mcp-token-for-user-member"}
        )
        assert stolen.status_code in (401, 403, 404)


async def test_a_push_reaches_a_client_over_http_in_the_protocol_of_2026(served: str) -> None:
    async with as_user(served, "op") as op, as_user(served, "admin") as admin:
        topic_id = (await op.create_topic("talk", "News", "hello")).post.topic_id
        uri = f"forum://topic/{topic_id}"
        async with asyncio.timeout(60):
            updates = op.updates(uri)
            told = asyncio.ensure_future(_next(updates))
            n = 0
            while not told.done():
                n += 1
                await admin.reply_to_topic(topic_id, f"news {n}")
                await asyncio.wait({told}, timeout=0.2)
            assert told.result() == uri
            await updates.aclose()  # type: ignore[attr-defined]


async def _next(updates: AsyncIterator[Any]) -> Any:
    return await anext(updates)


# ---------------------------------------------------------------------- configuration
def test_a_token_refused_by_the_forum_is_reported_on_standard_error_with_the_forums_url(setup: McpSetup) -> None:
    process = setup.stdio("op", AGENTROB_TOKEN="not-a-token")
    assert process.stderr is not None
    try:
        said = next(line for line in process.stderr if "refuses the token" in line)
    finally:
        process.kill()
        process.wait(60)
        process.close()
    assert "that token is not valid" in said
    assert "http://127.0.0.1:" in said


@pytest.mark.slow
def test_a_server_without_users_or_tokens_says_so(setup: McpSetup) -> None:
    def said(**mcp: Any) -> str:
        setup.mcp = mcp
        ended = subprocess.run(
            setup.command("--http"), env=setup.environment("op"), capture_output=True, text=True, check=False
        )
        assert ended.returncode == 1
        return ended.stderr

    assert "nobody may connect" in said()
    user = {"forum_token_env": "NOT_THERE", "token_env": "NOT_THERE_EITHER"}
    assert "NOT_THERE must hold alice's forum token" in said(users={"alice": user})
    assert "tollsets is not a setting" in said(tollsets=["core"])
