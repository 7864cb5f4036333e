"""Accounts and the secrets that prove them: passwords (argon2), sessions, bearer tokens, one-time sign-in links.

Secrets are 256 random bits; only their SHA-256 is kept, so a stolen database signs nobody in. All functions take a
connection, so that they work as jobs of the writer and in other processes (`admin`).
"""

from __future__ import annotations

import functools
import hashlib
import re
import secrets
from collections.abc import Collection
from typing import Any

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from sqlalchemy import Connection, Select, bindparam, delete, insert, select, update
from sqlalchemy.exc import IntegrityError

from agentrob.board.db import schema as db
from agentrob.board.db.reader import ACCOUNT, Reader
from agentrob.board.db.records import now_us
from agentrob.board.db.rows import account_from
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

#: Only ASCII, so that no name can look like another one.
NAME = re.compile(r"[a-z][a-z0-9_-]{1,31}")
PASSWORD_MIN, PASSWORD_MAX = 8, 200
SESSION_DAYS = 30
LINK_MINUTES = 10
#: Longer than for signing in, because an admin has to pass the link on to a person.
PASSWORD_LINK_MINUTES = 24 * 60
SCOPES = ("read", "write", "admin")
_MINUTE_US = 60_000_000

_hasher = PasswordHasher()
# Built once, because every request uses it.
_BY_SESSION = (
    ACCOUNT.add_columns(db.sessions.c.expires_us)
    .join(db.sessions, db.sessions.c.account_id == db.accounts.c.id)
    .where(db.sessions.c.hash == bindparam("hash"))
)
_BY_TOKEN = (
    ACCOUNT.add_columns(db.tokens.c.scopes)
    .join(db.tokens, db.tokens.c.account_id == db.accounts.c.id)
    .where(db.tokens.c.hash == bindparam("hash"), db.tokens.c.revoked_us.is_(None))
)


@functools.cache
def _nobody() -> str:
    """The hash that is verified when a name is unknown, so that the response time does not reveal which names exist.
    Made at the first sign-in: it takes 0.1 s and 64 MB, which processes that sign nobody in need not spend."""
    return _hasher.hash(secrets.token_hex())


# -------------------------------------------------------------------- accounts
def create(
    connection: Connection,
    name: str,
    *,
    kind: AccountKind = AccountKind.HUMAN,
    role: Role = Role.MEMBER,
    password_hash: str | None = None,
    display_name: str = "",
    commands_simulated: bool = False,
) -> Account:
    """Create an account; without a password it signs in by token or link only. 409 if the name is taken, 422 if not
    valid."""
    name = checked_name(name)
    row = {"name": name, "display_name": checked_display_name(display_name), "kind": str(kind), "role": str(role)}
    values = row | {"suspended": False, "password_hash": password_hash, "created_us": now_us()}
    values["commands_simulated"] = commands_simulated
    try:
        with connection.begin_nested():
            connection.execute(insert(db.accounts).values(**values))
    except IntegrityError:
        raise BoardError(
            409, "name_taken", f"an account named {name!r} exists already", "choose another name"
        ) from None
    return account_from(connection.execute(ACCOUNT.where(db.accounts.c.name == name)).one())


def checked_name(name: str) -> str:
    """The name in lower case. 422 if it is not valid."""
    folded = name.strip().lower()
    if not name.isascii() or not NAME.fullmatch(folded):
        hint = "2 to 32 of a-z, 0-9, _ and -, a letter first"
        raise BoardError(422, "bad_name", f"{name[:64]!r} cannot be a name", hint)
    return folded


def checked_display_name(name: str) -> str:
    """The name on one line. 422 if it has invisible characters."""
    name = " ".join(name.split())
    if len(name) > 64 or not name.isprintable():
        raise BoardError(422, "bad_display_name", "the display name is not valid", "at most 64 visible characters")
    return name


def change(connection: Connection, account: Account, **values: Any) -> None:
    """Set columns: `role`, `suspended`, `commands_simulated`, `password_hash`. A suspended account loses its
    sessions."""
    connection.execute(update(db.accounts).where(db.accounts.c.id == int(account.id)).values(**values))
    if values.get("suspended"):
        connection.execute(delete(db.sessions).where(db.sessions.c.account_id == int(account.id)))


# -------------------------------------------------------------------- passwords
def hash_password(password: str) -> str:
    """Hash a password; slow on purpose (tens of ms), so not on the event loop. 422 if it is too short or too long."""
    if not PASSWORD_MIN <= len(password) <= PASSWORD_MAX:
        hint = f"{PASSWORD_MIN} to {PASSWORD_MAX} characters"
        raise BoardError(422, "bad_password", "the password is too short or too long", hint)
    return _hasher.hash(password.encode("utf-8", "surrogatepass"))


def verify_password(password_hash: str | None, password: str) -> bool:
    """Return whether a password is correct; slow on purpose, and equally slow if the account has no password."""
    nobody = _nobody()  # whether or not it is needed: the first of all sign-ins may not reveal it either
    try:
        right = _hasher.verify(password_hash or nobody, password[:PASSWORD_MAX].encode("utf-8", "surrogatepass"))
    except (VerificationError, InvalidHashError):
        return False
    return right and password_hash is not None


def password_of(name: str) -> Select[Any]:
    """Selects account id and password hash of a name."""
    return select(db.accounts.c.id, db.accounts.c.password_hash).where(db.accounts.c.name == name.strip().lower()[:64])


