"""Serves the forum's tools to one client over standard input and output; the log goes to standard error."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from mcp.server.runner import serve_loop

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
    server = ForumServer(lambda _: accounts.current, accounts, own_pipes=True)
    try:
        async with stdio_pipes() as (read, write):
            if await read.begins_with("initialize"):
                # The engine's `run` finds out the era of the protocol too, but then hands every message on once more.
                async with server.engine.lifespan(server.engine) as state:
                    await serve_loop(server.engine, read, write, lifespan_state=state, init_options=server.options())
            else:
                await server.engine.run(read, write, server.options())
    finally:
        await server.close()
        await accounts.close()
