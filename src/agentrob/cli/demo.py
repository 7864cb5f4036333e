"""`agentrob demo`: run a forum, a simulated world and two robots on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agentrob.cli.options import World
from agentrob.wiring.running_demo import demo_folder

cli = typer.Typer(invoke_without_command=True, help="Start a forum, a simulated world and its robots on this machine.")


@cli.callback()
def demo(
    context: typer.Context,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port of the forum; 0 for any free one. [default: 8088]")
    ] = None,
    data: Annotated[Path | None, typer.Option(help="The data folder.")] = None,
    post: Annotated[str | None, typer.Option(help="Post this text, wait for the answer, print it and exit.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="With --post: print the answer as one JSON object.")] = False,
    world: World = "room",
    robot: Annotated[
        list[str] | None, typer.Option(help="Add a robot of another installed kind; may be repeated.")
    ] = None,
    mind: Annotated[
        str | None,
        typer.Option(
            help="Mind that reads posts: rules, or a [minds.NAME] of ./agentrob.toml. [default: as last time]"
        ),
    ] = None,
) -> None:
    """Start everything on this machine and print the address to open."""
    if context.invoked_subcommand:
        return
    from agentrob.demo import run as demonstration

    once = post is not None
    if port is None and not once:
        port = demonstration.PORT
    settings = demonstration.DemoSettings(
        data=(data or demo_folder(once)).expanduser().absolute(),
        port=port or None,
        post=post,
        as_json=as_json,
        world=world,
        more=tuple(robot or ()),
        mind=mind,
    )
    raise typer.Exit(demonstration.run(settings))


@cli.command("link")
def demo_link(data: Annotated[Path | None, typer.Option(help="The demo's data folder.")] = None) -> None:
    """Print a new one-time sign-in link for the running demo."""
    from agentrob.demo import run as demonstration

    demonstration.print_link((data or demo_folder(once=False)).expanduser().absolute())
