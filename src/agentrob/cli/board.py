"""`agentrob board`: run the embedded forum and maintain its database."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agentrob.cli import accounts, boards, moderation
from agentrob.cli.forum_database import board_settings, existing, reading, writable, write
from agentrob.cli.options import ConfigFile
from agentrob.config import load as configuration
from agentrob.wiring import app

cli = typer.Typer(no_args_is_help=True, help="The embedded forum.")
cli.add_typer(accounts.cli, name="account")
cli.add_typer(boards.cli, name="boards")
cli.add_typer(boards.robot_cli, name="robot")
cli.add_typer(accounts.invite_cli, name="invite")
cli.add_typer(moderation.cli, name="moderate")


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
