"""The words a person types. Each command is a few lines: the work is done in the rooms, imported when needed."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from agentrob import __version__
from agentrob.cli import board as cli_board
from agentrob.cli import board_admin
from agentrob.errors import AgentRobError
from agentrob.model import AccountKind, Role
from agentrob.process.child import follow_parent
from agentrob.process.logs import log_to_stderr
from agentrob.wiring import app, serving
from agentrob.wiring.running_demo import demo_folder

cli = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
demo_cli = typer.Typer(invoke_without_command=True)
board_cli = typer.Typer(no_args_is_help=True)
account_cli = typer.Typer(no_args_is_help=True)
agent_cli = typer.Typer(no_args_is_help=True)
eval_cli = typer.Typer(no_args_is_help=True)
mind_cli = typer.Typer(no_args_is_help=True)
mcp_cli = typer.Typer(no_args_is_help=True)
cli.add_typer(demo_cli, name="demo", help="Forum, simulated world and robot on this machine.")
cli.add_typer(board_cli, name="board", help="The embedded forum.")
board_cli.add_typer(account_cli, name="account", help="Accounts of the embedded forum.")
cli.add_typer(eval_cli, name="eval", help="Measure a mind on sentences of your own.")
cli.add_typer(agent_cli, name="agent", help="The agent of one robot.")
cli.add_typer(mind_cli, name="mind", help="The models that read posts.")
cli.add_typer(mcp_cli, name="mcp", help="The forum, and robots, as tools for MCP clients.")

ConfigFile = Annotated[
    Path | None, typer.Option("--config", "-c", help="The configuration file; ./agentrob.toml when it is there.")
]
RobotName = Annotated[str | None, typer.Argument(help="The robot's name in the configuration; not needed for one.")]


@cli.callback(invoke_without_command=True)
def _root(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    """Robots on an online forum: a post comes in, a robot moves, a reply goes out."""
    if version:
        typer.echo(__version__)
        raise typer.Exit


# ---------------------------------------------------------------------- demo
@demo_cli.callback()
def demo(
    context: typer.Context,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port of the forum; 0 for any free one. [default: 8088]")
    ] = None,
    data: Annotated[Path | None, typer.Option(help="Folder that keeps everything.")] = None,
    post: Annotated[str | None, typer.Option(help="Post this text, wait for the answer, print it and end.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="With --post: the last line is one JSON object.")] = False,
    world: Annotated[str, typer.Option(help="room, obstacles, corridor, or the path of a world's file.")] = "room",
    robot: Annotated[
        list[str] | None, typer.Option(help="Another kind of robot that is installed, beside the two; also several.")
    ] = None,
    mind: Annotated[
        str | None,
        typer.Option(help="Who reads posts: rules, or a [minds.NAME] of ./agentrob.toml. [default: as last]"),
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


@demo_cli.command("link")
def demo_link(data: Annotated[Path | None, typer.Option(help="The demo's data folder.")] = None) -> None:
    """Print another one-time link for the demo that runs."""
    from agentrob.demo import run as demonstration

    demonstration.print_link((data or demo_folder(once=False)).expanduser().absolute())


@eval_cli.callback()
@mind_cli.callback()
def _results_on_stdout() -> None:
    """What is said of models that fail is no part of a result."""
    log_to_stderr()


# ---------------------------------------------------------------------- language and robots
@cli.command()
def plan(
    text: Annotated[str, typer.Argument(help="What one would write in a post.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    model: Annotated[str, typer.Option(help="The kind of robot.")] = "go2",
) -> None:
    """Say what a robot would make of a text. Nothing moves."""
    facts = app.plan_text(text, model)
    if as_json:
        typer.echo(json.dumps(facts, ensure_ascii=False))
        return
    typer.echo(app.describe_plan(facts))


EvalFile = Annotated[Path, typer.Argument(help="Rows with text, one JSON object a line.")]
EvalMind = Annotated[str, typer.Option("--mind", help="rules, or a mind of the configuration.")]
EvalRobot = Annotated[str, typer.Option("--robot", help="The kind of robot: go2, g1.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
EvalLimit = Annotated[int | None, typer.Option("--limit", min=1, help="Only the first rows of the file.")]


@eval_cli.command("plan")
def eval_plan(
    file: Annotated[Path, typer.Argument(help="Rows of text and plan, one JSON object a line.")],
    mind: EvalMind = "rules",
    limit: EvalLimit = None,
    as_json: AsJson = False,
    config: ConfigFile = None,
) -> None:
    """How many sentences are understood exactly as they were meant."""
    from agentrob.evals import understanding

    found = understanding.evaluate_plans(file, mind, app.load(config), limit)
    typer.echo(json.dumps(found.as_json(), ensure_ascii=False) if as_json else understanding.describe(found))


@eval_cli.command("danger")
def eval_danger(
    file: EvalFile,
    mind: EvalMind = "rules",
    robot: EvalRobot = "go2",
    scenes: Annotated[bool, typer.Option("--scenes", help="Judge each row within its scene.")] = False,
    limit: EvalLimit = None,
    as_json: AsJson = False,
    config: ConfigFile = None,
) -> None:
    """How many dangerous commands would be executed, and how many harmless ones are refused."""
    from agentrob.evals import danger as measure

    found = measure.evaluate_danger(file, mind, robot, app.load(config), scenes=scenes, limit=limit)
    typer.echo(json.dumps(found.as_json(), ensure_ascii=False) if as_json else measure.describe(found))


@eval_cli.command("stop")
def eval_stop(
    file: Annotated[Path, typer.Argument(help="Rows of text and stop (true or false), one JSON object a line.")],
    limit: EvalLimit = None,
    as_json: AsJson = False,
) -> None:
    """How many posts stop a robot that moves, and how many stop it falsely."""
    from agentrob.evals import stops as measure

    found = measure.evaluate_stops(file, limit)
    typer.echo(json.dumps(found.as_json(), ensure_ascii=False) if as_json else measure.describe(found))


@eval_cli.command("injection")
def eval_injection(
    file: EvalFile,
    mind: EvalMind = "rules",
    robot: EvalRobot = "go2",
    limit: EvalLimit = None,
    as_json: AsJson = False,
    config: ConfigFile = None,
) -> None:
    """Whether text slipped into a post changes what the command beside it moves."""
    from agentrob.evals import injection as measure

    found = measure.evaluate_injections(file, mind, robot, app.load(config), limit)
    typer.echo(json.dumps(found.as_json(), ensure_ascii=False) if as_json else measure.describe(found))


@cli.command()
def drive(
    robot: Annotated[str, typer.Argument(help="A robot of the configuration, or a kind: go2, g1, …")],
    text: Annotated[str, typer.Argument(help="What to do, in words.")],
    config: ConfigFile = None,
    interface: Annotated[
        str | None, typer.Option(help="Network interface of a real robot; without it a simulated one is used.")
    ] = None,
    pictures: Annotated[Path, typer.Option(help="Where pictures are put.")] = Path("."),
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON.")] = False,
    mind: Annotated[
        str | None, typer.Option(help="Which mind reads it; a model with images may also look and steer.")
    ] = None,
) -> None:
    """Drive a robot without a forum."""
    from agentrob.wiring import drive as driving

    log_to_stderr()
    raise typer.Exit(driving.run(robot, text, app.load(config), interface, pictures, as_json, mind))


@cli.command()
def doctor(
    robot: Annotated[str | None, typer.Argument(help="A robot of the configuration, or a kind: go2, g1.")] = None,
    config: ConfigFile = None,
    interface: Annotated[str | None, typer.Option(help="Network interface, instead of the configured one.")] = None,
    domain: Annotated[int | None, typer.Option(help="DDS domain, instead of the configured one.")] = None,
    read_only: Annotated[bool, typer.Option("--read-only", help="Move nothing; so it is without --move too.")] = False,
    move: Annotated[bool, typer.Option("--move", help="Let it walk 10 cm forward when nothing bad was found.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Say what keeps a robot from being driven, and what to do about it. Exit code 1 when something does.

    Beside a running demo it knows the demo's robots too.
    """
    from agentrob.demo import run as demonstration
    from agentrob.wiring import doctor as examination

    if read_only and move:
        raise typer.BadParameter("--read-only moves nothing; leave one of the two out")
    settings = demonstration.config_for(robot, config)
    raise typer.Exit(examination.run(robot, settings, interface, domain, move, as_json))


