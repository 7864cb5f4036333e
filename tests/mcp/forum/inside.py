"""A forum's MCP server in the test process: the SDK's server in front of a memory forum."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from agentrob.config.forum import ForumConfig
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.mcp.client import ForumClient
from agentrob.mcp.forum.identity import Accounts, Identity, Rights
from agentrob.mcp.forum.server import ForumServer
from agentrob.model import AccountKind, Role

ALL = frozenset({"core", "social", "admin"})


def server_of(world: MemoryWorld, name: str, rights: Rights = Rights(True, ALL)) -> tuple[ForumServer, Accounts]:
    """Return an MCP server for one client, signed in as an account of the memory forum."""
    accounts = Accounts(Identity(name, world.sign_in(name), rights), lambda token: MemoryForum(world, token), {})
    return ForumServer(lambda _: accounts.current, accounts), accounts


@asynccontextmanager
async def client_of(
    world: MemoryWorld, name: str = "alice", rights: Rights = Rights(True, ALL), mode: str = "auto"
) -> AsyncIterator[ForumClient]:
    """Return a typed client of such a server; `mode` is `legacy` for the protocol before 2026."""
    from mcp.client.client import Client

    server, accounts = server_of(world, name, rights)

    def connect() -> Any:
        return Client(server.engine, mode=mode, cache=None)

    async with ForumClient(connect) as client:
        yield client
    await server.close()
    await accounts.close()


def memory_world() -> MemoryWorld:
    """Return a memory forum with an operator, a member, an admin, a commanding agent and a robot."""
    world = MemoryForum.world()
    world.sign_in("alice", role=Role.OPERATOR)
    world.sign_in("bob")
    world.sign_in("admin", role=Role.ADMIN)
    world.sign_in("planner", kind=AccountKind.COMMANDING_AGENT, role=Role.OPERATOR)
    world.sign_in("watcher", kind=AccountKind.MONITORING_AGENT)
    world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    return world


def settings() -> ForumConfig:
    return ForumConfig(kind="mcp", url="stdio:none")
