"""`agentrob demo` and `agentrob init`: run a forum with robots on this machine, for a try or for good."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from agentrob.cli.options import World
from agentrob.config.section import DEFAULT_LISTEN
from agentrob.errors import ConfigError
from agentrob.setup.answers import Answers, RobotAnswers, Services
from agentrob.wiring.running_demo import demo_folder

demo_cli = typer.Typer(
    invoke_without_command=True, help="Start a forum, a simulated world and its robots on this machine."
)


@demo_cli.callback()
def demo(
    context: typer.Context,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Port of the forum; 0 for any free one. [default: 8088, or any free one]"),
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
            help="Mind that reads posts: rules, or a mind of ./agentrob.toml. By default the one of last time."
        ),
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the forum in a browser, where there is one.")
    ] = True,
) -> None:
    """Start everything on this machine and print the address to open."""
    if context.invoked_subcommand:
        return
    from agentrob.demo import run as demonstration

    once = post is not None
    if port is None and once:
        port = 0
    settings = demonstration.DemoSettings(
        data=(data or demo_folder(once)).expanduser().absolute(),
        port=port,
        post=post,
        as_json=as_json,
        world=world,
        more=tuple(robot or ()),
        mind=mind,
        browser=browser,
    )
    raise typer.Exit(demonstration.run(settings))


@demo_cli.command("link")
def demo_link(data: Annotated[Path | None, typer.Option(help="The demo's data folder.")] = None) -> None:
    """Print a new one-time sign-in link for the running demo."""
    from agentrob.demo import run as demonstration

    demonstration.print_link((data or demo_folder(once=False)).expanduser().absolute())


# ---------------------------------------------------------------------- init
def init(
    admin: Annotated[
        str, typer.Option(help="The handle of the first admin. Without it, a dialogue asks for everything.")
    ] = "",
    url: Annotated[str, typer.Option(help="The address that browsers see, such as https://forum.example.org.")] = "",
    listen: Annotated[str, typer.Option(help="Host and port where the forum listens.")] = DEFAULT_LISTEN,
    title: Annotated[str, typer.Option(help="The name of the forum.")] = "AgentRob",
    data: Annotated[str, typer.Option(help="The data folder.")] = "",
    database: Annotated[str, typer.Option(help="A database URL. [default: SQLite in the data folder]")] = "",
    invites: Annotated[int, typer.Option(min=0, max=1000, help="How many people one invite admits.")] = 0,
    robot: Annotated[str, typer.Option(help="The name of a robot to add, which is its handle.")] = "",
    model: Annotated[str, typer.Option("--model", help="The robot's kind: go2, g1, …")] = "go2",
    interface: Annotated[
        str, typer.Option(help="Network interface of a real robot; without it, the robot is simulated.")
    ] = "",
    domain: Annotated[
        int | None, typer.Option(min=0, max=230, help="DDS domain. [default: 0 if real, else a free one]")
    ] = None,
    services: Annotated[
        Services, typer.Option(help="What runs the processes: systemd as you or as root, Docker Compose, or nothing.")
    ] = Services.NONE,
    walk: Annotated[bool, typer.Option("--walk", help="Let the robot walk 0.3 m (0.1 m if real) at the end.")] = False,
    config: Annotated[Path, typer.Option("--config", "-c", help="The file to write.")] = Path("agentrob.toml"),
) -> None:
    """Set up a forum, and a robot with its driver and agent, and start them.

    In a terminal and without options a dialogue asks for everything. Each step says what it did and how to undo it.
    """
    from agentrob.setup import run

    added = None
    if robot:
        added = RobotAnswers(robot, model, not interface, interface or "lo", domain)
    answers = Answers(admin, config, title, listen, url, data, database, invites, added, services, walk)
    if not admin:
        answers = _ask(answers)
    elif walk and (added is None or services is Services.NONE):
        raise ConfigError("--walk needs --robot NAME and --services, which start the robot")
    run.set_up(answers, typer.echo)


def _ask(given: Answers) -> Answers:
    """Ask for what the options leave open. Raises `ConfigError` without a terminal."""
    from rich.console import Console

    from agentrob.setup.dialogue import Dialogue

    if not sys.stdin.isatty():
        raise ConfigError("there is no terminal to ask on; give the first admin's handle: --admin NAME")
    if given.config.exists():
        raise ConfigError(f"{given.config} already exists; name another file with --config")
    unset = Answers(admin="")
    keys = ("admin", "title", "listen", "robot", "services", "walk")
    asked = [key for key in keys if getattr(given, key) == getattr(unset, key)]
    return Dialogue(Console(highlight=False)).complete(given, asked=asked)
