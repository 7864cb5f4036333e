"""`agentrob drive`, `doctor`, `stop`, `release`, `home`: one robot, without a forum; `room` and `fleet`: several."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from agentrob.cli.options import AsJson, ConfigFile, DemoData, RobotName
from agentrob.process.logs import log_to_stderr
from agentrob.wiring import app


def drive(
    robot: Annotated[str, typer.Argument(help="A configured robot, or a kind: go2, g1, …")],
    text: Annotated[str, typer.Argument(help="What to do, in words.")],
    config: ConfigFile = None,
    interface: Annotated[
        str | None, typer.Option(help="Network interface of a real robot; without it, drive a simulated robot.")
    ] = None,
    pictures: Annotated[Path, typer.Option(help="Folder for pictures.")] = Path("."),
    as_json: AsJson = False,
    mind: Annotated[
        str | None,
        typer.Option(
            help="The mind that reads the text: rules, or one of the configuration, which steers if it reads images. "
            "By default the robot's own."
        ),
    ] = None,
) -> None:
    """Drive a robot without a forum."""
    from agentrob.wiring import drive as driving

    log_to_stderr()
    raise typer.Exit(driving.run(robot, text, app.load(config), interface, pictures, as_json, mind))


def doctor(
    robot: Annotated[
        str | None, typer.Argument(help="A configured robot, or a kind: go2, g1. Without it: the forum and all robots.")
    ] = None,
    config: ConfigFile = None,
    interface: Annotated[str | None, typer.Option(help="Network interface, instead of the configured one.")] = None,
    domain: Annotated[int | None, typer.Option(help="DDS domain, instead of the configured one.")] = None,
    read_only: Annotated[bool, typer.Option("--read-only", help="Do not move the robot (the default).")] = False,
    move: Annotated[bool, typer.Option("--move", help="Walk 10 cm forward if no problem was found.")] = False,
    as_json: AsJson = False,
) -> None:
    """Diagnose what prevents a robot, or the whole installation, from working, and name the commands that mend it.

    Exit code 1 if there is a problem. It also finds a running demo and its robots.
    """
    from agentrob.demo import run as demonstration
    from agentrob.wiring.doctor import run as examination

    if read_only and move:
        raise typer.BadParameter("--read-only and --move exclude each other")
    settings = demonstration.config_for(robot, config)
    if robot is None and interface is None and domain is None and not move:
        raise typer.Exit(examination.run_all(settings, as_json, config))
    raise typer.Exit(examination.run_robot(robot, settings, interface, domain, move, as_json, config))


def stop(
    robot: Annotated[str | None, typer.Argument(help="The robot's name; without it, stop all robots.")] = None,
    everyone: Annotated[bool, typer.Option("--all", help="Every robot that a driver on this machine holds.")] = False,
    config: ConfigFile = None,
) -> None:
    """Stop a robot now. Needs no forum, agent, journal or configuration. If in doubt, all robots are stopped."""
    lines, code = app.stop(None if everyone else robot, config)
    typer.echo("\n".join(lines))
    raise typer.Exit(code)


def release(robot: RobotName, config: ConfigFile = None, data: DemoData = None) -> None:
    """Release a robot that an emergency stop has locked. Run this on the robot's machine. Nothing moves."""
    from agentrob.wiring import unlock

    typer.echo(unlock.release(robot, app.load(config), data))


def home(robot: RobotName, config: ConfigFile = None, data: DemoData = None) -> None:
    """Set a robot's home to its current position. Run this on the robot's machine; the robot must stand still."""
    from agentrob.wiring import unlock

    typer.echo(unlock.home(robot, app.load(config), data))


def room(
    name: Annotated[str, typer.Argument(help="A room that robots of the configuration share.")],
    config: ConfigFile = None,
    release: Annotated[
        str | None,
        typer.Option(help="End the zone of this robot, whose driver is silent. First see that the robot is at rest."),
    ] = None,
) -> None:
    """Show who shares a room, who moves and who waits there. Run this where a driver of the room runs."""
    from agentrob.wiring.rooms import lines

    for line in lines(name, app.load(config), release):
        typer.echo(line)


def fleet(config: ConfigFile = None, as_json: AsJson = False) -> None:
    """Show every robot of the forum: who serves it, its state and latency, its last stop and its failures."""
    from rich.console import Console

    from agentrob.wiring.fleet import read_fleet, table

    robots = read_fleet(app.load(config))
    if as_json:
        typer.echo(json.dumps([robot.as_data() for robot in robots]))
    else:
        Console().print(table(robots, datetime.now(UTC)))
