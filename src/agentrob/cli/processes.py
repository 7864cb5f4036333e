"""`agentrob driver`, `agentrob sim` and `agentrob simulator`: processes that other commands or services start."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agentrob.cli.options import ConfigFile, OnlyRobot, World
from agentrob.wiring import app


def driver(
    robot: OnlyRobot = None,
    config: ConfigFile = None,
    listen: Annotated[
        str | None, typer.Option(help="Also serve agents on other machines: HOST:PORT. [default: driver_listen]")
    ] = None,
) -> None:
    """Run the driver of one robot, the only process that moves it."""
    settings = app.load(config)
    app.run_driver(settings, app.only_robot(settings, robot), listen)


def sim(
    world: World = "room",
    robot: Annotated[list[str] | None, typer.Option(help="go2 or g1; both with two --robot. [default: go2]")] = None,
    domain: Annotated[list[str] | None, typer.Option(help="ROBOT=DDS-DOMAIN. [default: go2=1, g1=2]")] = None,
    interface: Annotated[str, typer.Option(help="Network interface for DDS.")] = "lo",
    http_port: Annotated[int, typer.Option(help="Port of the room's camera; 0 for any free one.")] = 0,
    ledger: Annotated[Path | None, typer.Option(help="Write the simulator's ground truth to this file.")] = None,
) -> None:
    """Run a simulated world with walking robots that speak the real robots' DDS."""
    app.serve_world(robot or [], domain or [], world, interface, http_port, ledger)


def simulator(
    robot: Annotated[str, typer.Argument(help="The kind of robot, of a package that brings a simulation: ros2-sim, …")],
    domain: Annotated[int, typer.Option(min=0, max=230, help="DDS domain.")] = 0,
    interface: Annotated[str, typer.Option(help="Network interface for DDS.")] = "lo",
) -> None:
    """Run the simulation that the package of a robot brings along."""
    from agentrob.wiring.simulators import serve_simulator

    serve_simulator(robot, domain, interface)
