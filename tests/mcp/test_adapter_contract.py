"""The forum adapter over MCP fulfils the forum contract, in front of a memory forum and of a real board."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
from mcp.client.client import Client

from agentrob.board.admin import local_admin
from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumUnreachable
from agentrob.forums.contract import ForumContract, KeyedEditsContract, World
from agentrob.forums.memory.forum import MemoryForum
from agentrob.forums.protocol import Forum
from agentrob.mcp.adapter import McpForum
from agentrob.mcp.client import ForumClient
from agentrob.mcp.forum.identity import Rights
from agentrob.model import AccountKind, Role
from tests.board.running_board import running_board
from tests.forums.test_agentrob_contract import BoardWorld
from tests.mcp.forum.inside import ALL, server_of
from tests.mcp.running_mcp import McpSetup


class MemoryMcpWorld:
    """A memory forum with an MCP server in this process for each account."""

    def __init__(self, **settings: Any) -> None:
        self.world = MemoryForum.world(**settings)
        self.open = AsyncExitStack()

    async def sign_in(self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER) -> Forum:
        self.world.sign_in(name, kind=kind, role=role)
        server, accounts = server_of(self.world, name, Rights(True, ALL))
        forum = McpForum.from_client(ForumClient(lambda: Client(server.engine, cache=None)))
        self.open.push_async_callback(accounts.close)
        self.open.push_async_callback(server.close)
        self.open.push_async_callback(forum.close)
        await forum.connect()
        return forum

    async def suspend(self, name: str) -> None:
        self.world.suspend(name)

    async def remove(self, post_id: str) -> None:
        self.world.remove(post_id)

    async def unreachable(self) -> Forum:
        return McpForum(ForumConfig(kind="mcp", url="http://127.0.0.1:9/mcp"), "token")


class TestMcpForum(ForumContract, KeyedEditsContract):
    @pytest.fixture(params=[{}, {"max_edits": 0}, {"live": False}], ids=str)
    async def world(self, request: pytest.FixtureRequest) -> AsyncIterator[World]:
        made = MemoryMcpWorld(**request.param)
        async with made.open:
            yield made


class BoardMcpWorld(BoardWorld):
    """A real board with an MCP server process for each account."""

    def __init__(self, setup: McpSetup, http: bool) -> None:
        super().__init__(setup.board)
        self.setup, self.http, self.open, self.url = setup, http, AsyncExitStack(), ""

    def _serve(self) -> str:
        """Start one HTTP server for all accounts of the contract."""
        served = McpSetup(self.board, self.setup.folder, {"listen": "127.0.0.1:0"})
        for name in ("alice", "bob", "quadruped", "admin"):
            if name not in self.board.tokens:
                self.board.add(name)
            served.user(name, write=True, toolsets=["core", "social", "admin"])
        return self.open.enter_context(served.http())

    async def sign_in(self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER) -> Any:
        await super().sign_in(name, kind=kind, role=role)
        if self.http:
            if not self.url:
                self.url = await asyncio.to_thread(self._serve)
            account = local_admin.find_account(self.board.settings, name)
            await asyncio.to_thread(local_admin.change_account, self.board.settings, account, role=role)
            forum = McpForum(ForumConfig(kind="mcp", url=self.url), f"mcp-token-for-user-{name}")
        else:
            command = " ".join(self.setup.command())
            forum = McpForum(ForumConfig(kind="mcp", url=f"stdio:{command}"), self.board.tokens[name])
        self.open.push_async_callback(forum.close)
        await forum.connect()
        return forum

    async def unreachable(self) -> Any:
        forum = McpForum(ForumConfig(kind="mcp", url="stdio:/nowhere/agentrob"), "token")
        self.open.push_async_callback(forum.close)
        return forum


@pytest.mark.slow
class TestMcpForumOfProcesses(ForumContract, KeyedEditsContract):
    @pytest.fixture(params=["stdio", "http"])
    async def world(self, request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[World]:
        with running_board(tmp_path / "board") as board:
            setup = McpSetup(board, tmp_path, {"write": True, "toolsets": ["core", "social", "admin"]})
            made = BoardMcpWorld(setup, request.param == "http")
            async with made.open:
                yield made
            await made.close()


async def test_law_16_a_stream_ends_with_unreachable_when_the_forum_or_server_falls_silent() -> None:
    made = MemoryMcpWorld()
    async with made.open:
        forum = await made.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
        stream = forum.stream((await forum.now())[0], 0.25)
        await anext(stream)
        made.world.reachable = False
        with pytest.raises(ForumUnreachable):
            await asyncio.wait_for(_drain(stream), 60)


async def _drain(stream: Any) -> None:
    async for _ in stream:
        pass
