"""Robots as tools for an MCP client, in front of a served agent with a fake robot."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import httpx2
import pytest
from mcp.client.client import Client
from mcp.client.stdio import StdioServerParameters
from mcp.client.streamable_http import streamable_http_client

from agentrob.config.load import Config
from agentrob.config.service import McpRobotConfig
from agentrob.errors import ConfigError
from agentrob.mcp.robots.server import RobotServer, configured
from agentrob.mcp.robots.service_client import Robots
from agentrob.mcp.robots.service_client import Service as Remote
from agentrob.mcp.robots.tools import allowed
from agentrob.process.child import Child, terminate_all
from tests.agent.agent_scene import ROBOT
from tests.service.service_scene import Service, token
from tests.waiting import until

ALWAYS = ["list_robots", "robot_status", "camera_snapshot", "list_queue", "get_command", "stop"]
EVERYTHING = McpRobotConfig(preview=True, submit=True)


@asynccontextmanager
async def client_of(
    service: Service, who: str = "alice", config: McpRobotConfig = EVERYTHING, mode: str = "auto"
) -> AsyncIterator[Client]:
    """Return a client of the robots' MCP server, which calls the service with the token of `who`."""
    robots = Robots({ROBOT: Remote(ROBOT, service.url, token(who))}, config.pictures_per_minute)
    try:
        async with Client(RobotServer(robots, allowed(config)).engine, mode=mode, cache=None) as client:
            yield client
    finally:
        await robots.close()


async def ask(client: Client, name: str, /, **arguments: Any) -> dict[str, Any]:
    """Call a tool; return its envelope, after checking that the text content says the same."""
    result = await client.call_tool(name, arguments)
    said = result.structured_content
    assert isinstance(said, dict)
    assert json.loads(result.content[0].text) == said  # type: ignore[union-attr]
    assert (said["ok"], said["tool"]) == (not result.is_error, name)
    return said


async def test_reading_and_stopping_are_always_allowed_and_the_owner_allows_the_rest(service: Service) -> None:
    for config, more in (
        (McpRobotConfig(), []),
        (McpRobotConfig(preview=True), ["preview_command"]),
        (EVERYTHING, ["preview_command", "submit_command", "cancel_command"]),
    ):
        for mode in ("auto", "legacy"):
            async with client_of(service, config=config, mode=mode) as client:
                listed = (await client.list_tools()).tools
                assert [tool.name for tool in listed] == [*ALWAYS, *more]
                assert all(tool.description and tool.annotations for tool in listed)
                size = len(json.dumps([t.model_dump(by_alias=True, exclude_none=True, mode="json") for t in listed]))
                assert size < 6_000
    async with client_of(service, config=McpRobotConfig()) as client:
        before = len(service.scene.world.posts)
        assert (await ask(client, "submit_command", text="walk 1 m"))["error"]["code"] == "not_allowed"
        assert len(service.scene.world.posts) == before


async def test_a_client_looks_commands_waits_and_reads_the_measurements(service: Service) -> None:
    async with client_of(service) as client:
        (robot,) = (await ask(client, "list_robots"))["data"]["robots"]
        assert (robot["name"], robot["state"]) == (ROBOT, "idle")
        preview = (await ask(client, "preview_command", text="walk forward 0.3 m"))["data"]["preview"]
        assert preview["verdict"]["decision"] == "allow"
        assert not service.scene.world.posts
        told: list[str | None] = []

        async def progress(_: float, __: float | None, message: str | None) -> None:
            told.append(message)

        arguments = {"text": "walk forward 0.3 m", "key": "k", "wait_s": 20}
        result = await client.call_tool("submit_command", arguments, progress_callback=progress)
        assert result.structured_content is not None
        command = result.structured_content["data"]["command"]
        assert (command["state"], command["author"]) == ("done", "alice")
        assert command["results"][0]["measured"]["distance_m"] == pytest.approx(0.3, abs=0.15)
        assert service.scene.world.posts[command["id"]].author.name == "alice"
        assert told
        assert told[-1] == "done"
        again = (await ask(client, "submit_command", **arguments))["data"]
        assert (again["created"], again["command"]["id"]) == (False, command["id"])


async def test_a_snapshot_is_an_image_and_snapshots_are_limited(service: Service) -> None:
    async with client_of(service, config=McpRobotConfig(pictures_per_minute=1)) as client:
        result = await client.call_tool("camera_snapshot", {})
        picture = result.content[1]
        assert picture.type == "image"
        assert base64.b64decode(picture.data)[:2] == b"\xff\xd8"
        refused = (await ask(client, "camera_snapshot"))["error"]
        assert (refused["code"], refused["retryable"]) == ("rate_limited", True)


