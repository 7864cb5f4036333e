"""Options and arguments that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agentrob.model import Role

ConfigFile = Annotated[Path | None, typer.Option("--config", "-c", help="Configuration file. [default: agentrob.toml]")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
RobotName = Annotated[str, typer.Argument(help="The robot's name.")]
OnlyRobot = Annotated[
    str | None, typer.Argument(help="The robot's name in the configuration; optional if there is only one.")
]
SomeRobots = Annotated[
    list[str] | None, typer.Argument(help="Names of robots in the configuration; optional if there is only one.")
]
RobotKind = Annotated[str, typer.Option("--model", help="The kind of robot: go2, g1.")]
DemoData = Annotated[Path | None, typer.Option("--data", help="Data folder of the demo, if the robot belongs to one.")]
World = Annotated[str, typer.Option(help="room, obstacles, corridor, or the path of a world file.")]
Handle = Annotated[str, typer.Argument(help="The handle of the account.")]
LeastRole = Annotated[Role | None, typer.Option(help="The minimum role to do this.")]
