"""The words a person types to run the embedded forum: `agentrob init`, backups, migrations, the log."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from agentrob.config import load as configuration
from agentrob.config.load import Config
from agentrob.config.section import DEFAULT_LISTEN
from agentrob.errors import ConfigError
from agentrob.model import Role

if TYPE_CHECKING:
    from agentrob.board.db.reader import Reader
    from agentrob.board.db.writer import Transaction
    from agentrob.board.settings import BoardSettings

T = TypeVar("T")
ConfigFile = Annotated[Path | None, typer.Option("--config", "-c", help="Configuration file. [default: agentrob.toml]")]


def settings_of(config: Path | None) -> BoardSettings:
    """The board's settings, its database made when there is none. One of another version is never changed here, since
    a server of that version may be running."""
    from agentrob.board.admin import local_admin

    settings = _settings(configuration.load(config))
    local_admin.ensure_database(settings)
    return settings


def _settings_to_read(config: Path | None) -> BoardSettings:
    """The settings of a board whose database is there, of this version, and is not changed."""
    from agentrob.board.db.database import check_version

    settings = _settings(configuration.load(config))
    if not check_version(settings):
        what = f"there is no forum in {settings.database_shown}"
        raise ConfigError(f"{what}; name its configuration with --config, or begin one: agentrob init")
    return settings


# ---------------------------------------------------------------------- init
def init(
    admin: Annotated[str, typer.Option(help="The handle of the first admin.")],
    url: Annotated[str, typer.Option(help="The address that browsers see, as https://forum.example.org.")] = "",
    listen: Annotated[str, typer.Option(help="Where the forum listens.")] = DEFAULT_LISTEN,
    title: Annotated[str, typer.Option(help="What the forum is called.")] = "AgentRob",
    data: Annotated[str, typer.Option(help="Where everything is kept.")] = "",
    database: Annotated[str, typer.Option(help="A database URL. [default: SQLite in the data folder]")] = "",
    invites: Annotated[int, typer.Option(min=0, max=1000, help="How many people one invite lets in.")] = 0,
    config: Annotated[Path, typer.Option("--config", "-c", help="The file to write.")] = Path("agentrob.toml"),
) -> None:
    """Begin a forum: a configuration file, the database, the first admin, and a link to set the admin's password."""
    from agentrob.board.admin import management
    from agentrob.board.admin.audit import SHELL
    from agentrob.board.admin.local_admin import bootstrap, writing
    from agentrob.board.settings import BoardSettings
    from agentrob.model import AccountKind

    if config.exists():
        raise ConfigError(f"{config} is there already; to add an admin: agentrob board account add NAME --role admin")
    board = {"listen": listen, "base_url": url, "title": title, "database": database, "sign_up": False}
    made = configuration.parse({"data": data, "board": board}, "agentrob init")
    settings = BoardSettings.from_config(made.board, made.data_dir)
    bootstrap(settings)
    with writing(settings) as connection:
        management.add_account(connection, SHELL, admin, kind=AccountKind.HUMAN, role=Role.ADMIN)
        link = management.link(connection, SHELL, admin, "password")
        invite = management.invite(connection, SHELL, Role.MEMBER, invites, 30) if invites else ""
    made.write(config, "Written by agentrob init. docs/deploy.md says what else may stand here.")
    typer.echo(f"configuration: {config}\ndatabase: {settings.database_shown}")
    typer.echo(f"set the password of {admin}, once, within a day: {settings.base_url}{link}")
    if invite:
        typer.echo(f"invite {invites} members within 30 days: {settings.base_url}{invite}")
    typer.echo(f"then: agentrob board serve --config {config}")


# ---------------------------------------------------------------------- backup
def backup(file: Annotated[Path, typer.Argument(help="The new file.")], config: ConfigFile = None) -> None:
    """Write the whole forum into one file, while it runs or not."""
    from agentrob.board.admin.backup import backup as write

    typer.echo(_counted(write(_settings_to_read(config), file)))


def restore(file: Annotated[Path, typer.Argument(help="The backup.")], config: ConfigFile = None) -> None:
    """Put a backup into an empty database, of whichever kind. The forum must not be running."""
    from agentrob.board.admin.backup import restore as read
    from agentrob.board.db.serving_lock import alone

    loaded = configuration.load(config)
    settings = _settings(loaded)
    with alone(settings):
        typer.echo(_counted(read(settings, file)))


def export(
    file: Annotated[Path, typer.Argument(help="The new file.")],
    account: Annotated[str | None, typer.Option(help="Only what this account wrote.")] = None,
    config: ConfigFile = None,
) -> None:
    """Write what people wrote, without secrets, as JSON files and pictures in a tar."""
    from agentrob.board.admin.backup import export as write

    typer.echo(f"{write(_settings_to_read(config), file, account)} posts")


def migrate(
    to: Annotated[str, typer.Option(help="A revision, also an earlier one.")] = "head", config: ConfigFile = None
) -> None:
    """Bring the tables to the shape of this version, or back to an earlier one before going back to it."""
    from agentrob.board.db.database import migrate as run
    from agentrob.board.db.serving_lock import alone

    settings = _settings(configuration.load(config))
    with alone(settings):
        run(settings, to, alone=True)
    typer.echo(f"the tables are at {to}")


def _settings(loaded: Config) -> BoardSettings:
    from agentrob.board.settings import BoardSettings

    return BoardSettings.from_config(loaded.board, loaded.data_dir)


def _counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{n} {name}" for name, n in counts.items() if n) or "nothing"


def audit(
    target: Annotated[str | None, typer.Option(help="Only of this, as account:ann.")] = None,
    limit: Annotated[int, typer.Option(min=1, max=10000)] = 50,
    config: ConfigFile = None,
) -> None:
    """Who changed what, newest first."""
    from agentrob.board.admin import audit as log

    statement = log.statement(None, limit, target)
    for row in in_transaction(_settings_to_read(config), lambda t: t.connection.execute(statement).all()):
        e = log.entry(row)
        details = " ".join(f"{k}={v}" for k, v in e.detail.items())
        typer.echo(f"{e.at:%Y-%m-%d %H:%M:%S} {e.actor} {e.action} {e.target} {details}".rstrip())


def expire(config: ConfigFile = None) -> None:
    """Delete camera pictures that are older than their robots' owners keep them; a running forum does so each hour."""
    from agentrob.board.admin import moderation

    settings = settings_of(config)
    digests = in_transaction(settings, moderation.expire_pictures)
    taken = in_transaction(settings, lambda t: moderation.take_away(t, settings.images_dir, digests))
    typer.echo(f"{len(digests)} pictures expired, {taken} files deleted")


def in_transaction(settings: BoardSettings, job: Callable[[Transaction], T]) -> T:
    """Run a job of the writer here, beside a server that may be running, which waits for its end: print afterwards."""
    from agentrob.board.admin import local_admin
    from agentrob.board.db.writer import Transaction

    with local_admin.writing(settings) as connection:
        return job(Transaction(connection))


def looked_up(config: Path | None, read: Callable[[Reader], T]) -> T:
    """What is in the forum's database now."""
    from agentrob.board.db.reader import Reader

    return in_transaction(_settings_to_read(config), lambda t: read(Reader(t.connection)))


def add_to(cli: typer.Typer, board: typer.Typer) -> None:
    """Put these words into the command line."""
    cli.command()(init)
    for word in (backup, restore, export, migrate, audit, expire):
        board.command()(word)
