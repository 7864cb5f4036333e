"""Serves the forum's tools to one client over standard input and output; the log goes to standard error."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from agentrob.mcp.identity import Accounts
from agentrob.mcp.pipes import stdio_pipes
from agentrob.mcp.server import ForumServer


def run(make: Callable[[], Accounts]) -> None:
    """`serve` on the quickest event loop there is; `make` is called on it."""
    from uvloop import new_event_loop

    async def main() -> None:
        await serve(make())

    with asyncio.Runner(loop_factory=new_event_loop) as runner:
        runner.run(main())


async def serve(accounts: Accounts) -> None:
    """Until the client closes its end."""
    server = ForumServer(lambda _: accounts.current, accounts)
    try:
        async with stdio_pipes() as (read, write):
            await server.engine.run(read, write, server.options())
    finally:
        await server.close()
        await accounts.close()
