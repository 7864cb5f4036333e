"""The words a person types to administer the embedded forum: accounts, boards, robots, invites, moderation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from agentrob.cli.board import ConfigFile, in_transaction, looked_up, settings_of
from agentrob.errors import AgentRobError, ConfigError
from agentrob.model import ActionClass, Role

Reason = Annotated[str, typer.Option(help="Why, for the audit log.")]
RoleOption = Annotated[Role | None, typer.Option(help="The least role for it.")]
Pairs = Annotated[list[str] | None, typer.Option(help="CLASS=WHO: photo, gesture, move, risky; operator … nobody.")]
Text = Annotated[str | None, typer.Option()]

robot_cli = typer.Typer(no_args_is_help=True, help="Robots on the forum: owner, rights, camera, maintenance.")
boards_cli = typer.Typer(no_args_is_help=True, help="The forum's boards, and who may read, post and command.")
invite_cli = typer.Typer(no_args_is_help=True, help="Links by which people make their own accounts.")
moderate_cli = typer.Typer(no_args_is_help=True, help="Hide, show, lock, move.")


def _do(config: Path | None, deed: str, *args: Any, **options: Any) -> Any:
    """Call a function of `management` as the shell, in a transaction of its own; a server may be running."""
    from agentrob.board.admin import local_admin, management
    from agentrob.board.admin.audit import SHELL

    with local_admin.writing(settings_of(config)) as connection:
        return getattr(management, deed)(connection, SHELL, *args, **options)


# ---------------------------------------------------------------------- accounts
def account_list(config: ConfigFile = None) -> None:
    """All accounts."""
    from agentrob.board.admin import management

    for a in looked_up(config, lambda reader: management.all_accounts(reader, "", 1_000_000)):
        typer.echo(f"{a.name}\t{a.kind}\t{a.role}{chr(9) + 'suspended' if a.suspended else ''}")


def account_password(name: str, config: ConfigFile = None) -> None:
    """Print a one-time link that sets a new password; sessions of before end when it is used."""
    typer.echo(settings_of(config).base_url + _do(config, "link", name, "password"))


def account_sign_out(name: str, config: ConfigFile = None) -> None:
    """End all sessions of an account."""
    typer.echo(f"{_do(config, 'sign_out_everywhere', name)} sessions ended")


def account_erase(
    name: str,
    yes: Annotated[bool, typer.Option("--yes", help="Do it; without this it is only said what would be.")] = False,
    config: ConfigFile = None,
) -> None:
    """Delete for good all posts and pictures of an account."""
    from agentrob.board.admin import moderation
    from agentrob.board.admin.audit import SHELL

    settings = settings_of(config)
    if not yes:
        raise AgentRobError(f"this deletes all that {name} wrote and uploaded, for good; say so with --yes")
    posts, pictures, digests = in_transaction(settings, lambda t: moderation.erase(t, SHELL, name))
    in_transaction(settings, lambda t: moderation.take_away(t, settings.images_dir, digests))
    typer.echo(f"{posts} posts and {pictures} pictures of {name} are deleted")


def account_tokens(name: str, config: ConfigFile = None) -> None:
    """The tokens of an account, without their secrets."""
    from agentrob.board.admin import management

    for t in looked_up(config, lambda reader: management.tokens(reader, name)):
        state = "revoked" if t.revoked_at else "good"
        typer.echo(f"{t.id}\t{t.label or '-'}\t{'+'.join(t.scopes)}\t{t.created_at:%Y-%m-%d}\t{state}")


def account_display(name: str, shown: str, config: ConfigFile = None) -> None:
    """Show another name beside the handle; '' shows the handle alone."""
    typer.echo(f"{name}: {_do(config, 'change_account', name, display_name=shown).display_name}")


def account_revoke_one(token: str, config: ConfigFile = None) -> None:
    """End one token at once, by the id that `tokens` shows."""
    _do(config, "revoke_token", token)
    typer.echo("revoked")


# ---------------------------------------------------------------------- boards and robots
@boards_cli.command("add")
def boards_add(
    board: Annotated[str, typer.Argument(help="Its id, as in the address: small letters, digits, -.")],
    name: Annotated[str, typer.Option(help="What people read.")],
    description: Annotated[str, typer.Option()] = "",
    read: Annotated[Role, typer.Option(help="The least role that reads.")] = Role.GUEST,
    post: Annotated[Role, typer.Option(help="The least role that posts.")] = Role.MEMBER,
    command: Annotated[Role, typer.Option(help="The least role that commands.")] = Role.OPERATOR,
    config: ConfigFile = None,
) -> None:
    """A new board."""
    from agentrob.board.db.records import Board

    made = _do(config, "add_board", Board(board, name, description, read, post, command))
    typer.echo(f"{made.id}: read {made.read_role}, post {made.post_role}, command {made.command_role}")


@boards_cli.command("change")
def boards_change(
    board: str,
    name: Text = None,
    description: Text = None,
    read: RoleOption = None,
    post: RoleOption = None,
    command: RoleOption = None,
    config: ConfigFile = None,
) -> None:
    """Change a board's name, description, or who may read, post and command."""
    given = {"name": name, "description": description, "read_role": read, "post_role": post, "command_role": command}
    changed = _do(config, "change_board", board, **{k: v for k, v in given.items() if v is not None})
    typer.echo(f"{changed.id}: read {changed.read_role}, post {changed.post_role}, command {changed.command_role}")


