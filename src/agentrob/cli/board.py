"""`agentrob init` and `agentrob board`: run the embedded forum and maintain its database."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agentrob.cli import accounts, boards, moderation
from agentrob.cli.forum_database import board_settings, existing, reading, writable, write
from agentrob.cli.options import ConfigFile
from agentrob.config import load as configuration
from agentrob.config.section import DEFAULT_LISTEN
from agentrob.errors import ConfigError
from agentrob.model import Role
from agentrob.wiring import app

cli = typer.Typer(no_args_is_help=True, help="The embedded forum.")
cli.add_typer(accounts.cli, name="account")
cli.add_typer(boards.cli, name="boards")
cli.add_typer(boards.robot_cli, name="robot")
cli.add_typer(accounts.invite_cli, name="invite")
cli.add_typer(moderation.cli, name="moderate")


def init(
    admin: Annotated[str, typer.Option(help="The handle of the first admin.")],
    url: Annotated[str, typer.Option(help="The address that browsers see, such as https://forum.example.org.")] = "",
    listen: Annotated[str, typer.Option(help="Host and port where the forum listens.")] = DEFAULT_LISTEN,
    title: Annotated[str, typer.Option(help="The name of the forum.")] = "AgentRob",
    data: Annotated[str, typer.Option(help="The data folder.")] = "",
    database: Annotated[str, typer.Option(help="A database URL. [default: SQLite in the data folder]")] = "",
    invites: Annotated[int, typer.Option(min=0, max=1000, help="How many people one invite admits.")] = 0,
    config: Annotated[Path, typer.Option("--config", "-c", help="The file to write.")] = Path("agentrob.toml"),
) -> None:
    """Create a forum: configuration file, database, first admin, and a link to set the admin's password."""
    from agentrob.board.admin import management
    from agentrob.board.admin.local_admin import bootstrap, writing
    from agentrob.board.db.audit import SHELL
    from agentrob.model import AccountKind

    if config.exists():
        raise ConfigError(f"{config} already exists; to add an admin: agentrob board account add NAME --role admin")
    board = {"listen": listen, "base_url": url, "title": title, "database": database, "sign_up": False}
    made = configuration.parse({"data": data, "board": board}, "agentrob init")
    settings = board_settings(made)
    bootstrap(settings)
    with writing(settings) as connection:
        management.add_account(connection, SHELL, admin, kind=AccountKind.HUMAN, role=Role.ADMIN)
        link = management.link(connection, SHELL, admin, "password")
        invite = management.invite(connection, SHELL, Role.MEMBER, invites, 30) if invites else ""
    made.write(config, "Written by agentrob init. docs/deploy.md describes further settings.")
    typer.echo(f"configuration: {config}\ndatabase: {settings.database_shown}")
    typer.echo(f"set the password of {admin}, once, within a day: {settings.base_url}{link}")
    if invite:
        typer.echo(f"invite {invites} members within 30 days: {settings.base_url}{invite}")
    typer.echo(f"then: agentrob board serve --config {config}")


@cli.command()
def serve(config: ConfigFile = None) -> None:
    """Run the embedded forum."""
    app.serve_board(app.load(config))


@cli.command()
def backup(file: Annotated[Path, typer.Argument(help="The new file.")], config: ConfigFile = None) -> None:
    """Write the whole forum into one file. The forum may be running."""
    from agentrob.board.admin.backup import backup as save

    typer.echo(_counted(save(existing(config), file)))


@cli.command()
def restore(file: Annotated[Path, typer.Argument(help="The backup.")], config: ConfigFile = None) -> None:
    """Restore a backup into an empty database, SQLite or PostgreSQL. The forum must not be running."""
    from agentrob.board.admin.backup import restore as load
    from agentrob.board.admin.serving_lock import exclusive_access

    settings = board_settings(configuration.load(config))
    with exclusive_access(settings):
        typer.echo(_counted(load(settings, file)))


@cli.command()
def export(
    file: Annotated[Path, typer.Argument(help="The new file.")],
    account: Annotated[str | None, typer.Option(help="Only posts of this account.")] = None,
    config: ConfigFile = None,
) -> None:
    """Export posts and pictures, without secrets, as JSON and image files in a tar archive."""
    from agentrob.board.admin.backup import export as save

    typer.echo(f"{save(existing(config), file, account)} posts")


@cli.command()
def migrate(
    to: Annotated[str, typer.Option(help="The revision; may be an earlier one.")] = "head",
    config: ConfigFile = None,
) -> None:
    """Migrate the database to this version, or back to an earlier one. The forum must not be running."""
    from agentrob.board.admin.serving_lock import exclusive_access
    from agentrob.board.db.database import migrate as run

    settings = board_settings(configuration.load(config))
    with exclusive_access(settings):
        run(settings, to, alone=True)
    typer.echo(f"the database is at revision {to}")


@cli.command()
def audit(
    target: Annotated[str | None, typer.Option(help="Only entries about this object, such as account:ann.")] = None,
    limit: Annotated[int, typer.Option(min=1, max=10000, help="How many entries.")] = 50,
    config: ConfigFile = None,
) -> None:
    """List the audit log (who changed what), newest first."""
    from agentrob.board.db import audit as log

    with reading(config) as connection:
        rows = connection.execute(log.statement(None, limit, target)).all()
    for row in rows:
        e = log.entry(row)
        details = " ".join(f"{k}={v}" for k, v in e.detail.items())
        typer.echo(f"{e.at:%Y-%m-%d %H:%M:%S} {e.actor} {e.action} {e.target} {details}".rstrip())


@cli.command()
def expire(config: ConfigFile = None) -> None:
    """Delete camera pictures older than their robots' `camera_days`. A running forum does this every hour."""
    from agentrob.board.admin import moderation as pictures

    settings = writable(config)
    digests = write(settings, pictures.expire_pictures)
    taken = write(settings, lambda t: pictures.take_away(t, settings.images_dir, digests))
    typer.echo(f"{len(digests)} pictures expired, {taken} files deleted")


def _counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{n} {name}" for name, n in counts.items() if n) or "nothing"
