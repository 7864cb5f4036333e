"""Hostile input to the robots' tools and hostile responses of a robot's service: every result uses the envelope."""

from __future__ import annotations

import asyncio
import json
from functools import cache
from typing import Any

import httpx2
import mcp_types as types
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agentrob.config.service import McpRobotConfig
from agentrob.mcp.forum.arguments import input_schema
from agentrob.mcp.robots.server import RobotServer
from agentrob.mcp.robots.service_client import Robots, Service
from agentrob.mcp.robots.tools import BY_NAME, TOOLS, allowed
from tests.mcp.forum.hostile import ANYTHING, deep, of_schema

SECRET = "the-secret-token-of-the-service"
QUICK = settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])


class _Session:
    async def report_progress(self, *_: Any) -> None:
        """Ignore progress."""


class _Context:
    """The attributes of a request context that a tool call uses."""

    session = _Session()


def call(name: str, arguments: Any, status: int = 200, body: bytes = b"{}") -> tuple[dict[str, Any], list[str]]:
    """Call a tool; return the envelope in its wire form and the URLs of the service that were requested."""
    asked: list[str] = []

    def answer(request: httpx2.Request) -> httpx2.Response:
        asked.append(request.url.path)
        return httpx2.Response(status, content=body)

    async def calling() -> types.CallToolResult:
        http = httpx2.AsyncClient(transport=httpx2.MockTransport(answer))
        robots = Robots({"quadruped": Service("quadruped", "http://service.test", SECRET, http)}, 150)
        server = RobotServer(robots, allowed(McpRobotConfig(preview=True, submit=True)))
        params = types.CallToolRequestParams.model_construct(name=name, arguments=arguments)
        try:
            return await asyncio.wait_for(server.call_tool(_Context(), params), 60)  # type: ignore[arg-type]
        finally:
            await robots.close()

    result = asyncio.run(calling())
    sent = json.loads(result.model_dump_json(by_alias=True))
    said = sent["structuredContent"]
    assert json.loads(sent["content"][0]["text"]) == said
    assert set(said) - {"data", "error"} == {"ok", "tool", "trace_id"}
    assert SECRET not in json.dumps(sent)
    return said, asked


@cache
def _strategy(name: str) -> st.SearchStrategy[Any]:
    return of_schema(input_schema(BY_NAME[name].arguments))


@pytest.mark.parametrize("name", list(BY_NAME))
@QUICK
@given(data=st.data())
def test_a_tool_answers_any_arguments_in_the_envelope_and_calls_only_its_robot(name: str, data: st.DataObject) -> None:
    said, asked = call(name, data.draw(_strategy(name)), 404, b'{"detail": "no", "code": "no_such_thing"}')
    assert said["ok"] is (name == "list_robots" and bool(asked))  # it also lists robots that it cannot reach
    assert all(path.startswith("/api/v1/robots/quadruped") and ".." not in path for path in asked), asked


@pytest.mark.parametrize("name", list(BY_NAME))
def test_deep_and_huge_json_is_refused_in_the_envelope(name: str) -> None:
    for value in (deep(900), {"a": {"b": deep(300)}}, ["x" * 1_000] * 1_000, 10**400):
        fields = input_schema(BY_NAME[name].arguments)["properties"]
        said, asked = call(name, dict.fromkeys(fields, value) or {"x": value})
        assert said["error"]["code"] == "invalid_arguments"
        assert len(json.dumps(said)) < 3_000, "the error must not repeat what was given"
        assert not asked


@pytest.mark.parametrize("tool", TOOLS, ids=lambda tool: tool.name)
@QUICK
@given(status=st.sampled_from([200, 201, 204, 302, 400, 418, 429, 500, 503]), body=ANYTHING, raw=st.binary(max_size=40))
def test_any_response_of_the_service_results_in_the_envelope(tool: Any, status: int, body: Any, raw: bytes) -> None:
    given = {"text": "walk 1 m", "command_id": "1"}
    arguments = {name: given[name] for name in tool.arguments.model_fields if name in given}
    for content in (raw, json.dumps(body).encode("utf-8", "replace")):
        said, _ = call(tool.name, arguments, status, content)
        assert said["ok"] or said["error"]["code"] != "internal", said
