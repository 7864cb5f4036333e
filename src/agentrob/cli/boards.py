"""`agentrob board boards` and `agentrob board robot`: boards with their rights, and the settings of robots."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from agentrob.cli.forum_database import administer, read
from agentrob.cli.options import ConfigFile, Handle, LeastRole
from agentrob.errors import ConfigError
from agentrob.model import ActionClass, Role

cli = typer.Typer(no_args_is_help=True, help="The forum's boards, and who may read, post and command there.")
robot_cli = typer.Typer(no_args_is_help=True, help="Robots on the forum: owner, rights, camera, maintenance.")

BoardId = Annotated[str, typer.Argument(help="The board's id, as in its address: lower-case letters, digits, -.")]


@cli.command("add")
def boards_add(
    board: BoardId,
    name: Annotated[str, typer.Option(help="The name that people see.")],
    description: Annotated[str, typer.Option(help="One line under the name.")] = "",
    read: Annotated[Role, typer.Option(help="The minimum role to read.")] = Role.GUEST,
    post: Annotated[Role, typer.Option(help="The minimum role to post.")] = Role.MEMBER,
    command: Annotated[Role, typer.Option(help="The minimum role to command robots.")] = Role.OPERATOR,
    config: ConfigFile = None,
) -> None:
    """Add a board."""
    from agentrob.board.db.records import Board

    made = administer(config, "add_board", Board(board, name, description, read, post, command))
    typer.echo(f"{made.id}: read {made.read_role}, post {made.post_role}, command {made.command_role}")


@cli.command("change")
def boards_change(
    board: BoardId,
    name: Annotated[str | None, typer.Option(help="The name that people see.")] = None,
    description: Annotated[str | None, typer.Option(help="One line under the name.")] = None,
    read: LeastRole = None,
    post: LeastRole = None,
    command: LeastRole = None,
    config: ConfigFile = None,
) -> None:
    """Change a board's name, description, or who may read, post and command."""
    given = {"name": name, "description": description, "read_role": read, "post_role": post, "command_role": command}
    changed = administer(config, "change_board", board, **{k: v for k, v in given.items() if v is not None})
    typer.echo(f"{changed.id}: read {changed.read_role}, post {changed.post_role}, command {changed.command_role}")


@cli.command("list")
def boards_list(config: ConfigFile = None) -> None:
    """List all boards."""
    for b in read(config, lambda reader: reader.boards()):
        typer.echo(f"{b.id}\t{b.name}\tread {b.read_role}, post {b.post_role}, command {b.command_role}")


# ---------------------------------------------------------------------- robots
@robot_cli.command("show")
def robot_show(name: Handle, config: ConfigFile = None) -> None:
    """Show the settings of a robot."""
    from agentrob.board.admin.management import robot_settings

    typer.echo(_robot_lines(read(config, lambda reader: robot_settings(reader, name))))


@robot_cli.command("change")
def robot_change(
    name: Handle,
    owner: Annotated[str | None, typer.Option(help="The owner's handle; empty for no owner.")] = None,
    command: Annotated[
        list[str] | None, typer.Option(help="CLASS=WHO: photo, gesture, move, risky; a role, owner or nobody.")
    ] = None,
    approve: Annotated[str | None, typer.Option(help="Who approves: a role, owner or nobody.")] = None,
    release: Annotated[str | None, typer.Option(help="Who releases it: owner, admin or nobody.")] = None,
    approval: Annotated[str | None, typer.Option(help="Classes that need approval, separated by commas.")] = None,
    approve_own: Annotated[bool | None, typer.Option(help="Whether approvers may approve their own commands.")] = None,
    camera: Annotated[Role | None, typer.Option(help="The minimum role to see its pictures.")] = None,
    camera_days: Annotated[int | None, typer.Option(help="Days to keep pictures; 0 for ever.")] = None,
    closed: Annotated[
        list[str] | None, typer.Option(help="mon-fri 22:00-06:00 Europe/Berlin, or until TIME; '' for never.")
    ] = None,
    config: ConfigFile = None,
) -> None:
    """Change a robot's owner, rights, camera and maintenance hours."""
    from agentrob.board.auth.rights import hours_from_words

    given: dict[str, Any] = {"owner": owner, "approve": approve, "release": release}
    given |= {"camera_role": camera, "camera_days": camera_days, "approve_own": approve_own}
    if approval is not None:
        given["approval"] = tuple(c for c in approval.split(",") if c)
    if closed is not None:
        given["closed"] = tuple(hours for words in closed for hours in hours_from_words(words))
    changes = {k: v for k, v in given.items() if v is not None}
    if command:
        now = administer(config, "change_robot", name)
        changes["command"] = dict(now.command) | dict(_pair(pair) for pair in command)
    typer.echo(_robot_lines(administer(config, "change_robot", name, **changes)))


def _pair(text: str) -> tuple[str, str]:
    kind, _, who = text.partition("=")
    if kind not in frozenset(ActionClass) or not who:
        raise ConfigError(f"invalid right {text!r}; valid: CLASS=WHO with a class of {', '.join(ActionClass)}")
    return kind, who


def _robot_lines(kept: Any) -> str:
    from agentrob.board.auth.rights import hours_in_words

    command = ", ".join(f"{k} {v}" for k, v in kept.command.items())
    days = f"{kept.camera_days} days" if kept.camera_days else "for ever"
    lines = [f"owner: {kept.owner or 'nobody'}", f"command: {command}"]
    own = ", also their own" if kept.approve_own else ""
    lines += [f"approve: {kept.approve}{own}; needs approval: {', '.join(kept.approval) or 'nothing'}"]
    lines += [f"release: {kept.release}", f"camera: {kept.camera_role}, pictures kept {days}"]
    return "\n".join([*lines, f"closed: {hours_in_words(kept.closed) or 'never'}"])
