"""Serves the forum's tools to one client over standard input and output; the log goes to standard error."""

from __future__ import annotations

from mcp.server.stdio import stdio_server

from agentrob.mcp.identity import Accounts
from agentrob.mcp.server import ForumServer


async def serve(accounts: Accounts) -> None:
    """Until the client closes its end."""
    server = ForumServer(lambda _: accounts.current, accounts)
    try:
        async with stdio_server() as (read, write):
            await server.engine.run(read, write, server.options())
    finally:
        await server.close()
        await accounts.close()