@cli.command()
def stop(
    robot: Annotated[str | None, typer.Argument(help="The robot's name; without it all are stopped.")] = None,
    everyone: Annotated[bool, typer.Option("--all", help="Every robot that a driver on this machine holds.")] = False,
    config: ConfigFile = None,
) -> None:
    """Stop a robot now. Works without forum, agent, journal and configuration; in doubt all are stopped."""
    lines, code = app.stop(None if everyone else robot, config)
    typer.echo("\n".join(lines))
    raise typer.Exit(code)


DemoData = Annotated[Path | None, typer.Option("--data", help="The data folder of the demo whose robot is meant.")]
OwnRobot = Annotated[str, typer.Argument(help="The robot's name.")]


@cli.command()
def release(robot: OwnRobot, config: ConfigFile = None, data: DemoData = None) -> None:
    """Release a robot that is locked by an emergency stop, on its own machine. Nothing moves by that."""
    from agentrob.wiring import unlock

    typer.echo(unlock.release(robot, app.load(config), data))


@cli.command()
def home(robot: OwnRobot, config: ConfigFile = None, data: DemoData = None) -> None:
    """Make a robot's home where it stands now, on its own machine. It must stand still."""
    from agentrob.wiring import unlock

    typer.echo(unlock.home(robot, app.load(config), data))


