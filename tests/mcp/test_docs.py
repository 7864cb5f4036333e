"""The snippets in the docs work: each command starts a server, each URL is served, each table is valid
configuration."""

from __future__ import annotations

import asyncio
import json
import os
import re
import shlex
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest
import tomli_w
from mcp import Client, StdioServerParameters

from agentrob.config.load import Config
from agentrob.mcp.client import ForumClient
from tests.mcp.running_mcp import LIMIT_S, McpSetup

ROOT = Path(__file__).parents[2]
DOCS, SERVICE, README = (
    (ROOT / p).read_text("utf-8") for p in ("docs/agents/mcp.md", "docs/agents/service.md", "README.md")
)
#: The values that a reader inserts for the placeholders.
CONFIG = "/path/to/agentrob.toml"


@dataclass(frozen=True)
class Entry:
    """A client's entry for a server: the command line and the environment variables."""

    command: tuple[str, ...]
    variables: tuple[str, ...]

    @property
    def kind(self) -> str:
        return self.command[2]


def blocks(kind: str, text: str = DOCS) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def entries() -> list[Entry]:
    """Return the entries on all pages."""
    servers = [server for text in (DOCS, SERVICE, README) for block in blocks("json", text)
               for server in json.loads(block).get("mcpServers", {}).values()]  # fmt: skip
    servers += [s for block in blocks("toml") for s in tomllib.loads(block).get("mcp_servers", {}).values()]
    found = [Entry((s["command"], *s["args"]), tuple(s["env"])) for s in servers]
    for line in re.findall(r"^claude mcp add (.* -- .*)$", DOCS, re.MULTILINE):
        given, _, command = line.partition(" -- ")
        found.append(Entry(tuple(shlex.split(command)), tuple(re.findall(r"--env (\w+)=", given))))
    return found


def test_the_docs_have_entries() -> None:
    assert [entry.kind for entry in entries()] == ["forum", "robot", "forum", "forum", "forum"]


@pytest.mark.parametrize("entry", sorted(set(entries()), key=str), ids=lambda entry: " ".join(entry.command[1:4]))
async def test_an_entry_starts_a_server_that_lists_its_tools(setup: McpSetup, entry: Entry) -> None:
    """Only the named environment variables are set, and the configuration is the one in the docs."""
    robots = next(t for t in map(tomllib.loads, blocks("toml", SERVICE)) if "mcp_robot" in t)
    (setup.folder / "agentrob.toml").write_text(tomli_w.dumps({"forum": {"url": setup.board.url}, **robots}))
    program, *arguments = (word.replace(CONFIG, str(setup.folder / "agentrob.toml")) for word in entry.command)
    assert Path(program).name == "agentrob"
    secrets = {"AGENTROB_TOKEN": setup.board.tokens["op"], "QUADRUPED_TOKEN": "a-token-of-nobody-yet"}
    env = {k: v for k, v in os.environ.items() if k in ("PATH", "HOME", "PYTHONPATH")}
    started = StdioServerParameters(
        command=sys.executable,
        args=["-m", "agentrob", *arguments],
        env=env | {name: secrets[name] for name in entry.variables},
        cwd=setup.folder,
    )
    async with asyncio.timeout(LIMIT_S), Client(started, cache=None) as client:
        names = {tool.name for tool in (await client.list_tools()).tools}
    assert ({"stop", "list_robots"} if entry.kind == "robot" else {"list_boards", "create_topic"}) <= names


def test_every_table_is_valid_and_the_urls_are_served() -> None:
    tables = [tomllib.loads(block) for block in blocks("toml")]
    configs = [Config.model_validate(table) for table in tables if "mcp_servers" not in table]
    served = next(c for c in configs if c.mcp.users)
    address = f"http://{served.mcp.listen}/mcp"
    assert set(re.findall(r"http://127.0.0.1:8090/[a-z]*", DOCS)) == {address}
    assert next(c for c in configs if c.forum.kind == "mcp").forum.url == address
    (vscode,) = (b["servers"]["agentrob"] for b in map(json.loads, blocks("json")) if "servers" in b)
    assert vscode["url"] == address


def test_the_python_example_uses_the_real_client() -> None:
    (code,) = blocks("python")
    called = set(re.findall(r"forum\.(\w+)\(", code))
    assert called
    assert all(callable(getattr(ForumClient, name)) for name in called)
