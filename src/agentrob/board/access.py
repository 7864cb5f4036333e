"""Authenticates requests and checks rights: sessions, bearer tokens, CSRF tokens and roles, as endpoint dependencies.

Endpoints declare `AnyViewer`, `ReadingViewer` or one of the accounts below. Pages also call `check_form` after reading
a form, and `keep` when they show a form to a viewer who is not signed in, so that the cookie of its token is kept.
`sign_in`, `sign_up` and `enter` return a session for `set_session`.
"""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import re
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Request
from starlette.responses import Response

from agentrob.board.admin import management
from agentrob.board.auth import accounts, attempts, visibility
from agentrob.board.db.writer import Transaction
from agentrob.board.services import Services, get_services
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

_SECRET = re.compile(r"[A-Za-z0-9_-]{43}")


@dataclass(frozen=True, slots=True)
class Viewer:
    """The sender of a request; `account` is None if not signed in. `csrf` goes into forms as the field `csrf`, and into
    a meta tag for scripts, which send it as `X-CSRF-Token`. `secret` is the cookie's value or the bearer token."""

    account: Account | None
    csrf: str
    secret: str
    by_token: bool = False
    scopes: frozenset[str] = frozenset(accounts.SCOPES)


async def viewer(request: Request) -> Viewer:
    """The viewer, signed in or not. Limits the store to the boards they may read. 401 for a bad bearer token."""
    who = _viewer(request)
    parts = get_services(request)
    boards = parts.store.everything.all_boards()
    visibility.set_readable_boards(visibility.boards_readable_by(boards, who.account, parts.settings.public_read))
    return who


def _viewer(request: Request) -> Viewer:
    parts = get_services(request)
    if (header := request.headers.get("authorization")) is not None:
        scheme, _, token = header.partition(" ")
        found = accounts.token_of(parts.store.reader, token) if scheme.lower() == "bearer" else None
        if found is None:
            raise BoardError(401, "bad_token", "that token is not valid", "agentrob board account token NAME makes one")
        return Viewer(found[0], "", token, by_token=True, scopes=found[1])
    secret = request.cookies.get(parts.settings.cookie, "")
    if not _SECRET.fullmatch(secret):
        secret = accounts.new_secret()
        return Viewer(None, csrf_token(secret), secret)
    return Viewer(accounts.by_session(parts.store.reader, secret), csrf_token(secret), secret)


async def reader(request: Request) -> Viewer:
    """A viewer who may read: signed in and not suspended, or anybody when `public_read` is set. Else 401, 403."""
    who = await viewer(request)
    if who.account is None and get_services(request).settings.public_read:
        return who
    account_of(who)
    return who


async def stopper(request: Request) -> Account:
    """An account that may stop robots: any that is not suspended, with any role and token scope. Else 401, 403."""
    who = await viewer(request)
    account = account_of(who)
    if not who.by_token:
        check_form(who, request.headers.get("x-csrf-token"))
    return account


async def member(request: Request) -> Account:
    """An account that may write: as `stopper`, and a token needs the scope `write`. Each action checks roles itself."""
    return await _scoped(request, "write")


async def moderator(request: Request) -> Account:
    """An account that may moderate: a moderator or admin; a token needs the scope `admin`."""
    account = await _scoped(request, "admin")
    return has_role(account, Role.MODERATOR)


async def administrator(request: Request) -> Account:
    """An account that may administer: an admin who is a person; a token needs the scope `admin`."""
    return has_role(await _scoped(request, "admin"), Role.ADMIN)


def has_role(account: Account, role: Role) -> Account:
    """The account if it has at least this role and is not a robot or monitoring agent (admins: a person). Else 403."""
    if account.role.rank < role.rank or account.kind in (AccountKind.ROBOT_AGENT, AccountKind.MONITORING_AGENT):
        raise BoardError(403, f"not_{role}", f"this needs the role {role}", "ask an admin")
    if role is Role.ADMIN and account.kind is not AccountKind.HUMAN:
        raise BoardError(403, "not_admin", "only people administer", "sign in as a person")
    return account


def check_robot_owner(account: Account, owner: str) -> None:
    """403 unless the account is a person who owns the robot or is an admin."""
    owns = account.role is Role.ADMIN or (bool(owner) and account.name == owner)
    if not owns or account.kind is not AccountKind.HUMAN:
        raise BoardError(403, "not_owner", "this is for the robot's owner and for admins", "ask an admin")


async def _scoped(request: Request, scope: str) -> Account:
    who = await viewer(request)
    account = account_of(who)
    if scope not in who.scopes:
        raise BoardError(
            403, "token_scope", f"this token lacks the scope {scope}", f"use a token with the scope {scope}"
        )
    if not who.by_token:
        check_form(who, request.headers.get("x-csrf-token"))
    return account


def check_form(viewer: Viewer, token: object) -> None:
    """403 unless the form's CSRF token is the viewer's. Call it before using any other field.

    Requests with a bearer token are refused: only the API checks the scopes of tokens.
    """
    if viewer.by_token:
        raise BoardError(403, "no_forms", "forms are for browsers", "use the API")
    if not isinstance(token, str) or not hmac.compare_digest(token.encode("utf-8", "replace"), viewer.csrf.encode()):
        raise BoardError(403, "bad_csrf", "the form is too old or not from this forum", "load the page again")


def account_of(viewer: Viewer) -> Account:
    """The viewer's account. 401 when nobody is signed in, 403 when the account is suspended."""
    if viewer.account is None:
        raise BoardError(401, "not_signed_in", "sign in first", "a session cookie or Authorization: Bearer <token>")
    if viewer.account.suspended:
        raise BoardError(403, "suspended", "this account is suspended", "ask an admin")
    return viewer.account