@cli.command()
def driver(robot: RobotName = None, config: ConfigFile = None) -> None:
    """Hold one robot: the only process that moves it."""
    settings = app.load(config)
    app.run_driver(settings, app.only_robot(settings, robot))


@cli.command()
def sim(
    world: Annotated[str, typer.Option(help="room, obstacles, corridor, or the path of a world's file.")] = "room",
    robot: Annotated[list[str] | None, typer.Option(help="go2 or g1; both with two --robot. [default: go2]")] = None,
    domain: Annotated[list[str] | None, typer.Option(help="ROBOT=DDS-DOMAIN. [default: go2=1, g1=2]")] = None,
    interface: Annotated[str, typer.Option(help="Network interface for DDS.")] = "lo",
    http_port: Annotated[int, typer.Option(help="Port of the room's camera; 0 for any free one.")] = 0,
    ledger: Annotated[Path | None, typer.Option(help="Write what really happened to this file, line by line.")] = None,
) -> None:
    """Run a simulated world with walking robots that speak the real robots' DDS."""
    app.serve_world(robot or [], domain or [], world, interface, http_port, ledger)


# ---------------------------------------------------------------------- agent
@agent_cli.command("run")
def agent_run(robot: RobotName = None, config: ConfigFile = None) -> None:
    """Serve the robot's mentions until ended."""
    settings = app.load(config)
    app.run_agent(settings, app.only_robot(settings, robot), once=False)


@agent_cli.command("once")
def agent_once(robot: RobotName = None, config: ConfigFile = None) -> None:
    """Scan the forum once, do what is asked, and end."""
    settings = app.load(config)
    app.run_agent(settings, app.only_robot(settings, robot), once=True)


@agent_cli.command("serve")
def agent_serve(robot: RobotName = None, config: ConfigFile = None) -> None:
    """Serve the robot's mentions, and an HTTP API beside, until ended. `service.loop = false`: only when asked."""
    settings = app.load(config)
    serving.serve_agent(settings, app.only_robot(settings, robot))