async def test_law_13_and_15_a_stop_passes_waiting_calls_and_all_limits(service: Service) -> None:
    async with client_of(service) as client:
        waiting = asyncio.create_task(ask(client, "submit_command", text="walk forward 5 m", wait_s=30))
        await until(lambda: service.agent.queue.moving)
        service.parts.auth._limit = type(service.parts.auth._limit)(1)  # from now on everything else is refused
        stopped = (await ask(client, "stop"))["data"]["stop"]
        assert stopped["confirmed"]
        assert stopped["latency_ms"] < 500
        await waiting
    job = next(iter(service.scene.world.posts.values()))
    card = (await service.scene.final(job)).card
    assert card is not None
    assert card.state == "stopped"


async def test_refusals_use_the_envelope_and_name_valid_values(service: Service) -> None:
    async with client_of(service, who="watcher") as client:
        for name, arguments, code in (
            ("submit_command", {"text": "walk 1 m"}, "denied"),
            ("stop", {}, "denied"),
            ("get_command", {"command_id": "999"}, "not_found"),
            ("robot_status", {"robot": "nobody"}, "not_found"),
            ("robot_status", {"speed": 3}, "invalid_arguments"),
            ("get_command", {"command_id": "../../metrics"}, "invalid_arguments"),
            ("submit_command", {"text": " \x00"}, "invalid_arguments"),
            ("move", {"vx": 1.0}, "unknown_tool"),
        ):
            said = await ask(client, name, **arguments)
            assert said["error"]["code"] == code, said
            assert said["trace_id"]


async def test_an_unreachable_service_is_reported_and_an_undelivered_stop_is_an_error() -> None:
    robots = Robots({ROBOT: Remote(ROBOT, "http://127.0.0.1:9", token("alice"))}, 10)
    async with Client(RobotServer(robots, allowed(EVERYTHING)).engine, cache=None) as client:
        (robot,) = (await ask(client, "list_robots"))["data"]["robots"]
        assert robot["state"] == "unreachable"
        said = (await ask(client, "stop"))["error"]
        assert (said["code"], said["retryable"]) == ("unreachable", True)
        assert "own stop" in said["hint"]
    await robots.close()


def test_the_server_is_off_until_a_service_and_its_token_are_configured(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigError, match="no robot is configured"):
        configured(McpRobotConfig())
    monkeypatch.delenv("NO_SUCH_TOKEN", raising=False)
    services = {"quadruped": {"url": "http://127.0.0.1:8089", "token_env": "NO_SUCH_TOKEN"}}
    with pytest.raises(ConfigError, match="NO_SUCH_TOKEN"):
        configured(McpRobotConfig.model_validate({"services": services}))


async def test_over_http_it_accepts_its_own_token_and_not_the_services(service: Service, tmp_path: Path) -> None:
    services = {ROBOT: {"url": service.url, "token_env": "ROBOT_TOKEN"}}
    facts = {"mcp_robot": {"listen": "127.0.0.1:0", "token_env": "MCP_TOKEN", "services": services}}
    Config.model_validate(facts).write(tmp_path / "robots.toml")
    env = {"ROBOT_TOKEN": token("alice"), "MCP_TOKEN": "a-token-of-the-client"}
    child = Child("mcp", ["mcp", "robot", "--http", "-c", str(tmp_path / "robots.toml")], tmp_path / "mcp.log", env)
    try:
        url = (await asyncio.to_thread(child.wait_ready))["url"]
        asked = {"jsonrpc": "2.0", "id": 1, "method": "tools/list", "params": {}}
        for headers in ({}, {"Authorization": f"Bearer {token('alice')}"}):
            assert (await service.http.post(url, json=asked, headers=headers)).status_code == 401
        mine = {"Authorization": f"Bearer {env['MCP_TOKEN']}"}
        evil = await service.http.post(url, json=asked, headers={**mine, "Origin": "http://evil.example.org"})
        assert evil.status_code == 403
        async with (
            httpx2.AsyncClient(headers=mine, trust_env=False, timeout=60) as http,
            Client(streamable_http_client(url, http_client=http), cache=None) as client,
        ):
            assert [tool.name for tool in (await client.list_tools()).tools] == ALWAYS
            assert (await ask(client, "robot_status"))["data"]["robot"]["name"] == ROBOT
            assert (await ask(client, "stop"))["data"]["stop"]["confirmed"]
    finally:
        await asyncio.to_thread(terminate_all, [child])


async def test_over_stdio_as_a_client_starts_it(service: Service, tmp_path: Path) -> None:
    services = {ROBOT: {"url": service.url, "token_env": "ROBOT_TOKEN"}}
    config = Config.model_validate({"mcp_robot": {"submit": True, "services": services}})
    config.write(tmp_path / "robots.toml")
    arguments = ["-m", "agentrob", "mcp", "robot", "-c", str(tmp_path / "robots.toml")]
    env = {**os.environ, "ROBOT_TOKEN": token("alice")}
    async with Client(StdioServerParameters(command=sys.executable, args=arguments, env=env), cache=None) as client:
        assert len((await client.list_tools()).tools) == len(ALWAYS) + 2
        said = await ask(client, "submit_command", text="turn left 20 degrees", wait_s=20)
        assert said["data"]["command"]["state"] == "done"
        assert (await ask(client, "stop"))["data"]["stop"]["confirmed"]
