"""`agentrob board account` and `agentrob board invite`: accounts, tokens and invites of the embedded forum."""

from __future__ import annotations

from typing import Annotated

import typer

from agentrob.cli.forum_database import administer, read, writable, write
from agentrob.cli.options import ConfigFile, Handle
from agentrob.errors import AgentRobError
from agentrob.model import AccountKind, Role
from agentrob.wiring import app

cli = typer.Typer(no_args_is_help=True, help="Accounts of the embedded forum.")
invite_cli = typer.Typer(no_args_is_help=True, help="Links for people to create their own accounts.")


@cli.command("add")
def account_add(
    name: Annotated[str, typer.Argument(help="The handle after the @: lower-case letters, digits, - and _.")],
    kind: Annotated[AccountKind, typer.Option(help="Who uses it.")] = AccountKind.HUMAN,
    role: Annotated[Role, typer.Option(help="What it may do.")] = Role.MEMBER,
    config: ConfigFile = None,
) -> None:
    """Add an account; prints a one-time link (people) or a token (agents)."""
    settings = app.load(config)
    app.board_account(settings, name, kind, role)
    typer.echo(app.board_link(settings, name) if kind is AccountKind.HUMAN else app.board_token(settings, name))


@cli.command("change")
def account_change(
    name: Handle,
    role: Annotated[Role | None, typer.Option(help="What it may do from now on.")] = None,
    suspend: Annotated[
        bool | None, typer.Option("--suspend/--unsuspend", help="A suspended account can do nothing.")
    ] = None,
    simulated: Annotated[
        bool | None, typer.Option("--simulated/--no-simulated", help="Whether it may command simulated robots.")
    ] = None,
    config: ConfigFile = None,
) -> None:
    """Change an account's role or right to command simulated robots, suspend it, or end its suspension."""
    account = app.change_board_account(app.load(config), name, role, suspend, simulated)
    more = ", commands simulated robots" if account.commands_simulated else ""
    typer.echo(f"{account.name}: {account.kind}, {account.role}{more}{', suspended' if account.suspended else ''}")


@cli.command("list")
def account_list(config: ConfigFile = None) -> None:
    """List all accounts."""
    from agentrob.board.admin import management

    for a in read(config, lambda reader: management.all_accounts(reader, "", 1_000_000)):
        typer.echo(f"{a.name}\t{a.kind}\t{a.role}{chr(9) + 'suspended' if a.suspended else ''}")


@cli.command("link")
def account_link(name: Handle, config: ConfigFile = None) -> None:
    """Print a one-time link that signs this account in."""
    typer.echo(app.board_link(app.load(config), name))


@cli.command("password")
def account_password(name: Handle, config: ConfigFile = None) -> None:
    """Print a one-time link that sets a new password; using it ends earlier sessions."""
    typer.echo(writable(config).base_url + administer(config, "link", name, "password"))


@cli.command("sign-out")
def account_sign_out(name: Handle, config: ConfigFile = None) -> None:
    """End all sessions of an account."""
    typer.echo(f"{administer(config, 'sign_out_everywhere', name)} sessions ended")


@cli.command("display")
def account_display(
    name: Handle,
    shown: Annotated[str, typer.Argument(help="The display name; '' shows the handle alone.")],
    config: ConfigFile = None,
) -> None:
    """Set an account's display name."""
    typer.echo(f"{name}: {administer(config, 'change_account', name, display_name=shown).display_name}")


@cli.command("erase")
def account_erase(
    name: Handle,
    yes: Annotated[bool, typer.Option("--yes", help="Confirm.")] = False,
    config: ConfigFile = None,
) -> None:
    """Permanently delete all posts and pictures of an account."""
    from agentrob.board.admin import moderation
    from agentrob.board.db.audit import SHELL

    settings = writable(config)
    if not yes:
        raise AgentRobError(f"this permanently deletes all posts and pictures of {name}; confirm with --yes")
    posts, pictures, digests = write(settings, lambda t: moderation.erase(t, SHELL, name))
    write(settings, lambda t: moderation.take_away(t, settings.images_dir, digests))
    typer.echo(f"{posts} posts and {pictures} pictures of {name} are deleted")


# ---------------------------------------------------------------------- tokens
@cli.command("token")
def account_token(
    name: Handle,
    label: Annotated[str, typer.Option(help="What it is for.")] = "",
    scope: Annotated[list[str] | None, typer.Option(help="read, write, admin. [default: read write]")] = None,
    config: ConfigFile = None,
) -> None:
    """Print a new bearer token of this account."""
    typer.echo(app.board_token(app.load(config), name, label, tuple(scope or ("read", "write"))))


@cli.command("tokens")
def account_tokens(name: Handle, config: ConfigFile = None) -> None:
    """List the tokens of an account, without their secrets."""
    from agentrob.board.admin import management

    for t in read(config, lambda reader: management.tokens(reader, name)):
        state = "revoked" if t.revoked_at else "good"
        typer.echo(f"{t.id}\t{t.label or '-'}\t{'+'.join(t.scopes)}\t{t.created_at:%Y-%m-%d}\t{state}")


@cli.command("revoke")
def account_revoke(name: Handle, config: ConfigFile = None) -> None:
    """Revoke all bearer tokens of an account."""
    typer.echo(f"{app.revoke_board_tokens(app.load(config), name)} tokens of {name} are revoked")


@cli.command("revoke-one")
def account_revoke_one(
    token: Annotated[str, typer.Argument(help="The id of a token, as `tokens` lists it.")], config: ConfigFile = None
) -> None:
    """Revoke one token."""
    administer(config, "revoke_token", token)
    typer.echo("revoked")


# ---------------------------------------------------------------------- invites
@invite_cli.command("add")
def invite_add(
    role: Annotated[Role, typer.Option(help="What the new accounts may do.")] = Role.MEMBER,
    uses: Annotated[int, typer.Option(help="How many people may use it.")] = 1,
    days: Annotated[int, typer.Option(help="How many days it is valid.")] = 7,
    simulated: Annotated[bool, typer.Option("--simulated", help="They may command simulated robots.")] = False,
    config: ConfigFile = None,
) -> None:
    """Print a link for people to create their own accounts."""
    path = administer(config, "invite", role, uses, days, commands_simulated=simulated)
    typer.echo(writable(config).base_url + path)


@invite_cli.command("list")
def invite_list(config: ConfigFile = None) -> None:
    """List invites that can still be used."""
    from agentrob.board.admin import management

    for i in read(config, management.invites):
        typer.echo(f"{i.id}\t{i.label}\t{i.left} left\tuntil {i.expires_at:%Y-%m-%d %H:%M} UTC")


@invite_cli.command("revoke")
def invite_revoke(
    invite: Annotated[str, typer.Argument(help="The id of an invite, as `list` shows it.")], config: ConfigFile = None
) -> None:
    """Revoke an invite."""
    administer(config, "revoke_invite", invite)
    typer.echo("revoked")