# ---------------------------------------------------------------------- minds
@mind_cli.command("check")
def mind_check(
    mind: Annotated[str | None, typer.Argument(help="Its name in the configuration; without it all are asked.")] = None,
    config: ConfigFile = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Ask each configured model whether it can be used; takes a few tokens. Exit code 1 when one cannot."""
    found = app.check_minds(app.load(config), mind)
    if as_json:
        typer.echo(json.dumps([one.as_data() for one in found], ensure_ascii=False))
    else:
        typer.echo("\n".join([*(one.line() for one in found), "rules: always there, without a model"]))
    raise typer.Exit(0 if all(one.ok for one in found) else 1)


@mind_cli.command("try")
def mind_try(
    mind: Annotated[str, typer.Argument(help="Its name in the configuration, or rules.")],
    text: Annotated[str, typer.Argument(help="What one would write in a post.")],
    config: ConfigFile = None,
    model: Annotated[str, typer.Option(help="The kind of robot.")] = "go2",
) -> None:
    """Say what a mind makes of a text, and what that took. Nothing moves."""
    typer.echo("\n".join(app.try_mind(app.load(config), mind, text, model)))


# ---------------------------------------------------------------------- MCP
@mcp_cli.command("forum")
def mcp_forum(
    http: Annotated[bool, typer.Option("--http", help="Serve the users of [mcp.users] over HTTP.")] = False,
    write: Annotated[bool, typer.Option("--write", help="Allow writes over stdio, as mcp.write does.")] = False,
    config: ConfigFile = None,
) -> None:
    """Serve the forum to one MCP client over standard input and output, or to several over HTTP."""
    serving.serve_mcp_forum(app.load(config), http, write)


@mcp_cli.command("robot")
def mcp_robot(
    http: Annotated[bool, typer.Option("--http", help="Serve over HTTP, by mcp_robot.token_env.")] = False,
    config: ConfigFile = None,
) -> None:
    """Serve the robots of [mcp_robot] to one MCP client over standard input and output, or over HTTP."""
    serving.serve_mcp_robot(app.load(config), http)


# ---------------------------------------------------------------------- board
@board_cli.command("serve")
def board_serve(config: ConfigFile = None) -> None:
    """Run the embedded forum."""
    app.serve_board(app.load(config))


@account_cli.command("add")
def account_add(
    name: Annotated[str, typer.Argument(help="The handle after the @: small letters, digits, - and _.")],
    kind: Annotated[AccountKind, typer.Option(help="What stands behind it.")] = AccountKind.HUMAN,
    role: Annotated[Role, typer.Option(help="What it may do.")] = Role.MEMBER,
    config: ConfigFile = None,
) -> None:
    """Add an account; prints a one-time link (people) or a token (agents)."""
    settings = app.load(config)
    app.board_account(settings, name, kind, role)
    typer.echo(app.board_link(settings, name) if kind is AccountKind.HUMAN else app.board_token(settings, name))


@account_cli.command("change")
def account_change(
    name: str,
    role: Annotated[Role | None, typer.Option(help="What it may do from now on.")] = None,
    suspend: Annotated[
        bool | None, typer.Option("--suspend/--unsuspend", help="A suspended account can do nothing.")
    ] = None,
    config: ConfigFile = None,
) -> None:
    """Change an account's role, suspend it, or let it in again."""
    account = app.change_board_account(app.load(config), name, role, suspend)
    typer.echo(f"{account.name}: {account.kind}, {account.role}{', suspended' if account.suspended else ''}")


@account_cli.command("revoke")
def account_revoke(name: str, config: ConfigFile = None) -> None:
    """Make all bearer tokens of an account void."""
    typer.echo(f"{app.revoke_board_tokens(app.load(config), name)} tokens of {name} are void now")


@account_cli.command("link")
def account_link(name: str, config: ConfigFile = None) -> None:
    """Print a one-time link that signs this account in."""
    typer.echo(app.board_link(app.load(config), name))


@account_cli.command("token")
def account_token(
    name: str,
    label: Annotated[str, typer.Option(help="What it is for.")] = "",
    scope: Annotated[list[str] | None, typer.Option(help="read, write, admin. [default: read write]")] = None,
    config: ConfigFile = None,
) -> None:
    """Print a new bearer token of this account."""
    typer.echo(app.board_token(app.load(config), name, label, tuple(scope or ("read", "write"))))


cli_board.add_to(cli, board_cli)
board_admin.add_to(board_cli, account_cli)


def told(error: AgentRobError) -> str:
    """An error in one line, with what would be valid where the error says that apart, as the board's do."""
    hint = getattr(error, "hint", "")
    return f"agentrob: {error}; {hint}" if hint else f"agentrob: {error}"


def main() -> None:
    """The entry point: errors of ours are one line on standard error and exit code 1."""
    follow_parent()
    try:
        cli()
    except AgentRobError as e:
        sys.exit(told(e))


if __name__ == "__main__":
    main()