@boards_cli.command("list")
def boards_list(config: ConfigFile = None) -> None:
    """All boards."""
    for b in looked_up(config, lambda reader: reader.boards()):
        typer.echo(f"{b.id}\t{b.name}\tread {b.read_role}, post {b.post_role}, command {b.command_role}")


@robot_cli.command("show")
def robot_show(name: str, config: ConfigFile = None) -> None:
    """What is kept of a robot."""
    typer.echo(_robot_lines(_do(config, "change_robot", name)))


@robot_cli.command("change")
def robot_change(
    name: str,
    owner: Annotated[str | None, typer.Option(help="The owner's handle; empty for nobody.")] = None,
    command: Pairs = None,
    approve: Text = None,
    release: Text = None,
    approval: Annotated[str | None, typer.Option(help="Classes that need approval, with commas.")] = None,
    approve_own: Annotated[
        bool | None, typer.Option(help="Whether who approves may approve what they asked for themselves.")
    ] = None,
    camera: Annotated[Role | None, typer.Option(help="The least role that sees its pictures.")] = None,
    camera_days: Annotated[int | None, typer.Option(help="Days that pictures are kept; 0 for ever.")] = None,
    closed: Annotated[
        list[str] | None, typer.Option(help="mon-fri 22:00-06:00 Europe/Berlin, or until TIME; '' for never.")
    ] = None,
    config: ConfigFile = None,
) -> None:
    """Change a robot's owner, who may do what with it, its camera and its maintenance hours."""
    from agentrob.board.robots.rights import hours_from_words

    given: dict[str, Any] = {"owner": owner, "approve": approve, "release": release}
    given |= {"camera_role": camera, "camera_days": camera_days, "approve_own": approve_own}
    if approval is not None:
        given["approval"] = tuple(c for c in approval.split(",") if c)
    if closed is not None:
        given["closed"] = tuple(hours for words in closed for hours in hours_from_words(words))
    changes = {k: v for k, v in given.items() if v is not None}
    if command:
        now = _do(config, "change_robot", name)
        changes["command"] = dict(now.command) | dict(_pair(pair) for pair in command)
    typer.echo(_robot_lines(_do(config, "change_robot", name, **changes)))


def _pair(text: str) -> tuple[str, str]:
    kind, _, who = text.partition("=")
    if kind not in frozenset(ActionClass) or not who:
        raise ConfigError(f"{text!r} is no right; valid: CLASS=WHO with a class of {', '.join(ActionClass)}")
    return kind, who


