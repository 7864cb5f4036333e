"""`agentrob mcp`: serve the forum, or robots, as tools for MCP clients."""

from __future__ import annotations

from typing import Annotated

import typer

from agentrob.cli.options import ConfigFile
from agentrob.wiring import app, serving

cli = typer.Typer(no_args_is_help=True, help="The forum, and robots, as tools for MCP clients.")


@cli.command("forum")
def mcp_forum(
    http: Annotated[bool, typer.Option("--http", help="Serve the users of [mcp.users] over HTTP.")] = False,
    write: Annotated[bool, typer.Option("--write", help="Allow writes over stdio, as mcp.write does.")] = False,
    config: ConfigFile = None,
) -> None:
    """Serve the forum to one MCP client over standard input and output, or to several over HTTP."""
    serving.serve_mcp_forum(app.load(config), http, write)


@cli.command("robot")
def mcp_robot(
    http: Annotated[
        bool, typer.Option("--http", help="Serve over HTTP, with the token of mcp_robot.token_env.")
    ] = False,
    config: ConfigFile = None,
) -> None:
    """Serve the robots of [mcp_robot] to one MCP client over standard input and output, or over HTTP."""
    serving.serve_mcp_robot(app.load(config), http)
