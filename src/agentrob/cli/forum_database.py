"""Access to the embedded forum's database for commands, while its server may be running."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from agentrob.config import load as configuration
from agentrob.config.load import Config
from agentrob.errors import ConfigError

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from agentrob.board.db.reader import Reader
    from agentrob.board.db.writer import Transaction
    from agentrob.board.settings import BoardSettings

T = TypeVar("T")


def board_settings(loaded: Config) -> BoardSettings:
    """The board's settings; the database may not exist yet."""
    from agentrob.board.settings import BoardSettings

    return BoardSettings.from_config(loaded.board, loaded.data_dir)


def writable(config: Path | None) -> BoardSettings:
    """The settings of a board whose database is created if there is none.

    A database of another version is not migrated, since a server of that version may be running: `BoardError` 409.
    """
    from agentrob.board.admin import local_admin

    settings = board_settings(configuration.load(config))
    local_admin.ensure_database(settings)
    return settings


def existing(config: Path | None) -> BoardSettings:
    """The settings of a board whose database exists and has this version. Changes nothing.

    Raises `ConfigError` if there is no database, `BoardError` 409 if it has another version.
    """
    from agentrob.board.db.database import check_version

    settings = board_settings(configuration.load(config))
    if not check_version(settings):
        what = f"there is no forum in {settings.database_shown}"
        raise ConfigError(f"{what}; name its configuration with --config, or create one: agentrob init")
    return settings


@contextmanager
def reading(config: Path | None) -> Iterator[Connection]:
    """A connection to an existing database that takes no write lock. Raises as `existing`, and `BoardError` 503."""
    from sqlalchemy.exc import DBAPIError

    from agentrob.board.db.database import open_engine, unavailable

    engine = open_engine(existing(config), writes=False)
    try:
        with engine.connect() as connection:
            yield connection
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()


def read(config: Path | None, query: Callable[[Reader], T]) -> T:
    """The result of a query on the database. Raises as `reading`."""
    from agentrob.board.db.reader import Reader

    with reading(config) as connection:
        return query(Reader(connection))


def write(settings: BoardSettings, change: Callable[[Transaction], T]) -> T:
    """Make a change in one transaction. A running server waits for its end, so print afterwards."""
    from agentrob.board.admin import local_admin
    from agentrob.board.db.writer import Transaction

    with local_admin.writing(settings) as connection:
        return change(Transaction(connection))


def administer(config: Path | None, action: str, *args: Any, **options: Any) -> Any:
    """Run one function of `board.admin.management` as the shell, in one transaction."""
    from agentrob.board.admin import local_admin, management
    from agentrob.board.db.audit import SHELL

    with local_admin.writing(writable(config)) as connection:
        return getattr(management, action)(connection, SHELL, *args, **options)
