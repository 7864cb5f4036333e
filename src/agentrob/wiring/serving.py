"""Serve an agent over HTTP, and the forum and the robots as tools for MCP clients."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from agentrob.config.load import Config
from agentrob.process.child import print_ready
from agentrob.process.interpreter import importing
from agentrob.process.logs import log_to_stderr
from agentrob.wiring import app

if TYPE_CHECKING:
    from agentrob.forums.protocol import Forum


def serve_agent(config: Config, name: str) -> None:
    """Run an agent and its HTTP service until SIGTERM or Ctrl-C."""
    from agentrob.service import server

    log_to_stderr()
    listens = config.service.loop

    async def serve() -> None:
        parts = server.assemble(
            config.service,
            name,
            lambda on_end: app.make_agent(config, name, on_end=on_end, listens=listens),
            lambda token: app.make_forum(config, token),
        )
        with server.listen(config.service) as listener:
            await server.serve(parts, listener, lambda url: print_ready(robot=name, url=url))

    asyncio.run(serve())


def serve_mcp_forum(config: Config, http: bool, write: bool = False) -> None:
    """Serve the forum as MCP tools: to one client over stdio, or to the configured users over HTTP."""
    with importing():
        from agentrob.mcp.forum import run

        if http:
            import agentrob.mcp.forum.http  # noqa: F401
    log_to_stderr()

    def open_forum(token: str) -> Forum:
        return app.make_forum(config, token)

    if http:
        run.run_http(config, open_forum)
    else:
        run.run_stdio(config, open_forum, app.secret(config), write or config.mcp.write)


def serve_mcp_robot(config: Config, http: bool) -> None:
    """Serve the robots as MCP tools, through their HTTP services: to one client over stdio, or over HTTP."""
    log_to_stderr()
    with importing():
        if http:
            from agentrob.mcp.robots import http as server
        else:
            from agentrob.mcp.robots import server  # type: ignore[no-redef]
    server.run(config.mcp_robot)
