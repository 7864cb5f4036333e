"""What docs/mcp.md gives to paste is true: each command starts, each address answers, each table is a configuration."""

from __future__ import annotations

import json
import re
import shlex
import sys
import tomllib
from pathlib import Path

import pytest
from running_mcp import McpSetup

from agentrob.config import Config
from agentrob.mcp.client import ForumClient

DOCS = (Path(__file__).parents[2] / "docs/mcp.md").read_text(encoding="utf-8")


def blocks(kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", DOCS, re.MULTILINE | re.DOTALL)


def commands() -> list[list[str]]:
    """Every command line by which a client is told to start the forum's server."""
    found = [block["mcpServers"].values() for block in map(json.loads, blocks("json")) if "mcpServers" in block]
    codex = [t["mcp_servers"].values() for t in map(tomllib.loads, blocks("toml")) if "mcp_servers" in t]
    spoken = [
        shlex.split(line.partition(" -- ")[2]) for line in re.findall(r"^    claude mcp add .* -- .*$", DOCS, re.M)
    ]
    written = [[s["command"], *s["args"]] for servers in found + codex for s in servers]
    return [c for c in written + spoken if c[1:3] == ["mcp", "forum"]]


def test_there_is_something_to_paste() -> None:
    assert len(commands()) == 3


@pytest.mark.parametrize("command", commands()[:1])
async def test_a_command_of_the_page_starts_a_server(setup: McpSetup, command: list[str]) -> None:
    """They are all the same one."""
    assert all(other == command for other in commands())
    given = [str(setup.file()) if word == "/path/to/agentrob.toml" else word for word in command[1:]]
    client = ForumClient.spawn(sys.executable, "-m", "agentrob", *given, env=setup.environment("op"))
    async with client as forum:
        assert [board.id for board in (await forum.list_boards()).boards] == ["robots", "talk"]


def test_every_table_is_a_configuration_and_the_addresses_are_those_that_are_served() -> None:
    tables = [tomllib.loads(block) for block in blocks("toml")]
    configs = [Config.model_validate(table) for table in tables if "mcp_servers" not in table]
    served = next(c for c in configs if c.mcp.users)
    address = f"http://{served.mcp.listen}/mcp"
    assert set(re.findall(r"http://127.0.0.1:8090/[a-z]*", DOCS)) == {address}
    assert next(c for c in configs if c.forum.kind == "mcp").forum.url == address
    (vscode,) = (b["servers"]["agentrob"] for b in map(json.loads, blocks("json")) if "servers" in b)
    assert vscode["url"] == address


def test_the_python_of_the_page_is_the_clients() -> None:
    (code,) = blocks("python")
    called = set(re.findall(r"forum\.(\w+)\(", code))
    assert called
    assert all(callable(getattr(ForumClient, name)) for name in called)