def _robot_lines(kept: Any) -> str:
    from agentrob.board.robots.rights import hours_in_words

    command = ", ".join(f"{k} {v}" for k, v in kept.command.items())
    days = f"{kept.camera_days} days" if kept.camera_days else "for ever"
    lines = [f"owner: {kept.owner or 'nobody'}", f"command: {command}"]
    own = ", also their own" if kept.approve_own else ""
    lines += [f"approve: {kept.approve}{own}; needs approval: {', '.join(kept.approval) or 'nothing'}"]
    lines += [f"release: {kept.release}", f"camera: {kept.camera_role}, pictures kept {days}"]
    return "\n".join([*lines, f"closed: {hours_in_words(kept.closed) or 'never'}"])


# ---------------------------------------------------------------------- invites and moderation
@invite_cli.command("add")
def invite_add(
    role: Annotated[Role, typer.Option(help="What the new accounts may do.")] = Role.MEMBER,
    uses: Annotated[int, typer.Option(help="How many people may use it.")] = 1,
    days: Annotated[int, typer.Option(help="How long it is good.")] = 7,
    config: ConfigFile = None,
) -> None:
    """Print a link by which people make their own accounts."""
    typer.echo(settings_of(config).base_url + _do(config, "invite", role, uses, days))


@invite_cli.command("list")
def invite_list(config: ConfigFile = None) -> None:
    """Invites that can still be used."""
    from agentrob.board.admin import management

    for i in looked_up(config, management.invites):
        typer.echo(f"{i.id}\t{i.role}\t{i.left} left\tuntil {i.expires_at:%Y-%m-%d %H:%M} UTC")


@invite_cli.command("revoke")
def invite_revoke(invite: str, config: ConfigFile = None) -> None:
    """Nobody uses it any more."""
    _do(config, "revoke_invite", invite)
    typer.echo("revoked")


def _moderate(config: Path | None, deed: str, *args: Any) -> Any:
    """As the shell: an account that is in no table, only in the log."""
    from agentrob.board.admin import moderation
    from agentrob.board.admin.audit import SHELL
    from agentrob.board.content import writes
    from agentrob.model import Account

    shell = Account("0", SHELL, role=Role.ADMIN)
    run = writes.remove if deed == "hide" else getattr(moderation, deed)
    return in_transaction(settings_of(config), lambda t: run(t, shell, *args))


@moderate_cli.command("read")
def read(post: str, config: ConfigFile = None) -> None:
    """What a post says or said before it was hidden, and its earlier texts."""
    from agentrob.board.admin import moderation

    found, versions, hidden_by = looked_up(config, lambda reader: moderation.hidden(reader, post))
    typer.echo(f"{found.author.name}{f', hidden by {hidden_by}' if hidden_by else ''}: {found.raw}")
    for version in versions:
        typer.echo(f"until {version.until:%Y-%m-%d %H:%M:%S} UTC: {version.raw}")


@moderate_cli.command("hide")
def hide(post: str, reason: Reason = "", config: ConfigFile = None) -> None:
    """Hide a post; nothing of it is lost."""
    _moderate(config, "hide", post, reason)


@moderate_cli.command("show")
def show(post: str, reason: Reason = "", config: ConfigFile = None) -> None:
    """Show a hidden post again."""
    _moderate(config, "show", post, reason)


@moderate_cli.command("lock")
def lock(
    topic: str,
    locked: Annotated[bool, typer.Option("--lock/--unlock")] = True,
    reason: Reason = "",
    config: ConfigFile = None,
) -> None:
    """Lock a topic, or open it again."""
    _moderate(config, "lock", topic, locked, reason)


@moderate_cli.command("move")
def move(topic: str, board: str, reason: Reason = "", config: ConfigFile = None) -> None:
    """Put a topic on another board."""
    _moderate(config, "move", topic, board, reason)


def add_to(board: typer.Typer, account: typer.Typer) -> None:
    """Put these words into the command line."""
    account.command("list")(account_list)
    account.command("password")(account_password)
    account.command("sign-out")(account_sign_out)
    account.command("erase")(account_erase)
    account.command("tokens")(account_tokens)
    account.command("display")(account_display)
    account.command("revoke-one")(account_revoke_one)
    groups = {"boards": boards_cli, "robot": robot_cli, "invite": invite_cli, "moderate": moderate_cli}
    for name, group in groups.items():
        board.add_typer(group, name=name)