# -------------------------------------------------------------------- secrets
def new_secret() -> str:
    return secrets.token_urlsafe(32)


def hash_of(secret: str) -> str:
    return hashlib.sha256(secret.encode("utf-8", "surrogatepass")).hexdigest()


def new_session(connection: Connection, account_id: int) -> str:
    """Create a session and return its secret. Also deletes expired sessions."""
    now, secret = now_us(), new_secret()
    connection.execute(delete(db.sessions).where(db.sessions.c.expires_us < now))
    values = {"hash": hash_of(secret), "account_id": account_id, "created_us": now}
    expires = now + SESSION_DAYS * 24 * 60 * _MINUTE_US
    connection.execute(insert(db.sessions).values(**values, expires_us=expires))
    return secret


def end_session(connection: Connection, secret: str) -> None:
    connection.execute(delete(db.sessions).where(db.sessions.c.hash == hash_of(secret)))


def by_session(reader: Reader, secret: str) -> Account | None:
    """The account that a session signs in."""
    digest = hash_of(secret)
    row = reader.kept(("session", digest), lambda: reader.first(_BY_SESSION, hash=digest), access=True)
    return account_from(row) if row and row.expires_us > now_us() else None


def new_token(
    connection: Connection, account: Account, label: str = "", scopes: Collection[str] = ("read", "write")
) -> str:
    """Create a bearer token and return its secret, which is not stored. 422 for an unknown scope.

    Every token can read and stop; `write` allows posts and uploads, `admin` moderation and administration, as far as
    the account itself may.
    """
    if not scopes or not set(scopes) <= set(SCOPES):
        raise BoardError(422, "bad_scopes", "unknown token scope", f"valid: {', '.join(SCOPES)}")
    secret = "agentrob_" + new_secret()
    values = {"hash": hash_of(secret), "account_id": int(account.id), "label": label[:64], "created_us": now_us()}
    named = " ".join(s for s in SCOPES if s in scopes or s == "read")
    connection.execute(insert(db.tokens).values(**values, scopes=named))
    return secret


def revoke_tokens(connection: Connection, account: Account, label: str | None = None) -> int:
    """Revoke an account's tokens, all or those with a label; return how many."""
    c = db.tokens.c
    ended = update(db.tokens).where(c.account_id == int(account.id), c.revoked_us.is_(None))
    if label is not None:
        ended = ended.where(c.label == label[:64])
    return connection.execute(ended.values(revoked_us=now_us())).rowcount


def by_token(reader: Reader, secret: str) -> Account | None:
    """The account that a bearer token signs in."""
    found = token_of(reader, secret)
    return found[0] if found else None


def token_of(reader: Reader, secret: str) -> tuple[Account, frozenset[str]] | None:
    """The account that a bearer token signs in, and the scopes of the token (`SCOPES`)."""
    digest = hash_of(secret)
    row = reader.kept(("token", digest), lambda: reader.first(_BY_TOKEN, hash=digest), access=True)
    return (account_from(row), frozenset(row.scopes.split())) if row else None


def new_link(connection: Connection, account: Account, purpose: str = "enter") -> str:
    """Create a one-time link that signs in within ten minutes, or sets a new password within a day; return its
    secret."""
    now, secret = now_us(), new_secret()
    connection.execute(delete(db.links).where(db.links.c.expires_us < now))
    minutes = PASSWORD_LINK_MINUTES if purpose == "password" else LINK_MINUTES
    values = {"account_id": int(account.id), "purpose": purpose, "expires_us": now + minutes * _MINUTE_US}
    connection.execute(insert(db.links).values(hash=hash_of(secret), **values))
    return secret


def spend_link(connection: Connection, secret: str) -> str:
    """Use a link and return a new session. 404 if it is unknown, used or expired."""
    return new_session(connection, _spend(connection, secret, "enter"))


def spend_password_link(connection: Connection, secret: str, password_hash: str) -> str:
    """Set a new password by a link; return a new session and end all others. 404 if the link is unknown, used or
    expired."""
    account_id = _spend(connection, secret, "password")
    return set_password(connection, account_id, password_hash)


def set_password(connection: Connection, account_id: int, password_hash: str) -> str:
    """Set a new password; return a new session and end all others, since one may be a thief's."""
    connection.execute(update(db.accounts).where(db.accounts.c.id == account_id).values(password_hash=password_hash))
    connection.execute(delete(db.sessions).where(db.sessions.c.account_id == account_id))
    connection.execute(delete(db.links).where(db.links.c.account_id == account_id, db.links.c.used_us.is_(None)))
    return new_session(connection, account_id)


def end_sessions(connection: Connection, account: Account) -> int:
    """End all sessions of an account; return their number."""
    return connection.execute(delete(db.sessions).where(db.sessions.c.account_id == int(account.id))).rowcount


def _spend(connection: Connection, secret: str, purpose: str) -> int:
    c, now = db.links.c, now_us()
    spent = update(db.links).where(
        c.hash == hash_of(secret), c.purpose == purpose, c.used_us.is_(None), c.expires_us > now
    )
    if connection.execute(spent.values(used_us=now)).rowcount != 1:
        hint = "ask for a new one: agentrob demo link" if purpose == "enter" else "ask an admin for a new one"
        raise BoardError(404, "no_such_link", "this link was used before or has expired", hint)
    return int(connection.execute(select(c.account_id).where(c.hash == hash_of(secret))).scalar_one())
