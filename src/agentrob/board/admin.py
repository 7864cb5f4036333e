"""What the command line and the demo do to the forum's database, before the server starts or while it runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import Connection, insert, select
from sqlalchemy.exc import DBAPIError

from agentrob.board import accounts
from agentrob.board import schema as db
from agentrob.board.database import migrate, open_engine, unavailable
from agentrob.board.reader import Reader, not_found
from agentrob.board.settings import BoardSettings
from agentrob.model import Account, AccountKind, Role

#: Made when there is no board at all: id, name, description.
FIRST_BOARDS = (
    ("robots", "Robots", "Ask a robot to do something: mention it by name."),
    ("talk", "Talk", "Everything else. No robot acts here."),
)


def bootstrap(settings: BoardSettings) -> None:
    """Make or migrate the database; the first boards when there are none. Doing it again does nothing."""
    migrate(settings)
    with _writing(settings) as connection:
        if connection.execute(select(db.boards.c.id).limit(1)).first() is None:
            rows = [dict(zip(("id", "name", "description"), b, strict=True)) for b in FIRST_BOARDS]
            connection.execute(insert(db.boards), [row | {"position": n} for n, row in enumerate(rows)])


def create_account(
    settings: BoardSettings,
    name: str,
    *,
    kind: AccountKind = AccountKind.HUMAN,
    role: Role = Role.MEMBER,
    password: str | None = None,
    display_name: str = "",
) -> Account:
    """A new account. `BoardError` 409 when the name is taken, 422 when name or password cannot be."""
    password_hash = accounts.hash_password(password) if password is not None else None
    with _writing(settings) as connection:
        return accounts.create(
            connection, name, kind=kind, role=role, password_hash=password_hash, display_name=display_name
        )


def find_account(settings: BoardSettings, name: str) -> Account:
    """The account of that name. `BoardError` 404."""
    with _writing(settings) as connection:
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
    password: str | None = None,
) -> None:
    """Change what is given."""
    values: dict[str, object] = {}
    if role is not None:
        values["role"] = str(role)
    if suspended is not None:
        values["suspended"] = suspended
    if password is not None:
        values["password_hash"] = accounts.hash_password(password)
    if values:
        with _writing(settings) as connection:
            accounts.change(connection, account, **values)


def issue_token(settings: BoardSettings, account: Account, label: str = "") -> str:
    """A bearer token for a program. Only its hash is kept: it cannot be shown again."""
    with _writing(settings) as connection:
        return accounts.new_token(connection, account, label)


def revoke_tokens(settings: BoardSettings, account: Account, label: str | None = None) -> int:
    """End the account's bearer tokens at once, with a label only those of that label; returns how many were ended."""
    with _writing(settings) as connection:
        return accounts.revoke_tokens(connection, account, label)


def issue_link(settings: BoardSettings, account: Account) -> str:
    """The path of a page that signs in once, within ten minutes: put `settings.base_url` before it."""
    with _writing(settings) as connection:
        return "/enter/" + accounts.new_link(connection, account)


@contextmanager
def _writing(settings: BoardSettings) -> Iterator[Connection]:
    engine = open_engine(settings, writes=True)
    try:
        with engine.begin() as connection:
            yield connection
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()
