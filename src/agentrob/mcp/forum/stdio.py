"""Serves the forum's tools to one client over standard input and output; the log goes to standard error."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable

import structlog
from mcp.server.runner import serve_loop

from agentrob.errors import ForumDenied, ForumError
from agentrob.mcp.forum.identity import Accounts, Identity
from agentrob.mcp.forum.pipes import stdio_pipes
from agentrob.mcp.forum.server import ForumServer

_log = structlog.get_logger()


def run(make: Callable[[], Accounts]) -> None:
    """`serve` on the quickest event loop there is; `make` is called on it."""
    from uvloop import new_event_loop

    async def main() -> None:
        await serve(make())

    with asyncio.Runner(loop_factory=new_event_loop) as runner:
        runner.run(main())


async def _check(identity: Identity) -> None:
    """Say on standard error that the token is refused; a forum that is not there yet is asked by the first tool."""
    with contextlib.suppress(ForumError):
        try:
            await identity.me()
        except ForumDenied as e:
            _log.error("the forum refuses the token, so every tool will", error=str(e))


async def serve(accounts: Accounts) -> None:
    """Until the client closes its end."""
    server = ForumServer(lambda _: accounts.current, accounts, own_pipes=True)
    checking = asyncio.create_task(_check(accounts.current))
    try:
        async with stdio_pipes() as (read, write):
            if await read.begins_with("initialize"):
                # The engine's `run` finds out the era of the protocol too, but then hands every message on once more.
                async with server.engine.lifespan(server.engine) as state:
                    await serve_loop(server.engine, read, write, lifespan_state=state, init_options=server.options())
            else:
                await server.engine.run(read, write, server.options())
    finally:
        checking.cancel()
        await server.close()
        await accounts.close()
