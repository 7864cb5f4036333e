"""`agentrob agent`: the agent of one robot."""

from __future__ import annotations

import typer

from agentrob.cli.options import ConfigFile, OnlyRobot
from agentrob.wiring import app, serving

cli = typer.Typer(no_args_is_help=True, help="The agent of one robot.")


@cli.command("run")
def agent_run(robot: OnlyRobot = None, config: ConfigFile = None) -> None:
    """Run the agent until it is ended: carry out commands that mention the robot."""
    settings = app.load(config)
    app.run_agent(settings, app.only_robot(settings, robot), once=False)


@cli.command("once")
def agent_once(robot: OnlyRobot = None, config: ConfigFile = None) -> None:
    """Scan the forum once, carry out new commands, and exit."""
    settings = app.load(config)
    app.run_agent(settings, app.only_robot(settings, robot), once=True)


@cli.command("serve")
def agent_serve(robot: OnlyRobot = None, config: ConfigFile = None) -> None:
    """Run the agent with its HTTP API until it is ended. With `service.loop = false`: the API alone."""
    settings = app.load(config)
    serving.serve_agent(settings, app.only_robot(settings, robot))
