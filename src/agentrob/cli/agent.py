"""`agentrob agent`: the agent of one robot."""

from __future__ import annotations

from typing import Annotated

import typer

from agentrob.cli.options import ConfigFile, OnlyRobot, SomeRobots
from agentrob.wiring import app, serving

cli = typer.Typer(no_args_is_help=True, help="The agent of one robot.")


@cli.command("run")
def agent_run(
    robots: SomeRobots = None,
    config: ConfigFile = None,
    all_robots: Annotated[bool, typer.Option("--all", help="Serve every robot of the configuration.")] = False,
    standby: Annotated[bool, typer.Option(help="Let other workers go first; take over their robots.")] = False,
    most: Annotated[int | None, typer.Option(min=1, help="Serve at most this many robots at a time.")] = None,
    name: Annotated[str | None, typer.Option(help="Name of this process, instead of [worker] name.")] = None,
    metrics: Annotated[str | None, typer.Option(help="Address of the metrics, instead of [worker] metrics.")] = None,
) -> None:
    """Run the agent of one robot, or of several in one process, until it is ended.

    Several robots, --all, --standby or --most make it a worker: it serves each robot that no other worker holds, and
    takes over those of a worker that died.
    """
    settings = app.with_worker(app.load(config), name=name, metrics=metrics)
    if all_robots or standby or most is not None or len(robots or ()) > 1:
        app.run_worker(settings, app.some_robots(settings, robots or ()), most, standby)
    else:
        app.run_agent(settings, app.only_robot(settings, robots[0] if robots else None), once=False)


@cli.command("once")
def agent_once(robot: OnlyRobot = None, config: ConfigFile = None) -> None:
    """Scan the forum once, carry out new commands, and exit."""
    settings = app.load(config)
    app.run_agent(settings, app.only_robot(settings, robot), once=True)


@cli.command("drain")
def agent_drain(
    names: Annotated[list[str] | None, typer.Argument(help="Robots, or names of workers; by default all.")] = None,
) -> None:
    """Let workers and agents on this machine finish the commands that move, give their robots back, and end.

    A worker drains with all of its robots. Commands that wait are continued by whoever serves the robot next.
    """
    for line in app.drain_workers(names or ()):
        typer.echo(line)


@cli.command("serve")
def agent_serve(robot: OnlyRobot = None, config: ConfigFile = None) -> None:
    """Run the agent with its HTTP API until it is ended. With `service.loop = false`: the API alone."""
    settings = app.load(config)
    serving.serve_agent(settings, app.only_robot(settings, robot))