# -------------------------------------------------------------------- parameters of endpoints
#: Any viewer, signed in or not.
AnyViewer = Annotated[Viewer, Depends(viewer)]
#: A viewer who may read.
ReadingViewer = Annotated[Viewer, Depends(reader)]
#: Accounts that may stop robots, write, moderate, administer.
Stopper = Annotated[Account, Depends(stopper)]
Member = Annotated[Account, Depends(member)]
Moderator = Annotated[Account, Depends(moderator)]
Administrator = Annotated[Account, Depends(administrator)]


# -------------------------------------------------------------------- sessions
async def sign_in(services: Services, name: str, password: str, address: str) -> str:
    """Create a session. 401 with one message for a wrong name and a wrong password, 429 after too many attempts."""
    await _check_password(services, name, password, address)
    account = services.store.reader.account(name.strip())
    if account is None or account.suspended:
        raise BoardError(403, "suspended", "this account is suspended", "ask an admin")
    return await services.store.do(lambda t: accounts.new_session(t.connection, int(account.id)))


async def _check_password(services: Services, name: str, password: str, address: str) -> None:
    await _record_attempt(services, name, address)
    await asyncio.sleep(attempts.delay_s(services.store.reader, name))
    row = services.store.reader.first(accounts.password_of(name))
    async with services.hashing:
        right = await asyncio.to_thread(accounts.verify_password, row.password_hash if row else None, password)
    if row is None or not right:
        raise BoardError(401, "wrong_password", "that name or password is wrong", "try again, or ask an admin")
    await services.store.do(lambda t: attempts.clear(t.connection, name, address))


async def _record_attempt(services: Services, name: str, address: str) -> None:
    attempts.check(services.store.reader, name, address)  # refuses a flood without writing
    await services.store.do(lambda t: attempts.record(t.connection, name, address))


async def sign_up(services: Services, name: str, password: str, address: str, invite: str = "") -> str:
    """Create an account, a member or with the rights of the invite, and a session. 403 when sign-up is off and there is
    no invite, 404 when the invite is void, 409 when the name is taken, 422, 429."""
    if not services.settings.sign_up and not invite:
        raise BoardError(403, "sign_up_off", "this forum does not take new accounts by itself", "ask an admin")
    await _record_attempt(services, "", address)
    name = accounts.checked_name(name)
    async with services.hashing:
        password_hash = await asyncio.to_thread(accounts.hash_password, password)

    def make(t: Transaction) -> str:
        if not invite:  # rolled back with the transaction if it fails
            attempts.record_sign_up(t.connection, address, services.settings.limits.sign_ups)
        used = management.spend_invite(t.connection, invite) if invite else None
        made = management.add_account(
            t.connection,
            name,
            name,
            role=used.role if used else Role.MEMBER,
            password_hash=password_hash,
            commands_simulated=used is not None and used.commands_simulated,
        )
        return accounts.new_session(t.connection, int(made.id))

    return await services.store.do(make)


async def new_password(services: Services, secret: str, password: str, address: str) -> str:
    """Set a new password by a one-time link; return a session and end all others. 404 for a void link, 422, 429."""
    await _record_attempt(services, "", address)
    async with services.hashing:
        password_hash = await asyncio.to_thread(accounts.hash_password, password)
    return await services.store.do(lambda t: accounts.spend_password_link(t.connection, secret, password_hash))


async def change_password(services: Services, account: Account, old: str, new: str, address: str) -> str:
    """Change a password, given the old one if there is one; return a session and end all others. 401, 422, 429."""
    if has_password(services, account):
        await _check_password(services, account.name, old, address)
    else:
        await _record_attempt(services, account.name, address)
    async with services.hashing:
        password_hash = await asyncio.to_thread(accounts.hash_password, new)
    return await services.store.do(lambda t: accounts.set_password(t.connection, int(account.id), password_hash))


def has_password(services: Services, account: Account) -> bool:
    """Whether an account can sign in by a password; one that was made for links has none at first."""
    row = services.store.reader.first(accounts.password_of(account.name))
    return row is not None and row.password_hash is not None


async def enter(services: Services, secret: str) -> str:
    """Use a one-time link; return a session. 404 when the link is unknown, used or expired."""
    return await services.store.do(lambda t: accounts.spend_link(t.connection, secret))


async def sign_out(services: Services, viewer: Viewer, response: Response) -> None:
    """End the session and drop its cookie."""
    await services.store.do(lambda t: accounts.end_session(t.connection, viewer.secret))
    response.delete_cookie(services.settings.cookie, path="/", secure=services.settings.secure, httponly=True)


def set_session(response: Response, services: Services, session: str) -> None:
    """Put the session's cookie on the response."""
    response.set_cookie(
        services.settings.cookie,
        session,
        max_age=accounts.SESSION_DAYS * 24 * 3600,
        path="/",
        secure=services.settings.secure,
        httponly=True,
        samesite="lax",
    )


def keep(response: Response, services: Services, viewer: Viewer) -> None:
    """Set the cookie that an anonymous viewer's form token belongs to.

    A viewer without a secret could not be identified because the database cannot be read; they may be signed in, so
    the cookie is left alone.
    """
    if viewer.account is None and not viewer.by_token and viewer.secret:
        set_session(response, services, viewer.secret)


def csrf_token(secret: str) -> str:
    """The CSRF token of a session: derived from its secret, which it does not reveal."""
    return hmac.new(secret.encode(), b"csrf", hashlib.sha256).hexdigest()
