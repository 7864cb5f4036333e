"""Administer the forum's database directly, for the command line and the demo; a server may be running."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from sqlalchemy import Connection, insert, select
from sqlalchemy.exc import DBAPIError

from agentrob.board.admin import management
from agentrob.board.auth import accounts, rights
from agentrob.board.db import audit
from agentrob.board.db import schema as db
from agentrob.board.db.audit import SHELL
from agentrob.board.db.database import check_version, migrate, open_engine, unavailable
from agentrob.board.db.reader import Reader, not_found
from agentrob.board.settings import BoardSettings
from agentrob.model import Account, AccountKind, Role

#: The boards of a new forum: id, name, description.
FIRST_BOARDS = (
    ("robots", "Robots", "Ask a robot to do something: mention it by name."),
    ("talk", "Talk", "Everything else. No robot acts here."),
)


def bootstrap(settings: BoardSettings, *, alone: bool = False) -> None:
    """Create or migrate the database, and create the first boards if there are none. Repeating it does nothing.

    409 if a process serves a database of another version; with `alone` the caller knows that none does.
    """
    migrate(settings, alone=alone)
    with writing(settings) as connection:
        if connection.execute(select(db.boards.c.id).limit(1)).first() is None:
            rows = [dict(zip(("id", "name", "description"), b, strict=True)) for b in FIRST_BOARDS]
            connection.execute(insert(db.boards), [row | {"position": n} for n, row in enumerate(rows)])


def ensure_database(settings: BoardSettings) -> None:
    """Create the database if there is none. 409 for one of another version, which is not changed."""
    if not check_version(settings):
        bootstrap(settings)


def create_account(
    settings: BoardSettings,
    name: str,
    *,
    kind: AccountKind = AccountKind.HUMAN,
    role: Role = Role.MEMBER,
    password: str | None = None,
    display_name: str = "",
) -> Account:
    """Create an account. 409 if the name is taken, 422 if name or password are not valid."""
    password_hash = accounts.hash_password(password) if password is not None else None
    with writing(settings) as connection:
        return management.add_account(
            connection, SHELL, name, kind=kind, role=role, password_hash=password_hash, display_name=display_name
        )


def find_account(settings: BoardSettings, name: str) -> Account:
    """The account of that name. `BoardError` 404."""
    with writing(settings) as connection:
        account = Reader(connection).account(name)
    if account is None:
        raise not_found("account", name)
    return account


def change_account(
    settings: BoardSettings,
    account: Account,
    *,
    role: Role | None = None,
    suspended: bool | None = None,
    commands_simulated: bool | None = None,
    password: str | None = None,
) -> None:
    """Change the given fields."""
    password_hash = accounts.hash_password(password) if password is not None else None
    with writing(settings) as connection:
        management.change_account(
            connection, SHELL, account.name, role=role, suspended=suspended, commands_simulated=commands_simulated
        )
        if password_hash is not None:
            accounts.set_password(connection, int(account.id), password_hash)


def claim_robot(settings: BoardSettings, name: str, owner: str) -> None:
    """Set the owner of a robot that has none."""
    with writing(settings) as connection:
        if not rights.settings_of(Reader(connection), name).owner:
            management.change_robot(connection, SHELL, name, owner=owner)


def issue_token(
    settings: BoardSettings, account: Account, label: str = "", scopes: Sequence[str] = ("read", "write")
) -> str:
    """Create a bearer token. Only its hash is stored, so it cannot be shown again."""
    with writing(settings) as connection:
        return management.add_token(connection, SHELL, account.name, label, scopes)


def revoke_tokens(settings: BoardSettings, account: Account, label: str | None = None) -> int:
    """Revoke the account's bearer tokens, or only those with a label; return their number."""
    with writing(settings) as connection:
        ended = accounts.revoke_tokens(connection, account, label)
        if ended:
            audit.note(connection, SHELL, "token.revoke", f"account:{account.name}", tokens=ended, label=label)
        return ended


def issue_link(settings: BoardSettings, account: Account) -> str:
    """Create a link that signs in once, within ten minutes; return its path below `settings.base_url`."""
    with writing(settings) as connection:
        return management.link(connection, SHELL, account.name, "enter")


@contextmanager
def writing(settings: BoardSettings) -> Iterator[Connection]:
    """A transaction on a connection of its own; a server may be running."""
    engine = open_engine(settings, writes=True)
    try:
        with engine.begin() as connection:
            yield connection
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()
