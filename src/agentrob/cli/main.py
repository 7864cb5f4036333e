"""The command line's entry point and its groups of commands. Commands import what they need when they run."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from agentrob import __version__
from agentrob.cli import agent, board, mcp, minds, processes, robots, start
from agentrob.errors import AgentRobError
from agentrob.process.child import end_with_parent

START, ROBOTS, FORUM, PROCESSES = "First steps", "Robots", "Forum and agents", "Processes that others start"

cli = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
cli.add_typer(start.demo_cli, name="demo", rich_help_panel=START)
cli.command(rich_help_panel=START)(minds.plan)
cli.command(rich_help_panel=START)(robots.drive)
cli.command(rich_help_panel=START)(start.init)
cli.command(rich_help_panel=ROBOTS)(robots.stop)
cli.command(rich_help_panel=ROBOTS)(robots.doctor)
cli.command(rich_help_panel=ROBOTS)(robots.release)
cli.command(rich_help_panel=ROBOTS)(robots.home)
cli.command(rich_help_panel=ROBOTS)(robots.room)
cli.add_typer(board.cli, name="board", rich_help_panel=FORUM)
cli.add_typer(agent.cli, name="agent", rich_help_panel=FORUM)
cli.command(rich_help_panel=FORUM)(robots.fleet)
cli.add_typer(minds.cli, name="mind", rich_help_panel=FORUM)
cli.add_typer(minds.eval_cli, name="eval", rich_help_panel=FORUM)
cli.add_typer(mcp.cli, name="mcp", rich_help_panel=FORUM)
cli.command(rich_help_panel=PROCESSES)(processes.driver)
cli.command(rich_help_panel=PROCESSES)(processes.sim)
cli.command(rich_help_panel=PROCESSES)(processes.simulator)


@cli.callback(invoke_without_command=True)
def _root(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    """Robots on an online forum: a post comes in, a robot moves, a reply goes out."""
    if version:
        typer.echo(__version__)
        raise typer.Exit


def error_line(error: AgentRobError) -> str:
    """The error as one line, with its hint if it has one."""
    hint = getattr(error, "hint", "")
    return f"agentrob: {error}; {hint}" if hint else f"agentrob: {error}"


def main() -> None:
    """Run the command line. An `AgentRobError` becomes one line on standard error and exit code 1."""
    end_with_parent()
    try:
        cli()
    except AgentRobError as e:
        sys.exit(error_line(e))


if __name__ == "__main__":
    main()
